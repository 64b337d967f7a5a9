#include "perception/carve/visual_hull.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <set>
#include <stdexcept>

#include "sim/dataset/import.h"
#include "tests/places/places.h"

namespace cousin {
namespace {

constexpr double kRadius_m = 0.05;

/// Silhouettes of a sphere at the origin from cameras all around it.
std::vector<CarveView> sphere_views(int count) {
  std::vector<CarveView> views;
  for (int i = 0; i < count; ++i) {
    const double azimuth = 2 * std::numbers::pi * i / count;
    const double elevation = (i % 3 - 1) * 0.7;
    const Eigen::Vector3d eye(std::cos(azimuth) * std::cos(elevation),
                              std::sin(azimuth) * std::cos(elevation), std::sin(elevation));
    CarveView view{Camera{LensModel::opencv5, 320, 240, 600, 600, 160, 120, {0.03, -0.01}},
                   look_at(eye, {0, 0, 0}), Image<std::uint8_t>(320, 240)};
    for (int y = 0; y < 240; ++y) {
      for (int x = 0; x < 320; ++x) {
        const auto direction = unproject(view.camera, {x, y});
        if (!direction) continue;
        const Eigen::Vector3d d = view.camera_from_world.rotation.conjugate() * *direction;
        view.mask(x, y) = eye.cross(d).norm() < kRadius_m ? 255 : 0;
      }
    }
    views.push_back(std::move(view));
  }
  return views;
}

CarveConfig sphere_config() {
  CarveConfig config;
  config.voxel_m = 0.002;
  config.low_m = Eigen::Vector3d::Constant(-0.08);
  config.high_m = Eigen::Vector3d::Constant(0.08);
  return config;
}

TEST(VisualHull, OfASphereHoldsItAndLittleMore) {
  const Carving carving = carve_visual_hull(sphere_views(24), sphere_config());
  ASSERT_EQ(carving.status, CarveStatus::ok);
  double farthest = 0;
  for (const Eigen::Vector3d& c : carving.centres_m) farthest = std::max(farthest, c.norm());
  // A voxel whose projected side touches the silhouette stays: half a side and half a pixel (0.8
  // mm) beyond, and between the 24 tangent cones the hull bulges a little (about 6 % of the
  // radius).
  EXPECT_LT(farthest, kRadius_m * 1.06 + 0.001 * std::sqrt(3.0) + 0.0016);
  const double volume =
      static_cast<double>(carving.centres_m.size()) * std::pow(carving.voxel_m, 3);
  const double sphere = 4.0 / 3 * std::numbers::pi * std::pow(kRadius_m, 3);
  EXPECT_GT(volume, sphere);         // a hull is never smaller
  EXPECT_LT(volume, sphere * 1.20);  // 2 mm on 50 mm all around is 12 %, the bulges the rest
  std::set<std::array<long, 3>> filled;
  for (const Eigen::Vector3d& c : carving.centres_m) {
    filled.insert({std::lround(c.x() * 1e4), std::lround(c.y() * 1e4), std::lround(c.z() * 1e4)});
  }
  EXPECT_EQ(filled.size(), carving.centres_m.size());
  EXPECT_TRUE(filled.contains({10, 10, 10}));  // the voxel at the centre
}

TEST(VisualHull, OneBlackSilhouetteEmptiesItUnlessTolerated) {
  std::vector<CarveView> views = sphere_views(8);
  std::fill(views[3].mask.begin(), views[3].mask.end(), std::uint8_t{0});
  EXPECT_EQ(carve_visual_hull(views, sphere_config()).status, CarveStatus::empty);
  CarveConfig tolerant = sphere_config();
  tolerant.tolerated_misses = 1;
  EXPECT_EQ(carve_visual_hull(views, tolerant).status, CarveStatus::ok);
}

// It shows the half of the volume with x < 0, and nothing there; of the rest it says nothing,
// though coarse cubes of the rest reach into it.
TEST(VisualHull, AViewCarvesOnlyWhatItShows) {
  CarveView view{Camera{LensModel::pinhole, 100, 240, 600, 600, 99.5, 120, {}},
                 look_at({0, -1, 0}, {0, 0, 0}), Image<std::uint8_t>(100, 240)};
  const Eigen::Vector3d right =
      view.camera_from_world.rotation.conjugate() * Eigen::Vector3d::UnitX();
  const Carving carving = carve_visual_hull({view}, sphere_config());
  ASSERT_EQ(carving.status, CarveStatus::ok);
  int outside = 0;
  for (const Eigen::Vector3d& centre : carving.centres_m) {
    EXPECT_GT(centre.dot(right), -0.002);
    outside += centre.dot(right) > 0.002;
  }
  EXPECT_GT(outside, 0.95 * 39 * 80 * 80);  // 40 layers of 80 x 80, all but one
}

TEST(VisualHull, NoViewsIsAStatusAndBadInputIsRefused) {
  EXPECT_EQ(carve_visual_hull({}, sphere_config()).status, CarveStatus::no_views);
  CarveConfig config = sphere_config();
  config.voxel_m = 0;
  EXPECT_THROW(carve_visual_hull(sphere_views(1), config), std::invalid_argument);
  std::vector<CarveView> views = sphere_views(1);
  views[0].mask = Image<std::uint8_t>(10, 10);
  EXPECT_THROW(carve_visual_hull(views, sphere_config()), std::invalid_argument);
}

TEST(VisualHull, IsTheSameOnAnyNumberOfThreads) {
  const auto views = sphere_views(6);
  std::vector<std::vector<Eigen::Vector3d>> results;
  for (const std::size_t threads : {1, 2, 7}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    results.push_back(carve_visual_hull(views, sphere_config()).centres_m);
  }
  EXPECT_EQ(results[0], results[1]);
  EXPECT_EQ(results[0], results[2]);
}

TEST(VisualHull, OfARealMaizePlantAgreesWithThePublishedCarving) {
  const std::filesystem::path plant =
      real_data() / "multiview/phenomenal_maize_silhouettes/plant_2";
  if (!std::filesystem::exists(plant)) GTEST_SKIP() << "real captures are absent: " << plant;
  const VoxelCarving published = read_phenomenal_voxels(plant / "voxels/16.npz");
  CarveConfig config;
  config.voxel_m = published.voxel_m;
  // One view misses about a third of the published voxels; which setting made them is not on
  // record. One miss is tolerated here too, so that the two can be compared: without it 59 % agree.
  config.tolerated_misses = 1;
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e9), high = -low;
  for (const Eigen::Vector3d& c : published.centres_m) {
    low = low.cwiseMin(c);
    high = high.cwiseMax(c);
  }
  // The published grid, with a margin of whole voxels.
  config.low_m = low - Eigen::Vector3d::Constant(4.5 * config.voxel_m);
  config.high_m = high + Eigen::Vector3d::Constant(4.5 * config.voxel_m);
  const Carving ours = carve_visual_hull(silhouette_views(import_phenomenal(plant)), config);
  ASSERT_EQ(ours.status, CarveStatus::ok);
  std::set<std::array<long, 3>> theirs, mine;
  const auto cell = [&](const Eigen::Vector3d& c) {
    const Eigen::Vector3d i = (c - low) / config.voxel_m;
    return std::array<long, 3>{std::lround(i.x()), std::lround(i.y()), std::lround(i.z())};
  };
  for (const Eigen::Vector3d& c : published.centres_m) theirs.insert(cell(c));
  for (const Eigen::Vector3d& c : ours.centres_m) mine.insert(cell(c));
  const auto common =
      std::count_if(mine.begin(), mine.end(), [&](const auto& c) { return theirs.contains(c); });
  const double iou =
      static_cast<double>(common) /
      static_cast<double>(theirs.size() + mine.size() - static_cast<std::size_t>(common));
  RecordProperty("iou", std::to_string(iou));
  EXPECT_GT(iou, 0.6) << "ours " << mine.size() << ", published " << theirs.size() << ", common "
                      << common;
}

}  // namespace
}  // namespace cousin
