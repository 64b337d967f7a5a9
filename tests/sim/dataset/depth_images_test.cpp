#include "sim/dataset/depth_images.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "sim/dataset/depth_units.h"
#include "sim/imaging/image_io.h"
#include "sim/imaging/npy.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

TEST(DepthImages, FloatsBecomeTheSmallestStepsThatHoldThem) {
  const TemporaryFolder folder;
  const fs::path npy = folder.path() / "d.npy", exr = folder.path() / "d.exr";
  Image<float> depth_m(3, 1, 1.23456f);
  depth_m(1, 0) = std::numeric_limits<float>::quiet_NaN();
  for (const auto& [far_m, step_m] : {std::pair(2.0f, 1e-4), std::pair(60.0f, 1e-3),
                                      std::pair(600.0f, 1e-2), std::pair(999.0f, 1e-1)}) {
    depth_m(2, 0) = far_m;
    write_npy(npy, depth_m);
    write_exr(exr, depth_m);
    for (const fs::path& file : {npy, exr}) {
      const DepthImage read = read_depth_image(file, {});
      EXPECT_DOUBLE_EQ(read.unit_m, step_m);
      EXPECT_EQ(read.units(1, 0), 0);
      for (const int x : {0, 2})
        EXPECT_NEAR(read.units(x, 0) * read.unit_m, static_cast<double>(depth_m(x, 0)),
                    0.5001 * step_m);
    }
  }
  EXPECT_EQ(depth_image_size(npy).width_px, 3);
}

TEST(DepthImages, FloatsMayHaveAnotherUnitAndHoles) {
  const TemporaryFolder folder;
  const fs::path npy = folder.path() / "d.npy";
  Image<float> depth(4, 1, 1500);
  depth(1, 0) = 0;
  depth(2, 0) = std::numeric_limits<float>::infinity();
  depth(3, 0) = 1e10f;
  write_npy(npy, depth);
  const DepthImage read = read_depth_image(npy, {.float_unit_m = 0.001});
  EXPECT_DOUBLE_EQ(read.units(0, 0) * read.unit_m, 1.5);
  EXPECT_EQ(read.units(1, 0) + read.units(2, 0) + read.units(3, 0), 0);
  EXPECT_EQ(read.cut, 2U);
  depth(0, 0) = -1;
  write_npy(npy, depth);
  EXPECT_THAT(error_of([&] { read_depth_image(npy, {}); }),
              AllOf(HasSubstr("d.npy"), HasSubstr("-1 m is below 0")));
}

TEST(DepthImages, WholeNumbersThatMeanNoneAreNone) {
  const TemporaryFolder folder;
  const fs::path png = folder.path() / "d.png";
  Image<std::uint16_t> depth(4, 1, 1500);
  depth(1, 0) = 65535;
  depth(2, 0) = 9001;
  depth(3, 0) = 7;
  write_png(png, depth);
  const DepthImage read = read_depth_image(png, {.no_depth = 7, .most = 9000});
  EXPECT_EQ(read.units(0, 0), 1500);
  EXPECT_EQ(read.units(1, 0) + read.units(2, 0) + read.units(3, 0), 0);
  EXPECT_EQ(read.cut, 2U);
  EXPECT_EQ(read.unit_m, 0);
  EXPECT_EQ(read_depth_image(png, {}).units(2, 0), 9001);
}

TEST(DepthImages, EightBitsAreRefused) {
  const TemporaryFolder folder;
  const fs::path png = folder.path() / "d.png";
  write_png(png, Image<std::uint8_t>(4, 3, 9));
  EXPECT_THAT(error_of([&] { read_depth_image(png, {}); }),
              AllOf(HasSubstr("d.png"), HasSubstr("8-bit"), HasSubstr("16-bit")));
}

Capture with_depth(std::initializer_list<std::uint16_t> values, double unit_m) {
  Capture capture;
  SensorFrame& sensor = capture.frames.emplace_back().sensors.emplace_back();
  sensor.depth = Image<std::uint16_t>(static_cast<int>(values.size()), 1);
  std::copy(values.begin(), values.end(), sensor.depth.data());
  sensor.depth_unit_m = unit_m;
  return capture;
}

TEST(MedianDepth, LeavesOutWhatIsNone) {
  const Capture capture = with_depth({0, 0, 0, 0, 100, 200, 300}, 0.01);
  EXPECT_EQ(median_depth(capture, 0, DepthMeasure::units), 200);
  EXPECT_EQ(median_depth(capture, 0, DepthMeasure::metres), 2);
  EXPECT_EQ(median_depth(with_depth({0, 0}, 1), 0, DepthMeasure::units), std::nullopt);
}

TEST(MedianDepth, OutsideOfOneCentimetreToTwentyMetresIsAskedAbout) {
  const auto error = [](double unit_m) {
    return error_of([&] { check_median_depth(with_depth({1000}, unit_m), 0, "depth"); });
  };
  EXPECT_EQ(error(0.00001), "");
  EXPECT_EQ(error(0.02), "");
  EXPECT_THAT(error(0.021), AllOf(HasSubstr("depth: the median depth is 21 m"),
                                  HasSubstr("[0.01, 20] m: depth read in the wrong unit?"),
                                  HasSubstr("0.001 (millimetres, RealSense and Kinect: 1 m)")));
  EXPECT_THAT(error(0.000009), HasSubstr("wrong unit"));
}

}  // namespace
}  // namespace cousin
