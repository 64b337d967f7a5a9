#include "scenes/strawberries/stand_motion.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <set>
#include <stdexcept>

#include "tests/scenes/strawberries/small_stretch.h"

namespace cousin {
namespace {

const std::vector<double> kTimes_s = {0, 2};

Truss hanging_truss() { return make_truss({.fruits = 3, .ripeness = 1.2, .grid = 16}, Rng(1)); }

StandWind wind_of(double speed_m_s) {
  StandWind config;
  config.wind.mean_speed_m_s = speed_m_s;
  return config;
}

TEST(StandMotion, FramesLieAboutTheViewsAndBeginNearTheRest) {
  const std::vector<Truss> trusses = {hanging_truss()};
  const auto frames = sway_trusses(trusses, trusses[0].sag.bent, wind_of(3), kTimes_s, Rng(1));
  ASSERT_EQ(frames.size(), 2U * 26);  // 0.25 s in steps of 10 ms
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const double view_s = i < 26 ? 0 : 2;
    EXPECT_GE(frames[i].time_s, view_s - 0.05 - 1e-9);
    EXPECT_LE(frames[i].time_s, view_s + 0.2 + 1e-9);
  }
  EXPECT_TRUE(sway_trusses(trusses, trusses[0].sag.bent, wind_of(0), kTimes_s, Rng(1)).empty());
}

TEST(StandMotion, FruitsStayOnTheirStalksInTheWind) {
  std::vector<Truss> trusses = {hanging_truss()};
  const auto frames = sway_trusses(trusses, trusses[0].sag.bent, wind_of(4), kTimes_s, Rng(2));
  const std::vector<StalkPart> parts = stalk_parts(trusses[0], frames, 8);
  const Truss& truss = trusses[0];
  double farthest_m = 0;
  for (std::size_t i = 0; i < truss.fruits.size(); ++i) {
    const BendingLoad& load = truss.plant.loads[i];
    const BendingStem& stem = truss.plant.stems[static_cast<std::size_t>(load.stem)];
    const auto motion = motion_of(truss.plant, frames, load.stem, 1, truss.unbent_from_fruit[i]);
    char last[40];
    std::snprintf(last, sizeof last, " stalk %02d piece %d", load.stem, stem.segments);
    for (const StalkPart& part : parts) {
      if (part.name != last) continue;
      ASSERT_EQ(part.motion.size(), motion.size());
      for (std::size_t k = 0; k < motion.size(); ++k) {
        // The stalk's end, as it hangs at rest, goes where the fruit's calyx goes.
        const Eigen::Vector3d at_rest = truss.world_from_fruit[i] * truss.fruits[i].stalk_base_m;
        const Eigen::Vector3d calyx = motion[k].world_from_object * truss.fruits[i].stalk_base_m;
        EXPECT_LT((part.motion[k].world_from_object * at_rest - calyx).norm(), 1e-9);
        farthest_m = std::max(farthest_m, (calyx - at_rest).norm());
      }
    }
  }
  EXPECT_GT(farthest_m, 1e-4);
  EXPECT_LT(farthest_m, 0.1);
}

TEST(StandMotion, APushMovesItsTrussOnlyInItsView) {
  const std::vector<Truss> trusses = {hanging_truss()};
  StandWind config;
  config.push.force_n = 0.2;
  config.push.view = 1;
  const auto frames = sway_trusses(trusses, trusses[0].sag.bent, config, kTimes_s, Rng(3));
  const auto reach_m = [&](std::size_t begin, std::size_t end) {
    double most = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const Pose& at = frames[i].sections[0].back();
      const Pose& rest = trusses[0].sag.bent.sections[0].back();
      const Eigen::Vector3d tip = trusses[0].plant.stems[0].points_m.back();
      most = std::max(most, (at * tip - rest * tip).norm());
    }
    return most;
  };
  EXPECT_LT(reach_m(0, 26), 1e-3);  // at rest: contacts settle by less
  EXPECT_GT(reach_m(26, 52), 2e-3);
}

TEST(StandMotion, HandsAndWindsThatCannotBeAreRefusedByName) {
  const std::vector<Truss> trusses = {hanging_truss()};
  const auto refusal = [&](const StandWind& config) -> std::string {
    try {
      sway_trusses(trusses, trusses[0].sag.bent, config, kTimes_s, Rng(4));
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  };
  StandWind config;
  config.push.force_n = 0.2;
  config.push.truss = 1;
  EXPECT_NE(refusal(config).find("push.truss = 1"), std::string::npos);
  config.push.truss = 0;
  config.push.view = 2;
  EXPECT_NE(refusal(config).find("push.view = 2"), std::string::npos);
  config.push.view = 0;
  config.push.force_n = 20;
  EXPECT_NE(refusal(config).find("broke"), std::string::npos) << refusal(config);
}

TEST(StandMotion, ASceneInTheWindIsTheSameOnAnyNumberOfThreadsAndItsPartsMove) {
  StrawberriesSceneConfig config = small_stretch(2);
  config.views = 2;
  config.motion.wind.mean_speed_m_s = 3;
  const StandRest rest = settle_stand(config.stand, config.bed, Rng(1));
  const auto build = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return build_strawberries_scene(config, rest, Rng(1), Rng(2));
  };
  const Scene a = build(1), b = build(8);
  ASSERT_EQ(a.instances.size(), b.instances.size());
  std::set<std::string> moving;
  for (std::size_t i = 0; i < a.instances.size(); ++i) {
    const auto &ma = a.instances[i].motion, &mb = b.instances[i].motion;
    ASSERT_EQ(ma.size(), mb.size());
    for (std::size_t k = 0; k < ma.size(); ++k) {
      EXPECT_EQ(ma[k].world_from_object.translation_m, mb[k].world_from_object.translation_m);
      EXPECT_EQ(ma[k].world_from_object.rotation.coeffs(),
                mb[k].world_from_object.rotation.coeffs());
    }
    if (!ma.empty()) moving.insert(a.instances[i].name.substr(0, 5));
  }
  EXPECT_EQ(moving, (std::set<std::string>{"calyx", "fruit", "plant", "truss"}));
}

}  // namespace
}  // namespace cousin
