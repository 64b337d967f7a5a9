// Folders of colour and depth.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/capture_io.h"
#include "sim/dataset/import.h"
#include "sim/imaging/image_io.h"
#include "sim/imaging/npy.h"
#include "sim/types/memory_limit.h"
#include "tests/places/places.h"
#include "tests/sim/dataset/sample_capture.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

const std::string kColor = R"("width": 20, "height": 12, "fx": 30, "fy": 31, "cx": 9.5, "cy": 5.5)";
const std::string kTwoCameras =
    R"({"depth_unit_m": 0.001, "color": {)" + kColor +
    R"(}, "depth": {"width": 10, "height": 8, "fx": 12, "fy": 12, "cx": 4.5, "cy": 3.5},
  "depth_to_color": [[1, 0, 0, 0.015], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]})";

class Rgbd : public testing::Test {
 protected:
  Rgbd() { write_pictures(20, 12); }
  void write_pictures(int depth_width_px, int depth_height_px, std::uint16_t units = 1500) {
    for (const std::string name : {"0.png", "1.png"}) {
      write_png(folder_.path() / "rgb" / name, noise<Rgb8>(20, 12, Rng(name[0])));
      write_png(folder_.path() / "depth" / name,
                Image<std::uint16_t>(depth_width_px, depth_height_px, units));
    }
  }
  void write(const char* name, const std::string& text) { write_file(folder_.path() / name, text); }
  Capture import(const ImportUnits& units = {}) const {
    return import_rgbd(folder_.path(), "", units);
  }
  std::string error(const ImportUnits& units = {}) const {
    return error_of([&] { import(units); });
  }
  static double depth_m(const Capture& capture) {
    const SensorFrame& sensor = capture.frames.at(1).sensors.back();
    return sensor.depth(3, 4) * sensor.depth_unit_m;
  }
  TemporaryFolder folder_;
};

TEST_F(Rgbd, AlignedDepthIsTheColourCamerasOwn) {
  write("intrinsics.json", "{" + kColor + R"(, "depth_scale": 0.001, "aligned": true})");
  const Capture capture = import();
  ASSERT_EQ(capture.rig.size(), 1U);
  EXPECT_EQ(capture.rig[0].name, "rgb");
  ASSERT_EQ(capture.frames.size(), 2U);
  EXPECT_EQ(capture.frames[0].sensors[0].color, noise<Rgb8>(20, 12, Rng('0')));
  EXPECT_EQ(depth_m(capture), 1.5);
  EXPECT_FALSE(capture.frames[0].rig_from_world);
  EXPECT_THAT(capture.warnings, testing::IsEmpty());
}

TEST_F(Rgbd, OneCameraForBothIsSaid) {
  write("intrinsics.json", "{" + kColor + R"(, "depth_scale": 0.001})");
  EXPECT_THAT(import().warnings, testing::ElementsAre(HasSubstr("in the colour image's pixels")));
}

TEST_F(Rgbd, DepthOfItsOwnCameraIsASensor) {
  write_pictures(10, 8);
  write("intrinsics.json", kTwoCameras);
  const Capture capture = import();
  ASSERT_EQ(capture.rig.size(), 2U);
  EXPECT_EQ(capture.rig[1].name, "depth");
  EXPECT_EQ(capture.rig[1].camera.width_px, 10);
  EXPECT_NEAR(capture.rig[1].sensor_from_rig.translation_m.x(), -0.015, 1e-12);
  EXPECT_TRUE(capture.frames[0].sensors[0].depth.empty());
  EXPECT_EQ(depth_m(capture), 1.5);
  const TemporaryFolder out;
  write_capture(out.path() / "000000", capture);
  const Capture again = read_capture(out.path() / "000000");
  EXPECT_EQ(depth_m(again), 1.5);
  EXPECT_EQ(again.rig[1].name, "depth");
}

