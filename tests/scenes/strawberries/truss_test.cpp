#include "scenes/strawberries/truss.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <cmath>
#include <stdexcept>

namespace cousin {
namespace {

TEST(Truss, HangsOverTheEdgeWithoutOverlaps) {
  const Truss truss = make_truss({.fruits = 5, .ripeness = 1.2}, Rng(1));
  ASSERT_EQ(truss.status, PlantStatus::ok) << truss.sag.first_warning;
  EXPECT_LT(truss.sag.max_penetration_m, 5e-4);
  ASSERT_EQ(truss.fruits.size(), 5U);
  for (std::size_t i = 0; i < truss.fruits.size(); ++i) {
    const Pose& at = truss.world_from_fruit[i];
    EXPECT_LT(at.translation_m.z(), -0.05);
    EXPECT_GT(at.translation_m.x(), 0);
    // Calyx up, tip down: nothing but its stalk and a neighbour turns it.
    EXPECT_GT((at.rotation * Eigen::Vector3d::UnitZ()).z(), 0.7);
    // Later ranks are behind in ripeness by more than their spread.
    if (truss.rank[i] == 2) {
      EXPECT_LT(trait(truss.fruits[i], "red_share"), trait(truss.fruits[0], "red_share"));
    }
  }
}

TEST(Truss, FruitsThatStillGrowAreSmallerByTheirKey) {
  TrussConfig config{.fruits = 1, .ripeness = -0.5};
  config.shape.lag_spread = 0;
  const double young_kg = grow_truss(config, Rng(4)).fruits[0].mass_kg;
  config.shape.growth_by_ripeness = 0;
  const double full_kg = grow_truss(config, Rng(4)).fruits[0].mass_kg;
  // 0.8 of a unit below the ripeness from which one is grown.
  EXPECT_NEAR(std::cbrt(young_kg / full_kg), 1 - 0.45 * 0.8, 1e-9);
}

TEST(Truss, ItsSceneIsValidAndKeypointsLieOnItsStalks) {
  const Truss truss = make_truss({.fruits = 3}, Rng(2));
  ASSERT_EQ(truss.status, PlantStatus::ok);
  const Scene scene = truss_scene(truss);
  EXPECT_NO_THROW(validate(scene));
  int specimens = 0;
  for (const Instance& instance : scene.instances) {
    if (!instance.is_specimen) continue;
    ++specimens;
    EXPECT_EQ(instance.traits.size(), 6U);
    const ObjectModel& model = scene.models[static_cast<std::size_t>(instance.model)];
    const int stem = truss.plant.loads[static_cast<std::size_t>(specimens - 1)].stem;
    for (const Keypoint& keypoint : model.keypoints) {
      if (keypoint.name != "cut_point") continue;
      const Eigen::Vector3d at = instance.world_from_object * keypoint.in_object_m;
      double nearest = 1;
      const auto line = centre_line_m(truss.plant, truss.sag.bent, stem);
      for (std::size_t i = 1; i < line.size(); ++i) {
        const Eigen::Vector3d piece = line[i] - line[i - 1];
        const double t = std::clamp((at - line[i - 1]).dot(piece) / piece.squaredNorm(), 0.0, 1.0);
        nearest = std::min(nearest, (line[i - 1] + t * piece - at).norm());
      }
      EXPECT_LT(nearest, 5e-4);  // chords of a bent pedicel
    }
  }
  EXPECT_EQ(specimens, 3);
}

TEST(Truss, ItSwaysInTheWindAndItsFruitsMoveInTheScene) {
  const Truss truss = make_truss({.fruits = 1}, Rng(3));
  SwayConfig config{.duration_s = 0.4};
  config.wind.mean_speed_m_s = 6;
  const SwayResult motion = sway(truss.plant, truss.sag.bent, {}, config, Rng(4));
  ASSERT_EQ(motion.status, PlantStatus::ok) << motion.first_warning;
  const Scene scene = truss_scene(truss, motion.frames);
  EXPECT_NO_THROW(validate(scene));
  for (const Instance& instance : scene.instances) {
    if (!instance.is_specimen) continue;
    EXPECT_EQ(instance.motion.size(), motion.frames.size());
    const Pose begin = world_from_object(instance, 0);
    EXPECT_LT((begin.translation_m - instance.world_from_object.translation_m).norm(), 1e-9);
    const Pose end = world_from_object(instance, 0.4);
    EXPECT_GT((end.translation_m - begin.translation_m).norm(), 1e-5);
    EXPECT_LT((end.translation_m - begin.translation_m).norm(), 0.1);
  }
}

TEST(Truss, InTheWindNothingPassesThroughTheBed) {
  const Truss truss = make_truss({.fruits = 3, .ripeness = 1.2}, Rng(7));
  SwayConfig config{.sample_s = 0.05, .duration_s = 0.5};
  config.wind.mean_speed_m_s = 5;
  config.wind.azimuth_rad = 3.1;  // towards the bed
  const SwayResult motion = sway(truss.plant, truss.sag.bent, {}, config, Rng(8));
  ASSERT_EQ(motion.status, PlantStatus::ok) << motion.first_warning;
  for (const BentPlant& frame : motion.frames) {
    for (const BendingLoad& load : truss.plant.loads) {
      const Pose world_from_hull = bent_from_unbent(truss.plant, frame, load.stem, load.share) *
                                   Pose{load.world_from_hulls, load.centroid_m};
      for (const Eigen::Vector3d& v : load.hulls[0].vertices_m)
        EXPECT_LT(depth_m(truss.plant.obstacles[0], world_from_hull * v), 5e-4);
    }
  }
}

TEST(Truss, FruitsTooHeavyForTheirStalksBreakThem) {
  const Truss truss = make_truss({.fruits = 1, .ripeness = 1.2, .heavier = 60}, Rng(3));
  EXPECT_EQ(truss.status, PlantStatus::broke);
}

TEST(Truss, IsTheSameOnAnyNumberOfThreads) {
  const Truss first = make_truss({.fruits = 2}, Rng(5));
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  const Truss again = make_truss({.fruits = 2}, Rng(5));
  for (std::size_t i = 0; i < first.fruits.size(); ++i) {
    EXPECT_EQ(first.world_from_fruit[i].translation_m, again.world_from_fruit[i].translation_m);
    EXPECT_EQ(first.fruits[i].flesh.model.mesh.vertices_m,
              again.fruits[i].flesh.model.mesh.vertices_m);
  }
}

TEST(Truss, RanksAreThoseOfACyme) {
  TrussConfig config{.fruits = 15};
  config.shape.one_branch_share = 0;
  EXPECT_EQ(ranks_of(config, Rng(6)),
            (std::vector<int>{0, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3, 3, 3, 3, 3}));
  config.fruits = 4;
  config.shape.one_branch_share = 1;
  EXPECT_EQ(ranks_of(config, Rng(6)), (std::vector<int>{0, 1, 2, 3}));
  EXPECT_EQ(grow_truss(config, Rng(6)).rank, ranks_of(config, Rng(6)));
}

TEST(Truss, ItsNumbersAreRefusedBeyondTheirLimits) {
  EXPECT_THROW(make_truss({.fruits = 500}, Rng(1)), std::invalid_argument);
  EXPECT_THROW(make_truss({.fruits = 0}, Rng(1)), std::invalid_argument);
  EXPECT_THROW(make_truss({.variety = "x"}, Rng(1)), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
