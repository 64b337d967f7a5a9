#include "benchmarks/tools/measure/sample_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "sim/imaging/image_io.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// A fresh folder that goes with the test.
class SampleSource : public testing::Test {
 protected:
  fs::path folder_ = fs::path(testing::TempDir()) / "sample_source";
  void SetUp() override {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  void picture(const std::string& name, int width_px = 64) const {
    fs::create_directories((folder_ / name).parent_path());
    write_png(folder_ / name, Image<Rgb8>(width_px, 48, Rgb8{90, 90, 90}));
  }
  void file(const std::string& name) const {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << "x";
  }
  std::string message_of(const std::vector<std::string>& sources) const {
    try {
      (void)sample_places(sources);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }
};

TEST_F(SampleSource, AFolderOfPhotographsIsOneSample) {
  picture("beans/1.png");
  picture("beans/2.png");
  const auto places = sample_places({path("beans")});
  ASSERT_EQ(places.size(), 1U);
  EXPECT_EQ(places[0].name, "beans");
  EXPECT_EQ(places[0].kind, SamplePlace::Kind::photographs);
}

TEST_F(SampleSource, AFolderOfFoldersAndVideosHasOneEach) {
  picture("beans/first/1.png");
  picture("beans/second/1.png");
  file("beans/third.MP4");
  file("beans/notes.txt");
  file("beans/.hidden.mp4");
  const auto places = sample_places({path("beans")});
  ASSERT_EQ(places.size(), 3U);
  EXPECT_EQ(places[0].name, "beans/first");
  EXPECT_EQ(places[2].name, "beans/third");
  EXPECT_EQ(places[2].kind, SamplePlace::Kind::video);
  for (const SamplePlace& place : places) EXPECT_EQ(place.source, "beans");
}

TEST_F(SampleSource, WhatHoldsNothingOrTwoOfOneNameIsRefused) {
  file("empty/notes.txt");
  EXPECT_THAT(message_of({path("empty")}), HasSubstr("holds no photographs"));
  EXPECT_THAT(message_of({path("absent")}), HasSubstr("no such file"));
  picture("a/beans/1.png");
  picture("b/beans/1.png");
  EXPECT_THAT(message_of({path("a/beans"), path("b/beans")}),
              HasSubstr("would both be sample \"beans\""));
}

TEST_F(SampleSource, PhotographsOfUnknownLensGetALensWithCoefficients) {
  picture("beans/1.png", 100);
  const Capture capture = read_sample(sample_places({path("beans")})[0], {});
  const Camera& camera = capture.frames.at(0).sensors.at(0).reported;
  EXPECT_DOUBLE_EQ(camera.fx_px, 85);
  EXPECT_EQ(camera.model, LensModel::opencv5);
  EXPECT_EQ(capture.rig.at(0).camera.model, LensModel::opencv5);
  const Capture known =
      read_sample(sample_places({path("beans")})[0], {.intrinsics = "70,70,49.5,23.5"});
  EXPECT_DOUBLE_EQ(known.frames.at(0).sensors.at(0).reported.fx_px, 70);
  EXPECT_EQ(known.frames.at(0).sensors.at(0).reported.model, LensModel::pinhole);
}

TEST_F(SampleSource, AFileThatIsNoVideoIsNamed) {
  file("broken.mp4");
  try {
    (void)read_sample(sample_places({path("broken.mp4")})[0], {});
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("broken.mp4"));
  }
}

}  // namespace
}  // namespace cousin
