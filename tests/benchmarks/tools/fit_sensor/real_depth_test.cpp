// Depth images of real cameras. None of them is a wall at rest, and the fit must say so.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "benchmarks/tools/fit_sensor/depth_law.h"
#include "sim/imaging/image_io.h"
#include "tests/places/places.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

TEST(RealDepth, AKinectsFramesOfARoomAreNotTakenForAWall) {
  const fs::path folder = real_data() / "rgbd" / "tsdf_fusion_office";
  if (!fs::is_directory(folder)) GTEST_SKIP() << "no real captures at " << real_data();
  const std::vector<std::string> names = {"150", "155", "160", "165", "170",
                                          "175", "180", "185", "190", "195"};
  DepthGeometry geometry{640, 480, 585, 0.075, 0.001, 0.125, {160, 120, 320, 240}};
  std::vector<WallStatistics> walls;
  for (int part = 0; part < 4; ++part) {
    geometry.region = {160 + 80 * part, 120, 80, 240};
    const WallFrames frames{
        "room " + std::to_string(part), 1.0, 0.002, 0.5, 0.02, 10, [&](int k) {
          return read_png16(folder /
                            ("frame-000" + names[static_cast<std::size_t>(k)] + ".depth.png"));
        }};
    walls.push_back(wall_statistics(frames, geometry));
  }
  const DepthFit fit = fit_depth(walls, geometry);
  ASSERT_FALSE(fit.problems.empty());
  std::string all;
  for (const std::string& p : fit.problems) all += p + "\n";
  EXPECT_THAT(all, HasSubstr("room")) << all;
}

}  // namespace
}  // namespace cousin
