#include "sim/physics/limbs.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace cousin {
namespace {

/// A post of 40 mm along z with a strip of 30 mm along x on its upper end, in triangles of 1 mm,
/// and what bends them: two hinges each.
struct Flag {
  ObjectModel model;
  Limbs limbs;

  Flag() {
    model.name = "flag";
    model.part_names = {"post", "strip"};
    for (int i = 0; i < 40; ++i)
      add({0, 0, 1e-3 * i}, {1e-3, 0, 0}, {0, 0, 1e-3}, 0, 1e-3 * i / 0.04);
    for (int i = 0; i < 30; ++i) add({1e-3 * i, 0, 0.04}, {1e-3, 0, 0}, {0, 1e-3, 0}, 1, i / 30.0);
    model.keypoints = {{"foot", {0, 0, 0}}, {"tip", {0.03, 0, 0.04}}};
    limbs.keypoints = {{0, 0}, {1, 1}};
    BendingStem post;
    post.points_m = {{0, 0, 0}, {0, 0, 0.04}};
    post.radii_m = {0.001, 0.001};
    post.young_modulus_pa = 2e7;
    post.damping_time_s = 0.01;
    post.segments = 2;
    BendingStem strip = post;
    strip.parent = 0;
    strip.points_m = {{0, 0, 0.04}, {0.03, 0, 0.04}};
    limbs.plant.stems = {post, strip};
    limbs.stem_names = {"stalk", "leaf 1"};
    limbs.plant.loads = {{.stem = 1, .mass_kg = 2e-4, .centroid_m = {0.03, 0, 0.04}}};
    limbs.plant.loads[0].drag_area_m2 = 2e-4;
  }
  void add(const Eigen::Vector3d& at, const Eigen::Vector3d& u, const Eigen::Vector3d& v,
           std::uint16_t part, double share) {
    const auto first = static_cast<std::uint32_t>(model.mesh.vertices_m.size());
    model.mesh.vertices_m.insert(model.mesh.vertices_m.end(), {at, at + u, at + v});
    model.mesh.triangles.push_back({first, first + 1, first + 2});
    model.triangle_part.push_back(part);
    limbs.triangles.push_back({static_cast<int>(part), share});
  }
};

/// One specimen that stands turned at (1, 2, 0), and a view at 3 s.
Scene scene_of(const ObjectModel& model) {
  Scene scene;
  scene.models = {model};
  scene.materials = {Material{}};
  Instance plant;
  plant.id = 4;
  plant.name = "flag 0";
  plant.is_specimen = true;
  plant.traits = {{"height", "m", 0.04}};
  plant.part_materials = {0, 0};
  plant.world_from_object.translation_m = {1, 2, 0};
  scene.instances = {plant};
  scene.views = {View{3.0, {}, {}}};
  return scene;
}

TEST(Limbs, CutAModelIntoThePiecesOfItsSections) {
  const Flag flag;
  const LimbPieces cut = cut_model(flag.model, flag.limbs);
  // Two hinges a stem: three sections of the post and two more of the strip, whose first half
  // segment is the post's.
  ASSERT_EQ(cut.models.size(), 5U);
  std::size_t triangles = 0;
  for (const ObjectModel& piece : cut.models) {
    triangles += piece.mesh.triangles.size();
    EXPECT_EQ(piece.part_names, flag.model.part_names);
  }
  EXPECT_EQ(triangles, flag.model.mesh.triangles.size());
  EXPECT_EQ(cut.places[0].stem, -1);
  EXPECT_EQ(cut.models[0].keypoints.size(), 2U);
  EXPECT_EQ(cut.keypoint_pieces, (std::vector<int>{0, 4}));
  // A quarter of the post stands on the ground.
  EXPECT_EQ(cut.models[0].mesh.triangles.size(), 10U);
  // The post's end carries its last quarter and the strip's first: shares below 1/4 of 30.
  EXPECT_EQ(cut.models[2].mesh.triangles.size(), 10U + 8U);
}

TEST(Limbs, ASplitSpecimenIsAValidSceneThatShowsTheSame) {
  const Flag flag;
  Scene scene = scene_of(flag.model);
  const LimbPieces cut = cut_model(flag.model, flag.limbs);
  std::vector<int> models;
  for (const ObjectModel& piece : cut.models) {
    models.push_back(static_cast<int>(scene.models.size()));
    scene.models.push_back(piece);
  }
  const auto places = split_specimen(scene, 0, cut, models);
  validate(scene);
  ASSERT_EQ(places.size(), 5U);
  EXPECT_EQ(scene.instances[0].id, 4);
  EXPECT_EQ(scene.instances[0].traits.size(), 1U);
  for (std::size_t i = 1; i < places.size(); ++i) EXPECT_EQ(scene.instances[places[i]].part_of, 4);
  EXPECT_EQ(scene.instances[0].keypoint_carriers,
            (std::vector<int>{4, scene.instances[places[4]].id}));
}

TEST(Limbs, RefuseAnotherModelAndStemsThatAreNotThere) {
  Flag flag;
  flag.limbs.triangles.pop_back();
  EXPECT_THROW(cut_model(flag.model, flag.limbs), std::invalid_argument);
  Flag other;
  other.limbs.triangles[0].stem = 2;
  EXPECT_THROW(cut_model(other.model, other.limbs), std::invalid_argument);
}

#if COUSIN_WITH_MUJOCO

SwayConfig coarse() {
  SwayConfig config;
  config.step_s = 0.004;
  config.sample_s = 0.008;
  config.gravity_m_s2 = 0;
  config.contacts = false;
  return config;
}

TEST(SwayWindows, AreTheLongMotionSeenAtTimes) {
  const Flag flag;
  SwayConfig config = coarse();
  config.duration_s = 0.8;
  config.wind.mean_speed_m_s = 3;
  config.wind.intensity = 0;  // gusts are felt where bodies are there, and where they rest here
  const BentPlant rest = unbent(flag.limbs.plant);
  const std::vector<HandPush> pushes = {
      {.stem = 1, .force_n = {0, 0, -0.002}, .begin_s = 0.3, .seconds = 0.2}};
  const Rng rng(5);
  const SwayResult all = sway(flag.limbs.plant, rest, pushes, config, rng);
  const SwayResult some = sway_windows(flag.limbs.plant, rest, pushes, config,
                                       make_wind(config.wind, rng), {{{0.401, 0.455}}, 0.4});
  ASSERT_EQ(some.status, PlantStatus::ok);
  ASSERT_EQ(some.frames.size(), 8U);  // 0.400 to 0.456 s
  for (std::size_t i = 0; i < some.frames.size(); ++i) {
    const BentPlant &a = some.frames[i], &b = all.frames[50 + i];
    EXPECT_NEAR(a.time_s, b.time_s, 1e-12);
    // Drag is taken where bodies were last placed, up to a step before; frames place them anew.
    const Eigen::Vector3d tip_m(0.03, 0, 0.04);
    const Eigen::Vector3d at_m = a.sections[1][2] * tip_m;
    EXPECT_GT((at_m - tip_m).norm(), 1e-3);
    EXPECT_NEAR((at_m - b.sections[1][2] * tip_m).norm(), 0, 0.02 * (at_m - tip_m).norm());
  }
}

TEST(SwayWindows, BeginAnewAfterAPauseAndRunOnThroughAShortOne) {
  const Flag flag;
  const SwayConfig config = coarse();
  const WindField wind = make_wind({.mean_speed_m_s = 3}, Rng(5));
  const BentPlant rest = unbent(flag.limbs.plant);
  const auto last = [&](const std::vector<SwayWindows::Span>& spans) {
    return sway_windows(flag.limbs.plant, rest, {}, config, wind, {spans, 0.5})
        .frames.back()
        .sections[1][2]
        .translation_m;
  };
  EXPECT_EQ(last({{0, 0.1}, {5, 5.1}}), last({{5, 5.1}}));
  EXPECT_NE(last({{4.7, 4.8}, {5, 5.1}}), last({{5, 5.1}}));
  EXPECT_THROW(last({{5, 5.1}, {0, 0.1}}), std::invalid_argument);
}

TEST(Limbs, AHandBendsTheStripAndLetsItGo) {
  const Flag flag;
  Scene scene = scene_of(flag.model);
  const LimbPieces cut = cut_model(flag.model, flag.limbs);
  std::vector<int> models;
  for (const ObjectModel& piece : cut.models) {
    models.push_back(static_cast<int>(scene.models.size()));
    scene.models.push_back(piece);
  }
  SplitSpecimen one{&flag.limbs, &cut, split_specimen(scene, 0, cut, models), {}};
  one.pushes = {{.stem = 1, .share = 1, .force_n = {0, 0, -0.002}, .begin_s = 2.9, .seconds = 0.2}};
  sway_limbs(scene, {one}, make_wind({}, Rng(1)), coarse(), windows_of(scene, 0.5));
  validate(scene);
  EXPECT_TRUE(scene.instances[0].motion.empty());  // its foot
  const auto tip_z = [&](double time_s) {
    const Instance& tip = scene.instances[one.places[4]];
    return (world_from_object(tip, time_s) * Eigen::Vector3d(0.03, 0, 0.04)).z();
  };
  EXPECT_NEAR(tip_z(2.8), 0.04, 1e-9);  // before it is touched
  EXPECT_LT(tip_z(3.0), 0.035);
  EXPECT_NEAR(tip_z(3.5), 0.04, 0.002);  // it has swung out
}

#endif

}  // namespace
}  // namespace cousin
