#include "perception/sfm/colmap_database.h"

#include <sqlite3.h>

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "perception/sfm/colmap_files.h"
#include "sim/types/utf8.h"

namespace cousin {
namespace {

constexpr std::int64_t kMostIds = 2147483647;  ///< a pair's id is first * kMostIds + second
constexpr std::int64_t kMostRows = 100000000;  ///< features or matches
constexpr int kMostBytes = 1 << 26;            ///< of a value: 100,000 features have 2.4 MB
/// Instructions of one query. 1000 images, each matched with each, take some 10 million.
constexpr int kInstructionsAtOnce = 1000000, kMostTimes = 100;

struct Closer {
  void operator()(sqlite3* database) const { sqlite3_close(database); }
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};

/// A file as a URI by which SQLite locks nothing and makes no file beside it.
std::string uri_of(const std::filesystem::path& file) {
  std::string uri = "file://";  // no authority: a path may begin with two slashes
  for (const char c : std::filesystem::absolute(file).string()) {
    if (c == '?' || c == '#' || c == '%') {
      constexpr const char* kDigits = "0123456789ABCDEF";
      uri += {'%', kDigits[c >> 4], kDigits[c & 15]};
    } else {
      uri += c;
    }
  }
  return uri + "?immutable=1";
}

/// One reading; after a complaint nothing more is read.
class Reading {
 public:
  explicit Reading(const std::filesystem::path& file) : file_(file.string()) {
    sqlite3* opened = nullptr;
    const int status = sqlite3_open_v2(uri_of(file).c_str(), &opened,
                                       SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, nullptr);
    database_.reset(opened);
    if (status != SQLITE_OK) {
      complain(opened != nullptr ? sqlite3_errmsg(opened) : "no memory");
      return;
    }
    sqlite3_db_config(opened, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    sqlite3_db_config(opened, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
    sqlite3_db_config(opened, SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
    sqlite3_limit(opened, SQLITE_LIMIT_LENGTH, kMostBytes);
    sqlite3_progress_handler(
        opened, kInstructionsAtOnce,
        [](void* times) { return ++*static_cast<int*>(times) > kMostTimes ? 1 : 0; }, &times_);
  }

  bool good() const { return complaint_.empty(); }
  const std::string& complaint() const { return complaint_; }
  void complain(const std::string& why) {
    if (good()) complaint_ = file_ + ": " + why;
  }

  /// Calls `take` with the statement at each row of `sql`.
  template <class Take>
  void each(const char* sql, const Take& take) {
    if (!good()) return;
    times_ = 0;
    sqlite3_stmt* prepared = nullptr;
    const int begun = sqlite3_prepare_v2(database_.get(), sql, -1, &prepared, nullptr);
    const std::unique_ptr<sqlite3_stmt, Closer> statement(prepared);
    if (begun != SQLITE_OK) {
      complain(std::string("not a database of COLMAP: ") + sqlite3_errmsg(database_.get()));
      return;
    }
    int status = sqlite3_step(prepared);
    for (; status == SQLITE_ROW && good(); status = sqlite3_step(prepared)) take(prepared);
    if (status != SQLITE_DONE && status != SQLITE_ROW) complain(sqlite3_errmsg(database_.get()));
  }

  /// A column that the schema computes runs what the file says: such a table is not read.
  void require_stored(const std::string& table) {
    const std::string sql =
        "SELECT name FROM pragma_table_xinfo('" + table + "') WHERE hidden <> 0";
    each(sql.c_str(), [&](sqlite3_stmt*) { complain("table " + table + " has computed columns"); });
  }

  /// 0 after a complaint.
  std::int64_t number(sqlite3_stmt* row, int column, const std::string& name, std::int64_t most) {
    if (sqlite3_column_type(row, column) != SQLITE_INTEGER) {
      complain(name + " is not a whole number");
      return 0;
    }
    const std::int64_t value = sqlite3_column_int64(row, column);
    if (value >= 0 && value <= most) return value;
    complain(name + " = " + std::to_string(value) + " is outside 0 .. " + std::to_string(most));
    return 0;
  }

 private:
  std::string file_, complaint_;
  int times_ = 0;
  std::unique_ptr<sqlite3, Closer> database_;
};

}  // namespace

ColmapDatabase read_colmap_database(const std::filesystem::path& file, int images) {
  Reading reading(file);
  std::map<std::string, int> index_of_name;
  for (int i = 0; i < images; ++i) index_of_name[colmap_image_name(i)] = i;
  for (const char* table : {"images", "keypoints", "matches", "two_view_geometries"})
    reading.require_stored(table);
  std::map<std::int64_t, int> index_of_id;
  reading.each("SELECT image_id, name FROM images", [&](sqlite3_stmt* row) {
    const std::int64_t id = reading.number(row, 0, "images.image_id", kMostIds);
    const unsigned char* text = sqlite3_column_text(row, 1);
    const std::string name = text == nullptr ? "" : reinterpret_cast<const char*>(text);
    const auto found = index_of_name.find(name);
    if (found == index_of_name.end()) {
      reading.complain("an image \"" + cut_utf8(name, 100) + "\" that COLMAP was not given");
    } else if (!index_of_id.try_emplace(id, found->second).second) {
      reading.complain("the image id " + std::to_string(id) + " occurs twice");
    }
  });

  ColmapDatabase result;
  result.images.resize(static_cast<std::size_t>(images));
  const auto with_image = [&](std::int64_t id, const auto& change) {
    const auto found = index_of_id.find(id);
    if (found == index_of_id.end()) {
      reading.complain("there is no image of id " + std::to_string(id));
    } else {
      change(result.images[static_cast<std::size_t>(found->second)]);
    }
  };
  reading.each("SELECT image_id, rows FROM keypoints", [&](sqlite3_stmt* row) {
    const auto count = static_cast<int>(reading.number(row, 1, "keypoints.rows", kMostRows));
    with_image(reading.number(row, 0, "keypoints.image_id", kMostIds),
               [&](ImageMatches& image) { image.features = count; });
  });
  const auto each_pair = [&](const char* sql, int ImageMatches::*count) {
    reading.each(sql, [&](sqlite3_stmt* row) {
      const std::int64_t pair = reading.number(row, 0, "pair_id", kMostIds * kMostIds);
      reading.number(row, 1, "rows", kMostRows);
      for (const std::int64_t id : {pair / kMostIds, pair % kMostIds})
        with_image(id, [&](ImageMatches& image) { ++(image.*count); });
    });
  };
  each_pair("SELECT pair_id, rows FROM matches", &ImageMatches::tried);
  each_pair("SELECT pair_id, rows FROM two_view_geometries WHERE rows <> 0",
            &ImageMatches::partners);
  if (!reading.good()) return {.images = {}, .complaint = reading.complaint()};
  return result;
}

}  // namespace cousin
