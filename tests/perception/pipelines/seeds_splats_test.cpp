#include "perception/pipelines/seeds_splats.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "perception/pipelines/seeds.h"
#include "perception/splats/splat_render.h"
#include "tests/perception/pipelines/plate_capture.h"

namespace cousin {
namespace {

using testing::Contains;
using testing::Not;

TEST(SeedsSplats, StraysAreTakenOutAndTheBoardAroundTheVolumeStays) {
  SplatModel model;
  model.origin_in_world_m = {0, 0, 0.01};
  const SweepVolume box{{-0.05, -0.05, 0}, {0.05, 0.05, 0.02}};  // a fifth of it is 20 mm
  for (const Eigen::Vector3f& at_m :
       {Eigen::Vector3f(0, 0, 0), Eigen::Vector3f(0.069F, 0, 0), Eigen::Vector3f(0.071F, 0, 0),
        Eigen::Vector3f(0, -0.071F, 0), Eigen::Vector3f(0, 0, -0.029F),
        Eigen::Vector3f(0, 0, -0.031F), Eigen::Vector3f(0, NAN, 0)}) {
    Splat splat;
    splat.centre_m = at_m;
    model.splats.push_back(splat);
    model.views_seen.push_back(static_cast<int>(model.views_seen.size()));
  }
  const SplatModel kept = without_strays(model, box);
  EXPECT_EQ(kept.views_seen, (std::vector<int>{0, 1, 4}));
  ASSERT_EQ(kept.splats.size(), 3U);
  EXPECT_EQ(kept.splats[2].centre_m, model.splats[4].centre_m);
  EXPECT_EQ(kept.why_none, "");
  model.origin_in_world_m.x() = 1;
  EXPECT_TRUE(without_strays(model, box).splats.empty());
  EXPECT_NE(without_strays(model, box).why_none, "");
  model.views_seen.clear();
  model.origin_in_world_m.x() = 0;
  EXPECT_EQ(without_strays(model, box).splats.size(), 3U);
}

TEST(SeedsSplats, DepthLiesOnThePhotographsOwnPixels) {
  const FramePose pose = slanted(4, 0.3);
  const Depths depths =
      depths_of_splats(plate(0.01), {pose}, kPlateVolume, SeedsSplatConfig{}.low_pass_px2);
  ASSERT_EQ(depths.size(), 1U);
  EXPECT_EQ(depths[0].frame, 4);
  ASSERT_EQ(depths[0].depth_m.width(), 320);
  const Lens lens(pose.camera);
  int compared = 0;
  for (int column = -5; column <= 5; ++column) {
    for (int row = -5; row <= 5; ++row) {
      const double x = 0.005 * column, y = 0.005 * row;
      const Eigen::Vector3d in_camera_m = pose.camera_from_world * Eigen::Vector3d(x, y, 0.01);
      const auto pixel = lens.project(in_camera_m);
      ASSERT_TRUE(pixel);
      const double found_m = depths[0].depth_m(static_cast<int>(std::lround(pixel->x())),
                                               static_cast<int>(std::lround(pixel->y())));
      // Half a pixel to the side is 0.3 mm of depth on the slant.
      EXPECT_NEAR(found_m, in_camera_m.z(), 6e-4) << x << " " << y;
      ++compared;
    }
  }
  EXPECT_EQ(compared, 121);
  EXPECT_TRUE(std::isnan(depths[0].depth_m(2, 2)));
  EXPECT_TRUE(depths[0].normal.empty());
}

TEST(SeedsSplats, NormalsAreThoseOfTheSlantedPlate) {
  const FramePose pose = slanted(4, 0.3);
  const FrameDepth depth =
      depths_of_splats(plate(0.01), {pose}, kPlateVolume, SeedsSplatConfig{}.low_pass_px2, true)
          .at(0);
  ASSERT_EQ(depth.normal.width(), depth.depth_m.width());
  const Eigen::Vector3d up = pose.camera_from_world.rotation * Eigen::Vector3d::UnitZ();
  std::vector<double> off_rad;
  for (std::size_t i = 0; i < depth.normal.size(); ++i) {
    const Eigen::Vector3f& normal = depth.normal.data()[i];
    if (normal.isZero()) continue;
    EXPECT_NEAR(normal.norm(), 1, 1e-4);
    EXPECT_TRUE(std::isfinite(depth.depth_m.data()[i]));
    off_rad.push_back(std::acos(std::min(1.0, normal.cast<double>().dot(up))));
  }
  ASSERT_GT(off_rad.size(), 1000U);
  std::nth_element(off_rad.begin(), off_rad.begin() + off_rad.size() / 2, off_rad.end());
  EXPECT_LT(off_rad[off_rad.size() / 2], 0.1);  // one pixel of depth is rough
}

TEST(SeedsSplats, DepthOutsideTheVolumeAndOfViewsWithoutAPoseIsLeftOut) {
  FramePose lost = slanted(1, 0);
  lost.status = PoseStatus::no_board;
  const Depths depths = depths_of_splats(plate(0.04), {slanted(0, 0), lost}, kPlateVolume,
                                         SeedsSplatConfig{}.low_pass_px2);
  for (const float depth_m : depths.at(0).depth_m) EXPECT_TRUE(std::isnan(depth_m));
  EXPECT_TRUE(depths.at(1).depth_m.empty());
}

TEST(SeedsSplats, ViewsAreCutToTheVolumeAndGreenIsBlack) {
  FramePose lost = slanted(1, 0);
  lost.status = PoseStatus::no_board;
  const Poses poses = {lost, slanted(7, 0.2)};
  Capture capture = capture_of(poses, kGreen);
  const auto middle =
      *Lens(poses[1].camera).project(poses[1].camera_from_world * Eigen::Vector3d::Zero());
  capture.frames[1].sensors[0].color(static_cast<int>(std::lround(middle.x())),
                                     static_cast<int>(std::lround(middle.y()))) = {250, 250, 250};
  const auto views = seed_views(capture, poses, kPlateVolume, {}, 8);
  ASSERT_EQ(views.size(), 1U);
  EXPECT_EQ(views[0].frame, 1);
  const SplatViewLevel& level = views[0].full;
  EXPECT_LT(level.camera.width_px, 260);
  // The white pixel is where the smaller pinhole camera sees the board's middle.
  const auto place =
      *Lens(level.camera).project(views[0].camera_from_world * Eigen::Vector3d::Zero());
  float brightest = 0;
  Eigen::Vector2d at(0, 0);
  const Image<float>& green = level.color.channel[1];
  double dark = 0;
  for (int y = 0; y < green.height(); ++y) {
    for (int x = 0; x < green.width(); ++x) {
      dark += std::abs(green(x, y)) < 1e-6F;
      if (green(x, y) <= brightest) continue;
      brightest = green(x, y);
      at = {x, y};
    }
  }
  EXPECT_GT(brightest, 0.3F);
  EXPECT_LT((at - place).norm(), 1.0);
  EXPECT_GT(dark, 0.99 * static_cast<double>(green.size()));
}

TEST(SeedsSplats, NothingToLearnGivesNoGaussians) {
  const Poses poses = {slanted(0, 0), slanted(1, 1)};
  EXPECT_TRUE(train_on_views({}, std::vector<StartPoint>(9), {}, {}, 100).splats.empty());
  FramePose away = slanted(0, 0);
  away.camera_from_world.translation_m = {0, 0, -0.3};  // looks away from the board
  EXPECT_TRUE(seed_views(capture_of({away}, kGreen), {away}, kPlateVolume, {}, 8).empty());
  FramePose larger = slanted(0, 0);
  larger.camera.width_px *= 2;
  EXPECT_THROW(seed_views(capture_of({slanted(0, 0)}, kGreen), {larger}, kPlateVolume, {}, 8),
               std::invalid_argument);
}

TEST(SeedsSplats, PhotographsBeyondMemoryAreRefusedUntilMoreIsAllowed) {
  const Capture capture = capture_of({slanted(0, 0), slanted(1, 1)}, kGreen);
  const Poses poses = {slanted(0, 0), slanted(1, 1)};
  const double all = 2.0 * slanted(0, 0).camera.width_px * slanted(0, 0).camera.height_px;
  EXPECT_EQ(seed_views(capture, poses, kPlateVolume, {}, 10000, all).size(), 2U);
  try {
    (void)seed_views(capture, poses, kPlateVolume, {}, 10000, all - 1);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("most_pixels"));
  }
}

/// A closed box of 4 mm on the board.
Mesh box_mesh() {
  Mesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.vertices_m.emplace_back(0.004 * (i & 1), 0.004 * (i >> 1 & 1), 0.004 * (i >> 2 & 1));
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

TEST(SeedsSplats, GaussiansBeginOnClosedSurfacesAndElseOnTheCloud) {
  // A board, a grain with a closed surface, one without, and a stray point above the board.
  Cloud cloud(100);
  for (std::size_t i = 0; i < cloud.size(); ++i)
    cloud[i].position_m = {0.02F + 1e-4F * static_cast<float>(i), 0, i % 2 == 0 ? 3e-4F : -2e-4F};
  Clusters clusters;
  clusters.count = 2;
  for (const auto& [x, instance] : {std::pair{0.001F, 0}, {0.04F, 1}, {0.045F, -1}}) {
    CloudPoint point;
    point.position_m = {x, 0.001F, 0.003F};
    point.color = {200, 150, 100};
    clusters.cloud.push_back(point);
    clusters.instance.push_back(instance);
    cloud.push_back(point);
  }
  Surface closed;
  closed.status = SurfaceStatus::ok;
  closed.mesh = box_mesh();
  Surface open;
  open.instance = 1;
  open.status = SurfaceStatus::too_few_views;
  SeedsSplatConfig config;
  config.start_points = 60;
  config.raised_share = 0.8;
  std::vector<StartPoint> start =
      start_on_surfaces(clusters, cloud, {closed, open}, config, Rng(1));
  ASSERT_EQ(start.size(), 60U);
  std::array<int, 3> on_face{};
  for (std::size_t i = 0; i < 48; ++i) {
    const Eigen::Vector3d from_middle = start[i].position_m - Eigen::Vector3d::Constant(0.002);
    EXPECT_NEAR(from_middle.cwiseAbs().maxCoeff(), 0.002, 1e-9) << i;
    Eigen::Index axis = 0;
    start[i].normal.cwiseAbs().maxCoeff(&axis);
    EXPECT_NEAR(std::abs(start[i].normal[axis]), 1, 1e-9);
    EXPECT_NEAR(start[i].normal.dot(from_middle), 0.002, 1e-9) << "outward";
    ++on_face[static_cast<std::size_t>(axis)];
    EXPECT_EQ(start[i].color, (Rgb8{200, 150, 100}));
  }
  EXPECT_EQ(on_face, (std::array<int, 3>{16, 16, 16}));  // evenly over the area
  const auto is_high = [](const StartPoint& p) { return p.position_m.z() > 0.001; };
  EXPECT_EQ(std::count_if(start.begin() + 48, start.end(), is_high), 0);  // of 102 each 8.5th
  for (std::size_t i = 48; i < start.size(); ++i) {  // on the board's face, whatever its noise
    EXPECT_EQ(start[i].position_m.z(), 0);
    EXPECT_EQ(start[i].normal, Eigen::Vector3d::UnitZ());
  }
  config.start_points = 200;
  start = start_on_surfaces(clusters, cloud, {closed, open}, config, Rng(1));
  ASSERT_EQ(start.size(), 200U);  // 160 on the box, then of 102: all but one in five
  EXPECT_TRUE(start_on_surfaces({}, {}, {}, config, Rng(1)).empty());
  config.raised_share = 0.2;
  start = start_on_surfaces(clusters, cloud, {closed, open}, config, Rng(1));
  EXPECT_EQ(start.size(), 40U + 102U);
  EXPECT_EQ(std::count_if(start.begin() + 40, start.end(), is_high), 2);
}

TEST(SeedsSplats, TooFewPointsAreFilledUpInTheVolume) {
  std::vector<StartPoint> start(10);
  fill_start(kPlateVolume, 20, Rng(1), start);
  EXPECT_EQ(start.size(), 10U);  // half is enough
  fill_start(kPlateVolume, 50, Rng(1), start);
  ASSERT_EQ(start.size(), 50U);
  for (const StartPoint& point : start)
    EXPECT_LE(point.position_m.cwiseAbs().maxCoeff(), 0.05 + 1e-9);
}

TEST(SeedsSplats, EachMethodReadsWhatItNeeds) {
  SeedsPipelineConfig config;
  EXPECT_THAT(needs(config).stages, Not(Contains("splats")));
  config.method = SeedsMethod::splats;
  EXPECT_EQ(needs(config).stages,
            (std::vector<std::string>{"corners", "poses", "splats", "depth", "cloud", "clusters",
                                      "masks", "surfaces", "traits"}));
  config.method = SeedsMethod::splats_paper;
  EXPECT_EQ(needs(config).stages, (std::vector<std::string>{"corners", "poses", "splats", "cloud",
                                                            "clusters", "surfaces", "traits"}));
  EXPECT_FALSE(seeds_stages(config, 1).depths);
}

TEST(SeedsSplats, KeysOutsideTheirLimitsAreNamed) {
  SeedsSplatConfig config;
  config.least_opacity = 1.5;
  try {
    validate(config);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("least_opacity"));
  }
  EXPECT_THROW(set_field(fields(config), "poses=guess"), std::invalid_argument);
}

TEST(SeedsSplats, WhereThePosesComeFromIsNamed) {
  SeedsSplatConfig config;
  for (const char* poses : {"sfm", "adjusted", "board"}) {
    set_field(fields(config), std::string("poses=") + poses);
    EXPECT_EQ(to_string(config.poses), poses);
  }
}

}  // namespace
}  // namespace cousin