TEST_F(Rgbd, TheUnitMustBeSaid) {
  write("intrinsics.json", "{" + kColor + "}");
  EXPECT_THAT(error(), AllOf(HasSubstr("depth: nothing says the unit"), HasSubstr("1500 units"),
                             HasSubstr("--depth-unit"), HasSubstr("0.001 (millimetres"),
                             HasSubstr("1.5 m"), HasSubstr("depth_unit_m")));
  EXPECT_EQ(depth_m(import({.depth_m = 0.001})), 1.5);
  write("intrinsics.json", "{" + kColor + R"(, "depth_scale": 5000, "aligned": true})");
  const Capture capture = import({.depth_m = 0.001});
  EXPECT_EQ(depth_m(capture), 1.5);
  EXPECT_THAT(capture.warnings, testing::ElementsAre(AllOf(HasSubstr("depth_scale says 0.0002"),
                                                           HasSubstr("--depth-unit 0.001"))));
}

TEST_F(Rgbd, ADepthThatNoCameraMeasuresIsAskedAbout) {
  write("intrinsics.json", "{" + kColor + "}");
  EXPECT_THAT(error({.depth_m = 1}), AllOf(HasSubstr("1500 m"), HasSubstr("wrong unit?")));
  EXPECT_THAT(error({.depth_m = 1e-6}), AllOf(HasSubstr("0.0015 m"), HasSubstr("[0.01, 20] m")));
}

TEST_F(Rgbd, AColourCameraIsNotTheDepthCamera) {
  write("intrinsics.json", "{" + kColor + R"(, "depth_unit": "mm"})");
  write_pictures(10, 8);
  EXPECT_THAT(error(), AllOf(HasSubstr("depth/0.png (frame 0)"), HasSubstr("10 x 8"),
                             HasSubstr("20 x 12"), HasSubstr("depth_to_color")));
  write_pictures(9, 8);
  write("intrinsics.json", kTwoCameras);
  EXPECT_THAT(error(), AllOf(HasSubstr("depth/0.png"), HasSubstr("9 x 8"), HasSubstr("10 x 8")));
  write_png(folder_.path() / "rgb/0.png", Image<Rgb8>(21, 12));
  EXPECT_THAT(error(), AllOf(HasSubstr("rgb/0.png"), HasSubstr("21 x 12")));
}

TEST_F(Rgbd, APictureOfTheDepthIsNotTheDepth) {
  write("intrinsics.json", "{" + kColor + R"(, "depth_unit": "mm"})");
  write_png(folder_.path() / "depth/0.png", Image<std::uint8_t>(20, 12, 200));
  EXPECT_THAT(error(), AllOf(HasSubstr("depth/0.png"), HasSubstr("8-bit")));
}

TEST_F(Rgbd, FloatsAreMetres) {
  write("intrinsics.json", "{" + kColor + R"(, "aligned": true})");
  for (const char* name : {"0", "1"}) {
    fs::remove(folder_.path() / "depth" / (std::string(name) + ".png"));
    write_npy(folder_.path() / "depth" / (std::string(name) + ".npy"), Image<float>(20, 12, 1.5f));
  }
  EXPECT_DOUBLE_EQ(depth_m(import()), 1.5);
  EXPECT_DOUBLE_EQ(depth_m(import({.depth_m = 0.5})), 0.75);
  EXPECT_THAT(error({.depth_m = 0.001}), AllOf(HasSubstr("0.0015"), HasSubstr("a float of 1")));
  write("intrinsics.json", "{" + kColor + R"(, "depth_unit": "mm"})");
  EXPECT_THAT(error(),
              AllOf(HasSubstr("depth_unit"), HasSubstr("floats"), HasSubstr("--depth-unit 1")));
  write_png(folder_.path() / "rgb/2.png", Image<Rgb8>(20, 12));
  write_png(folder_.path() / "depth/2.png", Image<std::uint16_t>(20, 12, 1500));
  EXPECT_THAT(error({.depth_m = 1}), HasSubstr("keep one kind"));
}

