#include "sim/sensors/active_stereo.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <fstream>
#include <set>

#include "tests/places/places.h"
#include "tests/sim/sensors/depth_test_scenes.h"

namespace cousin {
namespace {

using test::add_plate;
using test::even_sky;
using test::infrared_grey;
using test::look;
using test::small_depth_camera;

Scene wall_at(double z_m, double light = 0.02) {
  Scene scene;
  add_plate(scene, z_m, -3 * z_m, -3 * z_m, 3 * z_m, 3 * z_m, infrared_grey(0.5F));
  scene.lights.emplace_back(even_sky(light));
  return scene;
}

/// Share of the pixels of a rectangle that have this reason.
double share(const Image<InvalidReason>& reasons, InvalidReason reason, int x0, int y0, int x1,
             int y1) {
  double n = 0;
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) n += reasons(x, y) == reason ? 1 : 0;
  }
  return n / ((x1 - x0) * (y1 - y0));
}

double mean_depth_m(const StereoDepth& depth, const ActiveStereoConfig& config, int x0, int y0,
                    int x1, int y1) {
  double n = 0, sum = 0;
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) {
      if (depth.depth(x, y) == 0) continue;
      n += 1;
      sum += depth.depth(x, y) * config.depth_unit_m;
    }
  }
  return sum / n;
}

TEST(ActiveStereo, LeastDepthIsThatOfTheDisparityRangeInEveryMode) {
  ActiveStereoConfig config = active_stereo_preset("d457");
  // f B / 126 with f = 640 px at 1280 columns: within what users and the maintainers quote.
  for (const auto& [columns, depth_m] :
       {std::pair{1280, 0.48}, {848, 0.32}, {640, 0.29}, {424, 0.16}}) {
    config.columns = columns;
    EXPECT_NEAR(least_depth_m(config), depth_m, 0.005) << columns;
  }
  config.columns = 1280;
  config.match.shift_px = 50;
  EXPECT_NEAR(least_depth_m(config), 640 * 0.095 / 176, 1e-12);
}

TEST(ActiveStereo, MeasuresAFlatWall) {
  const ActiveStereoConfig config = small_depth_camera();
  for (const double z_m : {0.4, 0.8, 1.5}) {
    const StereoDepth depth = look(wall_at(z_m), config);
    EXPECT_GT(share(depth.reason, InvalidReason::none, 80, 20, 300, 220), 0.98) << z_m;
    // 0.02 px of the sub-pixel fit's own pull, and half a millimetre of rounding.
    const double tolerance_m = 0.03 * z_m * z_m / (192 * 0.095) + 0.0005;
    EXPECT_NEAR(mean_depth_m(depth, config, 80, 20, 300, 220), z_m, tolerance_m) << z_m;
    EXPECT_NEAR(depth.noise_free_depth_m(160, 120), z_m, 1e-6);
  }
}

TEST(ActiveStereo, AnImagersYawShiftsTheDisparityByFocalLengthTimesYaw) {
  ActiveStereoConfig config = small_depth_camera();
  const Scene scene = wall_at(1);
  const RayScene rays(scene);
  ActiveStereoUnit unit = make_active_stereo(config, Rng(1));
  const double yaw_rad = 0.002;  // 0.38 px
  unit.right_from_rig =
      Pose{Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitY())),
           Eigen::Vector3d::Zero()} *
      unit.right_from_rig;
  const InfraredPair pair =
      render_infrared_pair(rays, scene, test::rig_looking_along_x(), config, unit, Rng(2));
  const StereoDepth depth = sense_depth(pair, config, unit, Rng(3));
  // A camera turned by +yaw about its y axis sees points further to the right: smaller disparity.
  const double d = 18.24 - 192 * yaw_rad;
  EXPECT_NEAR(mean_depth_m(depth, config, 120, 80, 200, 160), 18.24 / d, 0.03 / 18.24 + 0.0005);
}

TEST(ActiveStereo, DepthIsQuantisedInDisparityAndThenInItsUnit) {
  ActiveStereoConfig config = small_depth_camera();
  const StereoDepth depth = look(wall_at(1.2), config);
  for (std::size_t i = 0; i < depth.disparity_px.size(); ++i) {
    const float d = depth.disparity_px.data()[i];
    if (std::isnan(d)) {
      EXPECT_EQ(depth.depth.data()[i], 0);
      EXPECT_NE(depth.reason.data()[i], InvalidReason::none);
      continue;
    }
    EXPECT_EQ(d * 32, std::round(d * 32));
    EXPECT_EQ(depth.reason.data()[i], InvalidReason::none);
  }
  Image<float> disparity(3, 1);
  disparity(0, 0) = 18.24F / 2;   // 2 m
  disparity(1, 0) = 18.24F / 21;  // beyond 20 m
  disparity(2, 0) = std::numeric_limits<float>::quiet_NaN();
  const Image<std::uint16_t> codes = depth_of_disparity(disparity, config);
  EXPECT_EQ(codes(0, 0), 2000);
  EXPECT_EQ(codes(1, 0), 0);
  EXPECT_EQ(codes(2, 0), 0);
}

