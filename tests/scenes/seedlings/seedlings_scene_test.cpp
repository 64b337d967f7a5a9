#include "scenes/seedlings/seedlings_scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

namespace cousin {
namespace {

SeedlingsSceneConfig on_day(double day) {
  SeedlingsSceneConfig config;
  config.day = day;
  config.setting.substrate.detail_m = 0.01;  // the substrate's surface is not what is tested
  config.setting.substrate.perlite = 2;
  config.views = 3;
  return config;
}

const TrueTrait& trait(const Instance& instance, const std::string& name) {
  for (const TrueTrait& t : instance.traits) {
    if (t.name == name) return t;
  }
  throw std::runtime_error(instance.name + " has no " + name);
}

TEST(SeedlingsScene, HasFiftyCellsAndASpecimenWhereSomethingGrows) {
  const Scene scene = build_seedlings_scene(on_day(8), Rng(3));
  int cells = 0, emerged = 0, specimens = 0;
  for (const Instance& instance : scene.instances) {
    if (instance.category == "cell") {
      ++cells;
      emerged += trait(instance, "emergence").value > 0;
    }
    specimens += instance.is_specimen;
  }
  EXPECT_EQ(cells, 50);
  EXPECT_EQ(specimens, emerged);
  EXPECT_GT(specimens, 35);  // of 50 at 8 % failed and 2 % empty: six standard deviations
}

TEST(SeedlingsScene, TheSameTrayGrowsFromDayToDay) {
  std::map<int, double> area;  // by instance id
  for (const double day : {3.0, 5.0, 8.0, 12.0}) {
    const Scene scene = build_seedlings_scene(on_day(day), Rng(4));
    std::map<int, double> now;
    for (const Instance& instance : scene.instances) {
      if (instance.is_specimen) now[instance.id] = trait(instance, "leaf_area").value;
    }
    for (const auto& [id, before] : area) {
      ASSERT_TRUE(now.contains(id)) << id << " was lost on day " << day;
      EXPECT_GT(now[id], before);
    }
    area = now;
  }
}

TEST(SeedlingsScene, IsTheSameOnAnyNumberOfThreads) {
  const auto build = [](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return build_seedlings_scene(on_day(9), Rng(5));
  };
  const Scene a = build(1), b = build(8);
  ASSERT_EQ(a.models.size(), b.models.size());
  for (std::size_t i = 0; i < a.models.size(); ++i) {
    EXPECT_EQ(a.models[i].mesh.vertices_m, b.models[i].mesh.vertices_m) << a.models[i].name;
    EXPECT_EQ(a.models[i].mesh.triangles, b.models[i].mesh.triangles);
  }
  for (std::size_t i = 0; i < a.views.size(); ++i) {
    EXPECT_EQ(a.views[i].rig_from_world.translation_m, b.views[i].rig_from_world.translation_m);
  }
}

TEST(SeedlingsScene, EveryLightShinesAndAnotherIsRefused) {
  for (const char* light : {"D1", "D2", "D3"}) {
    SeedlingsSceneConfig config = on_day(2);
    config.light = light;
    EXPECT_FALSE(build_seedlings_scene(config, Rng(1)).lights.empty());
  }
  SeedlingsSceneConfig config = on_day(2);
  config.light = "D4";
  EXPECT_THROW(validate(config), std::invalid_argument);
}

TEST(SeedlingsScene, RefusesDaysAndOrders) {
  EXPECT_THROW(validate(on_day(-1)), std::invalid_argument);
  EXPECT_THROW(validate(on_day(1000)), std::invalid_argument);
  SeedlingsSceneConfig config = on_day(5);
  config.distance_min_m = 0.6;
  EXPECT_THROW(validate(config), std::invalid_argument);
  config = on_day(5);
  config.tilt_min_rad = 1.57;
  config.tilt_max_rad = 0.6;
  EXPECT_THROW(validate(config), std::invalid_argument);
}

TEST(SeedlingViews, KeepDistanceAndTilt) {
  SeedlingsSceneConfig config = on_day(5);
  config.views = 200;
  config.coverage = 0;  // all look at the tray's middle
  for (const View& view : seedling_views(config, Rng(1))) {
    const Eigen::Vector3d from =
        centre_in_world_m(view.rig_from_world) - Eigen::Vector3d(0, 0, 0.02);
    EXPECT_GE(from.norm(), 0.2 - 1e-12);
    EXPECT_LE(from.norm(), 0.5 + 1e-12);
    EXPECT_GE(std::asin(from.z() / from.norm()), config.tilt_min_rad - 1e-9);
  }
}

TEST(SeedlingViews, FullCoverageLeavesNoGapAllAroundAndLessDoes) {
  SeedlingsSceneConfig config = on_day(5);
  config.views = 24;
  config.tilt_max_rad = 1.3;  // seen from straight above there is no azimuth
  const auto widest_gap = [&] {
    std::vector<double> azimuths;
    for (const View& view : seedling_views(config, Rng(2))) {
      // The picture's upper edge is away from the photographer.
      const Eigen::Vector3d up =
          view.rig_from_world.rotation.conjugate() * -Eigen::Vector3d::UnitY();
      azimuths.push_back(std::atan2(up.y(), up.x()));
    }
    std::sort(azimuths.begin(), azimuths.end());
    double widest = azimuths.front() + 2 * std::numbers::pi - azimuths.back();
    for (std::size_t i = 1; i < azimuths.size(); ++i)
      widest = std::max(widest, azimuths[i] - azimuths[i - 1]);
    return widest;
  };
  // Strata of 15 degrees: neighbours are at most two apart, and the roll is at most 0.125 rad each.
  EXPECT_LT(widest_gap(), 2 * 2 * std::numbers::pi / 24 + 0.5);
  config.coverage = 0.4;
  EXPECT_GT(widest_gap(), 0.6 * 2 * std::numbers::pi - 0.5);
}

}  // namespace
}  // namespace cousin
