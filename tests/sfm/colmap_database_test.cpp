#include "perception/sfm/colmap_database.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <filesystem>
#include <string>

#include "sim/dataset/atomic_file.h"
#include "sim/process/scratch_folder.h"
#include "tests/dataset/temporary_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// The tables of COLMAP 3.8, as far as they are read.
const std::string kTables =
    "CREATE TABLE images (image_id INTEGER PRIMARY KEY, name TEXT NOT NULL UNIQUE);"
    "CREATE TABLE keypoints (image_id INTEGER PRIMARY KEY, rows INTEGER, cols INTEGER, data BLOB);"
    "CREATE TABLE matches (pair_id INTEGER PRIMARY KEY, rows INTEGER, cols INTEGER, data BLOB);"
    "CREATE TABLE two_view_geometries (pair_id INTEGER PRIMARY KEY, rows INTEGER);";
/// Ids against the names' order; image 7 is the first.
const std::string kImages =
    "INSERT INTO images VALUES (7, '000000.png'), (5, '000001.png'), (2, '000002.png');"
    "INSERT INTO keypoints (image_id, rows) VALUES (7, 900), (5, 30), (2, 800);";

class ColmapDatabaseTest : public testing::Test {
 protected:
  fs::path made(const std::string& sql) {
    const fs::path file = scratch_.path() / "database.db";
    fs::remove(file);
    sqlite3* database = nullptr;
    EXPECT_EQ(sqlite3_open(file.c_str(), &database), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK)
        << sqlite3_errmsg(database);
    sqlite3_close(database);
    return file;
  }
  std::string error(const std::string& sql, int images = 3) {
    const fs::path file = made(sql);
    return error_of([&] { read_colmap_database(file, images); });
  }
  static std::string pair(long long first, long long second, int rows) {
    return "(" + std::to_string(first * 2147483647LL + second) + ", " + std::to_string(rows) + ")";
  }
  ScratchFolder scratch_{"cousin-test"};
};

TEST_F(ColmapDatabaseTest, ImagesAreKnownByTheirNamesAndPairsByTheirTwoIds) {
  const fs::path file = made(kTables + kImages + "INSERT INTO matches (pair_id, rows) VALUES " +
                             pair(5, 7, 0) + "," + pair(2, 7, 300) + "," + pair(2, 5, 12) +
                             "; INSERT INTO two_view_geometries VALUES " + pair(5, 7, 0) + "," +
                             pair(2, 7, 250));
  const std::vector<ImageMatches> images = read_colmap_database(file, 3);
  ASSERT_EQ(images.size(), 3U);
  EXPECT_EQ(images[0].features, 900);
  EXPECT_EQ(images[1].features, 30);
  EXPECT_EQ(images[0].tried, 2);
  EXPECT_EQ(images[1].tried, 2);
  EXPECT_EQ(images[0].partners, 1);
  EXPECT_EQ(images[1].partners, 0);
  EXPECT_EQ(images[2].partners, 1);
}

TEST_F(ColmapDatabaseTest, WhatIsNoDatabaseOfTheseImagesIsRefusedByName) {
  EXPECT_THAT(error(""), HasSubstr("database.db: not a database of COLMAP: no such table: images"));
  EXPECT_THAT(error(kTables + kImages, 2), HasSubstr("an image \"000002.png\" that COLMAP was not"));
  EXPECT_THAT(error(kTables + kImages + "INSERT INTO matches (pair_id, rows) VALUES " +
                    pair(5, 8, 1)),
              HasSubstr("there is no image of id 8"));
  EXPECT_THAT(error(kTables + kImages + "INSERT INTO matches (pair_id, rows) VALUES " +
                    pair(5, 7, -1)),
              HasSubstr("rows = -1 is outside 0"));
  EXPECT_THAT(error(kTables + "INSERT INTO images VALUES (-3, '000000.png')"),
              HasSubstr("images.image_id = -3"));
  EXPECT_THAT(error("CREATE TABLE images (image_id TEXT, name TEXT);"
                    "INSERT INTO images VALUES ('one', '000000.png')"),
              HasSubstr("images.image_id is not a whole number"));
  const fs::path file = scratch_.path() / "text.db";
  write_file(file, std::string(5000, 'x'));
  EXPECT_THAT(error_of([&] { read_colmap_database(file, 1); }), HasSubstr("text.db: "));
  EXPECT_THAT(error_of([&] { read_colmap_database(scratch_.path() / "none.db", 1); }),
              HasSubstr("none.db: unable to open"));
}

TEST_F(ColmapDatabaseTest, ASchemaThatNeverEndsIsStopped) {
  EXPECT_THAT(error("CREATE VIEW images AS WITH RECURSIVE n(image_id) AS (SELECT 1 UNION ALL "
                    "SELECT image_id FROM n) SELECT image_id, '000000.png' AS name FROM n "
                    "WHERE image_id > 1"),
              HasSubstr("interrupted"));
}

TEST_F(ColmapDatabaseTest, BytesThatAreChangedNeverCrash) {
  const std::string good =
      read_file(made(kTables + kImages + "INSERT INTO matches (pair_id, rows) VALUES " +
                     pair(2, 7, 300) + "; INSERT INTO two_view_geometries VALUES " + pair(2, 7, 9)));
  const fs::path file = scratch_.path() / "changed.db";
  for (std::size_t at = 0; at < good.size(); at += 97) {
    std::string bytes = good;
    bytes[at] = static_cast<char>(bytes[at] ^ 0x5a);
    write_file(file, bytes);
    try {
      const std::vector<ImageMatches> images = read_colmap_database(file, 3);
      EXPECT_EQ(images.size(), 3U);
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), HasSubstr("changed.db: "));
    }
  }
}

}  // namespace
}  // namespace cousin