TEST(ActiveStereo, NothingNearerThanTheLeastDepthIsMeasured) {
  const ActiveStereoConfig config = small_depth_camera();  // 0.145 m
  const StereoDepth depth = look(wall_at(0.12), config);
  EXPECT_GT(share(depth.reason, InvalidReason::out_of_range, 160, 20, 300, 220), 0.6);
  EXPECT_EQ(share(depth.reason, InvalidReason::no_texture, 160, 20, 300, 220), 0);
}

TEST(ActiveStereo, TheInvalidBandIsAsWideAsTheDisparity) {
  const ActiveStereoConfig config = small_depth_camera();
  for (const double z_m : {0.3, 0.6, 1.2}) {
    const StereoDepth depth = look(wall_at(z_m), config);
    double band = 0;
    for (int y = 40; y < 200; ++y) {
      int x = 0;
      while (x < 200 && depth.depth(x, y) == 0) ++x;
      band += x / 160.0;
    }
    // The 11-pixel window may reach over the border by half of itself before it fails.
    EXPECT_NEAR(band, 18.24 / z_m, 6) << z_m;
    EXPECT_EQ(depth.reason(2, 100), InvalidReason::band);
  }
}

TEST(ActiveStereo, AnObjectHidesAStripOfTheWallOnItsLeft) {
  const ActiveStereoConfig config = small_depth_camera();
  Scene scene = wall_at(1.2, 0.5);
  scene.materials[0] = infrared_grey(0.5F, 0.6F);  // seen without the projector too
  add_plate(scene, 0.5, -0.1, -0.15, 0.1, 0.15, infrared_grey(0.5F, 0.6F, 0.003));
  const StereoDepth depth = look(scene, config);
  // The plate's left edge is at 159.5 - 0.2 * 192 = 121. fB (1/0.5 - 1/1.2) = 21.3 px of wall are
  // hidden from the right imager; the window fattens the plate by up to half of itself, 5.5 px.
  double hidden = 0;
  for (int y = 90; y < 150; ++y) {
    for (int x = 80; x < 122; ++x) hidden += depth.depth(x, y) == 0 ? 1 / 60.0 : 0;
  }
  EXPECT_GT(hidden, 21.3 - 7);
  EXPECT_LT(hidden, 21.3 + 3);
  EXPECT_GT(share(depth.reason, InvalidReason::left_right, 104, 90, 114, 150), 0.6);
}

TEST(ActiveStereo, WhatTheProjectorDoesNotReachIsSaidSo) {
  ActiveStereoConfig config = small_depth_camera();
  config.projector_x_m = 0.6;  // far off, so that its shadow is seen by both imagers
  Scene scene = wall_at(1.2, 0.02);
  add_plate(scene, 0.6, 0.1, -0.2, 0.4, 0.2, infrared_grey(0.5F));
  const StereoDepth depth = look(scene, config);
  // Shadow on the wall: from x = 0.6 + 2 (0.1 - 0.6) = -0.4 m to 0.2: columns 96 to 191, of which
  // the plate covers those from 192 on.
  EXPECT_GT(share(depth.reason, InvalidReason::no_projector, 110, 100, 160, 140), 0.9);
  EXPECT_EQ(share(depth.reason, InvalidReason::no_projector, 230, 10, 300, 45), 0);
}

TEST(ActiveStereo, AnEvenWallWithoutAProjectorHasNoTexture) {
  ActiveStereoConfig config = small_depth_camera();
  config.has_projector = false;
  const StereoDepth depth = look(wall_at(0.8), config);
  EXPECT_GT(share(depth.reason, InvalidReason::no_texture, 80, 20, 300, 220), 0.95);
  // And a printed one has.
  Scene printed = wall_at(0.8, 0.5);
  printed.materials[0] = infrared_grey(0.5F, 0.6F);
  EXPECT_GT(share(look(printed, config).reason, InvalidReason::none, 80, 20, 300, 220), 0.9);
}

TEST(ActiveStereo, OverExposureIsSaidSo) {
  ActiveStereoConfig config = small_depth_camera();
  config.imager.least_exposure = 1;  // it cannot expose less
  const StereoDepth depth = look(wall_at(0.8, 3), config);
  EXPECT_GT(share(depth.reason, InvalidReason::saturated, 80, 20, 300, 220), 0.95);
}