TEST_F(Rgbd, PosesAreOfTheCameraInTheWorld) {
  write("intrinsics.json", "{" + kColor + R"(, "depth_unit": "mm", "aligned": true})");
  write("pose/0.txt", "1 0 0 0.5\n0 1 0 0\n0 0 1 2\n0 0 0 1\n");
  write("pose/1.txt", "-inf -inf -inf -inf\n0 1 0 0\n0 0 1 2\n0 0 0 1\n");
  const Capture capture = import();
  EXPECT_LT(
      (centre_in_world_m(*capture.frames[0].rig_from_world) - Eigen::Vector3d(0.5, 0, 2)).norm(),
      1e-12);
  EXPECT_FALSE(capture.frames[1].rig_from_world);
  EXPECT_THAT(capture.warnings,
              testing::ElementsAre(AllOf(HasSubstr("pose/1.txt"), HasSubstr("no pose"))));
  write("pose/1.txt", "1 0 0.01 0\n0 1 0 0\n0 0 1 2\n0 0 0 1\n");
  EXPECT_THAT(error(),
              AllOf(HasSubstr("pose/1.txt"), HasSubstr("not a rotation"), HasSubstr("1e-3")));
}

TEST_F(Rgbd, PixelsBeyondTheLargestDepthAreCountedAndNone) {
  write("intrinsics.json", "{" + kColor + R"(, "depth_unit": "mm", "aligned": true})");
  Image<std::uint16_t> depth(20, 12, 1500);
  depth(0, 0) = 65535;
  write_png(folder_.path() / "depth/1.png", depth);
  const Capture capture = import();
  EXPECT_EQ(capture.frames[1].sensors[0].depth(0, 0), 0);
  EXPECT_THAT(capture.warnings,
              testing::ElementsAre(AllOf(HasSubstr("depth/1.png: 1 pixels"), HasSubstr("1 of 2"))));
}

TEST_F(Rgbd, DepthCountsBesideColour) {
  write("intrinsics.json", "{" + kColor + R"(, "depth_unit": "mm"})");
  constexpr std::uint64_t kBytes = 2 * 20 * 12 * (3 + 2);
  set_memory_limit(kBytes - 1);
  EXPECT_THAT(error(), AllOf(HasSubstr("2 depth images"), HasSubstr(std::to_string(kBytes))));
  set_memory_limit(0);
  EXPECT_EQ(error(), "");
}

// ---- real captures ------------------------------------------------------------------------------

TEST(RealRgbd, AKinectsBasketIsRead) {
  const fs::path folder = real_data() / "rgbd/boofcv_kinect_basket";
  if (!fs::exists(folder)) GTEST_SKIP() << "no real captures at " << real_data();
  EXPECT_THAT(error_of([&] { import_rgbd(folder, ""); }), HasSubstr("--depth-unit"));
  const Capture capture = import_rgbd(folder, "", {.depth_m = 0.001});
  ASSERT_EQ(capture.frames.size(), 1U);
  EXPECT_NEAR(capture.rig[0].camera.fx_px, 529.741, 1e-3);
  EXPECT_NEAR(capture.rig[0].camera.distortion[0], 0.17889, 1e-5);
  EXPECT_EQ(capture.rig.size(), 1U);
  const Image<std::uint16_t>& depth = capture.frames[0].sensors[0].depth;
  EXPECT_EQ(*std::max_element(depth.begin(), depth.end()), 1560);
  EXPECT_THAT(capture.warnings, testing::IsEmpty());
}

TEST(RealRgbd, AnOfficeHasItsPoses) {
  const fs::path folder = real_data() / "rgbd/tsdf_fusion_office";
  if (!fs::exists(folder)) GTEST_SKIP() << "no real captures at " << real_data();
  const Capture capture = import_rgbd(folder, "", {.depth_m = 0.001});
  ASSERT_GT(capture.frames.size(), 5U);
  EXPECT_EQ(capture.rig[0].camera.fx_px, 585);
  for (const Frame& frame : capture.frames) {
    ASSERT_TRUE(frame.rig_from_world);
    EXPECT_FALSE(frame.sensors[0].depth.empty());
  }
  EXPECT_LT((centre_in_world_m(*capture.frames[0].rig_from_world) -
             Eigen::Vector3d(-0.91287065, -0.34388667, 0.75986093))
                .norm(),
            1e-6);
}

}  // namespace
}  // namespace cousin
