#pragma once

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <filesystem>
#include <string>

namespace cousin {

/// The tables of COLMAP 3.8, as far as they are read.
inline const std::string kColmapTables =
    "CREATE TABLE images (image_id INTEGER PRIMARY KEY, name TEXT NOT NULL UNIQUE);"
    "CREATE TABLE keypoints (image_id INTEGER PRIMARY KEY, rows INTEGER, cols INTEGER, data BLOB);"
    "CREATE TABLE matches (pair_id INTEGER PRIMARY KEY, rows INTEGER, cols INTEGER, data BLOB);"
    "CREATE TABLE two_view_geometries (pair_id INTEGER PRIMARY KEY, rows INTEGER);";

/// "(PAIR ID, rows)" of two images' ids.
inline std::string colmap_pair(long long first, long long second, int rows) {
  return "(" + std::to_string(first * 2147483647LL + second) + ", " + std::to_string(rows) + ")";
}

/// A new database in which `sql` was run.
inline void write_database(const std::filesystem::path& file, const std::string& sql) {
  std::filesystem::remove(file);
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(file.c_str(), &database), SQLITE_OK);
  EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK)
      << sqlite3_errmsg(database);
  sqlite3_close(database);
}

}  // namespace cousin
