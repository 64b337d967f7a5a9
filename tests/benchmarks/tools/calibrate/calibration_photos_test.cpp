// benchmarks/tools/calibrate/calibration_photos.h: boards by name, folders into cameras and frames.
#include "benchmarks/tools/calibrate/calibration_photos.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/boards/boards_scene.h"
#include "sim/imaging/image_io.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

using testing::HasSubstr;

TEST(TargetFromOption, CountsInnerCornersSquaresTagsAndDiscs) {
  EXPECT_EQ(target_from_option("chessboard:6x4:0.030"),
            (CalibrationTarget{TargetKind::chessboard, 7, 5, 0.03, 0, ""}));
  EXPECT_EQ(target_from_option("charuco:11x8:0.022:0.73:DICT_4X4_50"),
            (CalibrationTarget{TargetKind::charuco, 11, 8, 0.022, 0.73, "DICT_4X4_50"}));
  EXPECT_EQ(target_from_option("aprilgrid:6x6:0.088:0.3"),
            (CalibrationTarget{TargetKind::april_grid, 6, 6, 0.088, 0.3, ""}));
  EXPECT_EQ(target_from_option("acircles:4x11:0.018:0.42"),
            (CalibrationTarget{TargetKind::asymmetric_circles, 4, 11, 0.018, 0.42, ""}));
  const std::string even = "charuco:8x6:0.03:0.7:DICT_4X4_50";
  EXPECT_EQ(target_from_option(even + ":legacy"), target_from_option(even));
  EXPECT_EQ(layout_from_option(even + ":legacy"), CharucoLayout::legacy);
  EXPECT_EQ(layout_from_option(even), std::nullopt);
  EXPECT_THROW(target_from_option(even + ":old"), std::invalid_argument);
  EXPECT_EQ(target_from_option("charuco_a4"), board_preset("charuco_a4"));
}

TEST(TargetFromOption, RefusesWithTheTextAndTheForm) {
  for (const char* text :
       {"", "chessboard", "chessboard:6:0.03", "chessboard:6x4", "chessboard:6x4:abc",
        "chessboard:6x4:0.03:1", "chessboard:-6x4:0.03", "chessboard:6x4:1e9", "charuco:9x7:0.02",
        "aprilgrid:6x6:0.088", "pentagon:6x4:0.03", "chessboard:6x4x2:0.03", "circles:8x6:nan"}) {
    try {
      (void)target_from_option(text);
      ADD_FAILURE() << text;
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(), HasSubstr(std::string("\"") + text + "\"")) << text;
      EXPECT_THAT(error.what(), HasSubstr("COLUMNSxROWS:PITCH_M"));
    }
  }
}

const CalibrationTarget kBoard{TargetKind::chessboard, 7, 5, 0.03, 0, ""};

void put(const std::filesystem::path& file) { write_png(file, Image<std::uint8_t>(8, 8, 200)); }

TEST(PhotosOfFolder, CountAsPeopleDo) {
  const TemporaryFolder folder;
  for (const char* name : {"frame10.png", "frame2.png", "frame1.png", "notes.txt"}) {
    put(folder.path() / name);
  }
  const CalibrationPhotos photos = photos_of_folder(folder.path(), kBoard);
  ASSERT_EQ(photos.photos.size(), 3U);
  EXPECT_EQ(photos.cameras, std::vector<std::string>{"camera"});
  EXPECT_EQ(photos.photos[0].name, "frame1.png");
  EXPECT_EQ(photos.photos[1].name, "frame2.png");
  EXPECT_EQ(photos.photos[2].name, "frame10.png");
  EXPECT_EQ(photos.photos[2].frame, 2);
}

TEST(PhotosOfFolder, LeftAndRightAreTheTwoOfAStereoHeadByTheRestOfTheirNames) {
  const TemporaryFolder folder;
  for (const char* name : {"left01.png", "left03.png", "right01.png", "right02.png", "Right03.PNG"})
    put(folder.path() / name);
  const CalibrationPhotos photos = photos_of_folder(folder.path(), kBoard);
  ASSERT_EQ(photos.cameras, (std::vector<std::string>{"left", "right"}));
  ASSERT_EQ(photos.photos.size(), 5U);
  const auto is = [&](std::size_t i, const char* name, int camera, int frame) {
    EXPECT_EQ(photos.photos[i].name, name);
    EXPECT_EQ(photos.photos[i].camera, camera);
    EXPECT_EQ(photos.photos[i].frame, frame);
  };
  is(0, "left01.png", 0, 0);
  is(1, "left03.png", 0, 2);
  is(2, "right01.png", 1, 0);
  is(3, "right02.png", 1, 1);
  is(4, "Right03.PNG", 1, 2);
}

TEST(PhotosOfFolder, NamesAnEmptyOrMissingFolder) {
  const TemporaryFolder folder;
  EXPECT_THROW((void)photos_of_folder(folder.path(), kBoard), std::runtime_error);
  EXPECT_THROW((void)photos_of_folder(folder.path() / "none", kBoard), std::runtime_error);
}

}  // namespace
}  // namespace cousin