TEST(ActiveStereo, PixelsAtAJumpOfDepthAreMixed) {
  const ActiveStereoConfig config = small_depth_camera();
  Scene scene = wall_at(1.2);
  for (int k = 0; k < 12; ++k) {  // a fence of wires, each 2 px wide
    const double x = 0.05 * k - 0.2;
    add_plate(scene, 0.5, x, -0.2, x + 0.005, 0.2, infrared_grey(0.5F));
  }
  const StereoDepth depth = look(scene, config);
  double mixed = 0, invalid = 0;
  for (int y = 60; y < 180; ++y) {
    for (int x = 90; x < 230; ++x) {
      invalid += depth.depth(x, y) == 0 ? 1 : 0;
      mixed += depth.reason(x, y) == InvalidReason::mixed_pixel ? 1 : 0;
    }
  }
  EXPECT_GT(mixed, 0.1 * invalid);
  EXPECT_GT(invalid, 0.05 * 120 * 140);
}

TEST(ActiveStereo, GivesTheSameBytesForAnyNumberOfThreads) {
  const ActiveStereoConfig config = small_depth_camera();
  const auto with_threads = [&](std::size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    return look(wall_at(0.7), config);
  };
  const StereoDepth one = with_threads(1);
  for (const std::size_t threads : {2, 7}) {
    const StereoDepth more = with_threads(threads);
    EXPECT_EQ(one.depth, more.depth) << threads;
    EXPECT_EQ(one.reason, more.reason) << threads;
    EXPECT_EQ(one.left_codes, more.left_codes) << threads;
  }
}

TEST(ActiveStereo, ANewExposureChangesLittleOfAStaticScene) {
  const ActiveStereoConfig config = small_depth_camera();
  const Scene scene = wall_at(0.8);
  const RayScene rays(scene);
  const ActiveStereoUnit unit = make_active_stereo(config, Rng(1));
  const InfraredPair pair =
      render_infrared_pair(rays, scene, test::rig_looking_along_x(), config, unit, Rng(2));
  const StereoDepth a = sense_depth(pair, config, unit, Rng(3));
  const StereoDepth b = sense_depth(pair, config, unit, Rng(4));
  double between = 0, about = 0, n = 0;
  for (int y = 40; y < 200; ++y) {
    for (int x = 80; x < 280; ++x) {
      const double p = a.disparity_px(x, y), q = b.disparity_px(x, y);
      if (std::isnan(p) || std::isnan(q)) continue;
      n += 1;
      between += (p - q) * (p - q) / 2;
      about += (p - 18.24 / 0.8) * (p - 18.24 / 0.8);
    }
  }
  // With the laser on most of a plane's roughness is a fixed pattern.
  EXPECT_GT(between / n, 0);
  EXPECT_LT(between, 0.5 * about);
}

TEST(ActiveStereoPreset, EveryNameLoadsMakesADeviceAndSaysWhereItsNumbersComeFrom) {
  std::set<std::string> names;
  for (const std::string& name : active_stereo_preset_names()) {
    EXPECT_TRUE(names.insert(name).second) << name << " is listed twice";
    const ActiveStereoConfig config = active_stereo_preset(name);
    const ActiveStereoUnit unit = make_active_stereo(config, Rng(1));
    EXPECT_EQ(unit.projector.has_value(), config.has_projector);
    std::ifstream file(source_folder() / ("sim/sensors/presets/" + name + ".toml"));
    ASSERT_TRUE(file) << name;
    std::string comment;
    for (std::string line; std::getline(file, line);) {
      if (line.empty()) comment.clear();
      if (line.starts_with("#")) comment = line.find(": ") < 12 ? line : comment + line;
      if (line.find(" = ") == std::string::npos || line.starts_with("#")) continue;
      EXPECT_TRUE(comment.starts_with("# sourced: ") || comment.starts_with("# fitted: ") ||
                  comment.starts_with("# free: "))
          << name << ": " << line << " has no source";
    }
  }
  EXPECT_THAT(names, testing::UnorderedElementsAre("d455", "d457", "d435i", "d415", "d405"));
  EXPECT_THROW(active_stereo_preset("d999"), std::invalid_argument);
}

TEST(ActiveStereoConfig, RejectsWhatCannotBeBuilt) {
  const auto rejects = [](const char* set, const char* word) {
    ActiveStereoConfig config = active_stereo_preset("d457");
    try {
      set_field(fields(config), set);
      validate(config);
      ADD_FAILURE() << set << " passed";
    } catch (const std::exception& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(word)) << set;
    }
  };
  rejects("columns=641", "424, 640, 848, 1280");
  rejects("mode_rows=[480]", "as many");
  rejects("match.block_px=4", "block_px");
  rejects("match.fit=cubic", "equiangular");
  rejects("infrared.pixel_samples=5", "square");
  rejects("color_distortion=[1,2,3,4,5,6]", "opencv5");
}

}  // namespace
}  // namespace cousin
