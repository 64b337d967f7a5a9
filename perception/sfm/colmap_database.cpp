#include "perception/sfm/colmap_database.h"

#include <sqlite3.h>

#include <cstdint>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "perception/sfm/colmap_files.h"

namespace cousin {
namespace {

constexpr std::int64_t kMostIds = 2147483647;  ///< a pair's id is first * kMostIds + second
constexpr std::int64_t kMostRows = 100000000;  ///< features or matches
constexpr int kMostText = 1 << 20;             ///< bytes of a value or a statement
/// Instructions of one query: a schema whose tables are endless queries must end too. 1000 images,
/// each matched with each, take some 10 million.
constexpr int kInstructionsAtOnce = 1000000, kMostTimes = 100;

struct Closer {
  void operator()(sqlite3* database) const { sqlite3_close(database); }
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};

class Database {
 public:
  explicit Database(const std::filesystem::path& file) : file_(file.string()) {
    sqlite3* opened = nullptr;
    const int status = sqlite3_open_v2(file_.c_str(), &opened, SQLITE_OPEN_READONLY, nullptr);
    database_.reset(opened);
    if (status != SQLITE_OK) refuse(opened != nullptr ? sqlite3_errmsg(opened) : "no memory");
    sqlite3_db_config(opened, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    sqlite3_db_config(opened, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
    sqlite3_limit(opened, SQLITE_LIMIT_LENGTH, kMostText);
    sqlite3_limit(opened, SQLITE_LIMIT_SQL_LENGTH, kMostText);
    sqlite3_progress_handler(
        opened, kInstructionsAtOnce,
        [](void* times) { return ++*static_cast<int*>(times) > kMostTimes ? 1 : 0; }, &times_);
  }

  [[noreturn]] void refuse(const std::string& why) const {
    throw std::runtime_error(file_ + ": " + why);
  }

  /// Calls `take` with the statement at each row of `sql`; its first column must be a whole number.
  template <class Take>
  void each(const char* sql, const Take& take) {
    times_ = 0;
    sqlite3_stmt* prepared = nullptr;
    if (sqlite3_prepare_v2(database_.get(), sql, -1, &prepared, nullptr) != SQLITE_OK)
      refuse(std::string("not a database of COLMAP: ") + sqlite3_errmsg(database_.get()));
    const std::unique_ptr<sqlite3_stmt, Closer> statement(prepared);
    int status = sqlite3_step(prepared);
    for (; status == SQLITE_ROW; status = sqlite3_step(prepared)) take(prepared);
    if (status != SQLITE_DONE) refuse(sqlite3_errmsg(database_.get()));
  }

  std::int64_t number(sqlite3_stmt* row, int column, const char* name, std::int64_t most) const {
    if (sqlite3_column_type(row, column) != SQLITE_INTEGER)
      refuse(std::string(name) + " is not a whole number");
    const std::int64_t value = sqlite3_column_int64(row, column);
    if (value < 0 || value > most)
      refuse(std::string(name) + " = " + std::to_string(value) + " is outside 0 .. " +
             std::to_string(most));
    return value;
  }

 private:
  std::string file_;
  int times_ = 0;
  std::unique_ptr<sqlite3, Closer> database_;
};

}  // namespace

std::vector<ImageMatches> read_colmap_database(const std::filesystem::path& file, int images) {
  Database database(file);
  std::map<std::string, std::size_t> index_of_name;
  for (int i = 0; i < images; ++i)
    index_of_name[colmap_image_name(i)] = static_cast<std::size_t>(i);
  std::map<std::int64_t, std::size_t> index_of_id;
  database.each("SELECT image_id, name FROM images", [&](sqlite3_stmt* row) {
    const std::int64_t id = database.number(row, 0, "images.image_id", kMostIds);
    const unsigned char* text = sqlite3_column_text(row, 1);
    const std::string name =
        text == nullptr ? "" : reinterpret_cast<const char*>(text);  // NOLINT: SQLite's bytes
    const auto found = index_of_name.find(name);
    if (found == index_of_name.end())
      database.refuse("an image \"" + name.substr(0, 100) + "\" that COLMAP was not given");
    index_of_id[id] = found->second;
    index_of_name.erase(found);
  });

  std::vector<ImageMatches> result(static_cast<std::size_t>(images));
  const auto image = [&](std::int64_t id) -> ImageMatches& {
    const auto found = index_of_id.find(id);
    if (found == index_of_id.end())
      database.refuse("there is no image of id " + std::to_string(id));
    return result[found->second];
  };
  database.each("SELECT image_id, rows FROM keypoints", [&](sqlite3_stmt* row) {
    image(database.number(row, 0, "keypoints.image_id", kMostIds)).features =
        static_cast<int>(database.number(row, 1, "keypoints.rows", kMostRows));
  });
  const auto each_pair = [&](const char* sql, int ImageMatches::*count, bool only_some) {
    database.each(sql, [&](sqlite3_stmt* row) {
      const std::int64_t pair = database.number(row, 0, "pair_id", kMostIds * kMostIds);
      if (database.number(row, 1, "rows", kMostRows) == 0 && only_some) return;
      ++(image(pair / kMostIds).*count);
      ++(image(pair % kMostIds).*count);
    });
  };
  each_pair("SELECT pair_id, rows FROM matches", &ImageMatches::tried, false);
  each_pair("SELECT pair_id, rows FROM two_view_geometries", &ImageMatches::partners, true);
  return result;
}

}  // namespace cousin
