#include "perception/sfm/colmap_database.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <iterator>
#include <string>

#include "sim/dataset/atomic_file.h"
#include "sim/process/scratch_folder.h"
#include "tests/perception/sfm/colmap_database_file.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// Ids against the names' order; image 7 is the first.
const std::string kImages =
    "INSERT INTO images VALUES (7, '000000.png'), (5, '000001.png'), (2, '000002.png');"
    "INSERT INTO keypoints (image_id, rows) VALUES (7, 900), (5, 30), (2, 800);";

class ColmapDatabaseTest : public testing::Test {
 protected:
  fs::path made(const std::string& sql) {
    const fs::path file = scratch_.path() / "database.db";
    write_database(file, sql);
    return file;
  }
  std::string complaint(const std::string& sql, int images = 3) {
    const ColmapDatabase database = read_colmap_database(made(sql), images);
    EXPECT_TRUE(database.images.empty() || database.complaint.empty());
    return database.complaint;
  }
  ScratchFolder scratch_{"cousin-test"};
};

TEST_F(ColmapDatabaseTest, ImagesAreKnownByTheirNamesAndPairsByTheirTwoIds) {
  const fs::path file =
      made(kColmapTables + kImages + "INSERT INTO matches (pair_id, rows) VALUES " +
           colmap_pair(5, 7, 0) + "," + colmap_pair(2, 7, 300) + "," + colmap_pair(2, 5, 12) +
           "; INSERT INTO two_view_geometries VALUES " + colmap_pair(5, 7, 0) + "," +
           colmap_pair(2, 7, 250));
  const ColmapDatabase database = read_colmap_database(file, 3);
  EXPECT_EQ(database.complaint, "");
  const std::vector<ImageMatches>& images = database.images;
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
  EXPECT_THAT(complaint(""),
              HasSubstr("database.db: not a database of COLMAP: no such table: images"));
  EXPECT_THAT(complaint(kColmapTables + kImages, 2),
              HasSubstr("an image \"000002.png\" that COLMAP was not"));
  EXPECT_THAT(complaint(kColmapTables + kImages + "INSERT INTO matches (pair_id, rows) VALUES " +
                        colmap_pair(5, 8, 1)),
              HasSubstr("there is no image of id 8"));
  EXPECT_THAT(complaint(kColmapTables + kImages + "INSERT INTO matches (pair_id, rows) VALUES " +
                        colmap_pair(5, 7, -1)),
              HasSubstr("rows = -1 is outside 0"));
  EXPECT_THAT(complaint(kColmapTables + "INSERT INTO images VALUES (-3, '000000.png')"),
              HasSubstr("images.image_id = -3"));
  EXPECT_THAT(complaint("CREATE TABLE images (image_id TEXT, name TEXT);"
                        "INSERT INTO images VALUES ('one', '000000.png')"),
              HasSubstr("images.image_id is not a whole number"));
  const fs::path file = scratch_.path() / "text.db";
  write_file(file, std::string(5000, 'x'));
  EXPECT_THAT(read_colmap_database(file, 1).complaint, HasSubstr("text.db: "));
  EXPECT_THAT(read_colmap_database(scratch_.path() / "none.db", 1).complaint,
              HasSubstr("none.db: unable to open"));
}

TEST_F(ColmapDatabaseTest, WhatASchemaWouldRunIsNotRun) {
  EXPECT_THAT(complaint("CREATE VIEW images AS WITH RECURSIVE n(image_id) AS (SELECT 1 UNION ALL "
                        "SELECT image_id FROM n) SELECT image_id, '000000.png' AS name FROM n"),
              HasSubstr("not a database of COLMAP"));
  EXPECT_THAT(
      complaint(kColmapTables + kImages +
                "ALTER TABLE images RENAME TO own; CREATE VIEW images AS SELECT * FROM own"),
      HasSubstr("not a database of COLMAP"));
  for (const char* kind : {"VIRTUAL", "STORED"}) {
    EXPECT_THAT(complaint(kColmapTables + kImages +
                          "ALTER TABLE keypoints RENAME TO own; CREATE TABLE keypoints (image_id "
                          "INTEGER, rows INTEGER GENERATED ALWAYS AS "
                          "(instr(hex(zeroblob(30)), hex(zeroblob(15)) || '1')) " +
                          kind + ")"),
                HasSubstr("table keypoints has computed columns"));
  }
}

TEST_F(ColmapDatabaseTest, RowsMayHoldAsManyFeaturesAsAreAskedFor) {
  // 100,000 features of six floats each; nothing is written beside the file.
  const fs::path file = made(kColmapTables + kImages +
                             "UPDATE keypoints SET data = zeroblob(2400000), rows = 100000");
  const ColmapDatabase database = read_colmap_database(file, 3);
  EXPECT_EQ(database.complaint, "");
  ASSERT_EQ(database.images.size(), 3U);
  EXPECT_EQ(database.images[0].features, 100000);
  EXPECT_EQ(std::distance(fs::directory_iterator(scratch_.path()), fs::directory_iterator()), 1);
}

TEST_F(ColmapDatabaseTest, OddNamesOfFoldersAreNoOptions) {
  const fs::path folder = scratch_.path() / "50%?mode=memory#x";
  fs::create_directories(folder);
  fs::copy_file(made(kColmapTables + kImages), folder / "database.db");
  EXPECT_EQ(read_colmap_database(folder / "database.db", 3).images.size(), 3U);
}

TEST_F(ColmapDatabaseTest, BytesThatAreChangedNeverCrash) {
  const std::string good = read_file(made(
      kColmapTables + kImages + "INSERT INTO matches (pair_id, rows) VALUES " +
      colmap_pair(2, 7, 300) + "; INSERT INTO two_view_geometries VALUES " + colmap_pair(2, 7, 9)));
  const fs::path file = scratch_.path() / "changed.db";
  for (std::size_t at = 0; at < good.size(); at += 97) {
    std::string bytes = good;
    bytes[at] = static_cast<char>(bytes[at] ^ 0x5a);
    write_file(file, bytes);
    const ColmapDatabase database = read_colmap_database(file, 3);
    if (database.complaint.empty()) {
      EXPECT_EQ(database.images.size(), 3U);
    } else {
      EXPECT_THAT(database.complaint, HasSubstr("changed.db: "));
    }
  }
}

}  // namespace
}  // namespace cousin
