#include "sim/dataset/image_pairs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/rgbd_files.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

class RgbdFolder : public testing::Test {
 protected:
  void touch(std::initializer_list<const char*> names) {
    for (const char* name : names) write_file(folder_.path() / name, "x");
  }
  /// "KEY: COLOR DEPTH POSE" of each frame, by their names below the folder.
  std::vector<std::string> frames() {
    found_ = find_rgbd_files(folder_.path());
    std::vector<std::string> result;
    const auto below = [&](const std::optional<fs::path>& file) {
      return file ? fs::relative(*file, folder_.path()).string() : "-";
    };
    for (const RgbdFile& frame : found_.frames)
      result.push_back(frame.key + ": " + below(frame.color) + " " + below(frame.depth) + " " +
                       below(frame.pose));
    return result;
  }
  TemporaryFolder folder_;
  RgbdFiles found_;
};

TEST(WithoutWord, CutsAWordAtEitherEnd) {
  EXPECT_EQ(without_word("frame-000012.color", "color"), "frame-000012");
  EXPECT_EQ(without_word("basket_RGB", "rgb"), "basket");
  EXPECT_EQ(without_word("left01", "left"), "01");
  EXPECT_EQ(without_word("left_01", "left"), "01");
  EXPECT_EQ(without_word("im0", "im0"), "");
  for (const char* stem : {"im01", "leftover", "mycolor", "depth"})
    EXPECT_EQ(without_word(stem, std::string(stem) == "im01" ? "im0" : "left"), std::nullopt);
}

TEST(NumberOrder, CountsNumbersInNames) {
  const NumberOrder less;
  EXPECT_TRUE(less("2", "10"));
  EXPECT_FALSE(less("10", "2"));
  EXPECT_TRUE(less("frame-9.a", "frame-10.a"));
  EXPECT_TRUE(less("007", "8"));
  EXPECT_NE(less("07", "7"), less("7", "07"));  // two names, in one order
  EXPECT_TRUE(less("a", "a1"));
}

TEST(TimeOfName, IsOfStampsAlone) {
  EXPECT_EQ(time_of_name("1305031102.175"), 1305031102.175);
  EXPECT_NEAR(*time_of_name("1403636579763555584"), 1403636579.763555584, 1e-6);
  for (const char* name : {"000012", "12a", "", "-1.5", "nan", "inf", "1e99"})
    EXPECT_EQ(time_of_name(name), std::nullopt) << name;
}

TEST_F(RgbdFolder, TakesTheUsualFolders) {
  for (const char* color : {"rgb", "color", "Colour", "image", "images"}) {
    const TemporaryFolder other;
    for (const std::string& name :
         {std::string(color) + "/2.jpg", std::string(color) + "/10.jpg", std::string("depth/2.png"),
          std::string("depth/10.png"), std::string("pose/10.txt")})
      write_file(other.path() / name, "x");
    const RgbdFiles found = find_rgbd_files(other.path());
    ASSERT_EQ(found.frames.size(), 2U) << color;
    EXPECT_EQ(found.frames[0].key, "2");
    EXPECT_EQ(found.frames[1].time_s, 1);
    EXPECT_FALSE(found.frames[0].pose);
    EXPECT_TRUE(found.frames[1].pose);
    EXPECT_THAT(found.warnings, ElementsAre(AllOf(HasSubstr("2.jpg"), HasSubstr("no pose"))));
  }
}

TEST_F(RgbdFolder, TakesFilesBesideEachOther) {
  touch({"frame-000150.color.png", "frame-000150.depth.png", "frame-000150.pose.txt",
         "frame-000155.color.jpg", "frame-000155.depth.npy", "camera-intrinsics.txt"});
  EXPECT_THAT(frames(),
              ElementsAre("frame-000150: frame-000150.color.png frame-000150.depth.png "
                          "frame-000150.pose.txt",
                          "frame-000155: frame-000155.color.jpg frame-000155.depth.npy -"));
}

TEST_F(RgbdFolder, TakesOnePairOfPlainNames) {
  touch({"color.png", "depth.png"});
  EXPECT_THAT(frames(), ElementsAre(": color.png depth.png -"));
}

TEST_F(RgbdFolder, WhatHasNoPartnerIsNamed) {
  touch({"rgb/0.png", "rgb/1.png", "depth/1.png", "depth/2.png", "depth/3.tiff"});
  EXPECT_THAT(frames(), ElementsAre("0: rgb/0.png - -", "1: rgb/1.png depth/1.png -"));
  EXPECT_THAT(found_.warnings,
              testing::UnorderedElementsAre(
                  AllOf(HasSubstr("rgb/0.png"), HasSubstr("has no depth image")),
                  AllOf(HasSubstr("depth/2.png"), HasSubstr("is skipped: it has no colour image")),
                  AllOf(HasSubstr("as 3.tiff"), HasSubstr("not read"))));
}

TEST_F(RgbdFolder, TimeStampsAreMatchedByTheNearest) {
  touch({"rgb/10.00.png", "rgb/10.05.png", "rgb/11.00.png", "depth/9.99.png", "depth/10.04.png",
         "depth/10.97.png"});
  EXPECT_THAT(frames(),
              ElementsAre("10.00: rgb/10.00.png depth/9.99.png -",
                          "10.05: rgb/10.05.png depth/10.04.png -", "11.00: rgb/11.00.png - -"));
  EXPECT_EQ(found_.frames[1].time_s, 10.05);
}

TEST_F(RgbdFolder, NamesThatDoNotMeetAreAnError) {
  touch({"rgb/a.png", "depth/b.png"});
  EXPECT_THAT(error_of([&] { frames(); }),
              AllOf(HasSubstr("a.png and b.png"), HasSubstr("time stamps")));
}

TEST_F(RgbdFolder, WhatIsAbsentOrTwiceThereIsNamed) {
  EXPECT_THAT(error_of([&] { frames(); }), AllOf(HasSubstr("holds no folder rgb/")));
  touch({"rgb/1.png", "depth/1.tiff"});
  EXPECT_THAT(error_of([&] { frames(); }),
              AllOf(HasSubstr("/depth: no picture"), HasSubstr("1.tiff")));
  touch({"depth/1.png", "color/1.png"});
  EXPECT_THAT(error_of([&] { frames(); }),
              AllOf(HasSubstr("color and "), HasSubstr("rgb: two folders")));
  fs::remove_all(folder_.path() / "color");
  touch({"depth/1.npy"});
  EXPECT_THAT(error_of([&] { frames(); }), HasSubstr("two pictures of one name"));
  touch({"rgb.txt", "depth.txt"});
  EXPECT_THAT(error_of([&] { frames(); }), HasSubstr("--format tum"));
  EXPECT_THAT(error_of([] { find_rgbd_files("/no/such/place"); }), HasSubstr("not a folder"));
}

TEST_F(RgbdFolder, NoLinkLeadsOut) {
  const TemporaryFolder secret;
  write_file(secret.path() / "1.png", "x");
  touch({"rgb/1.png"});
  fs::create_directory_symlink(secret.path(), folder_.path() / "depth");
  EXPECT_THAT(error_of([&] { frames(); }), HasSubstr("symbolic link"));
  fs::remove(folder_.path() / "depth");
  touch({"depth/1.png"});
  fs::create_directories(folder_.path() / "pose");
  fs::create_symlink(secret.path() / "1.png", folder_.path() / "pose/1.txt");
  EXPECT_THAT(error_of([&] { frames(); }), HasSubstr("symbolic link"));
}

}  // namespace
}  // namespace cousin
