#include "benchmarks/suites/seedlings/view_sets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "scenes/seedlings/seedlings_scene.h"

namespace cousin {
namespace {

TEST(ViewSets, ThePlanHasAsManyTrainedViewsAsAskedFor) {
  for (const int trained : {1, 2, 3, 10, 29, 30, 31}) {
    const int planned = planned_views(trained);
    int kept = 0;
    for (int i = 0; i < planned; ++i) kept += !is_held_out(i);
    EXPECT_EQ(kept, trained);
    EXPECT_FALSE(is_held_out(planned - 1)) << "one fewer would do";
  }
  EXPECT_EQ(planned_views(30), 37);  // 7 held out
}

// Radical inverses put every fourth view on one quarter of the tray: held out, it would be unseen.
TEST(ViewSets, HeldOutViewsLookAtAllPartsOfTheTray) {
  SeedlingsSceneConfig config;
  config.views = planned_views(30);
  for (const std::uint64_t seed : {1, 2, 3}) {
    const std::vector<View> views = seedling_views(config, Rng(seed));
    std::set<int> halves_x, halves_y, thirds_of_azimuth;
    for (int i = 0; i < config.views; ++i) {
      if (!is_held_out(i)) continue;
      const View& view = views[static_cast<std::size_t>(i)];
      const Eigen::Vector3d aim_m = view.focus_in_world_m;
      halves_x.insert(aim_m.x() > 0);
      halves_y.insert(aim_m.y() > 0);
      const Eigen::Vector3d from_m = inverse(view.rig_from_world).translation_m - aim_m;
      thirds_of_azimuth.insert(
          static_cast<int>(std::floor((std::atan2(from_m.y(), from_m.x()) + M_PI) / (2.1))));
    }
    EXPECT_EQ(halves_x.size(), 2u) << seed;
    EXPECT_EQ(halves_y.size(), 2u) << seed;
    EXPECT_EQ(thirds_of_azimuth.size(), 3u) << seed;
  }
}

TEST(ViewSets, FewerViewsAreAmongMore) {
  const std::vector<int> ten = drawn_views(30, 10, Rng(5));
  const std::vector<int> twenty = drawn_views(30, 20, Rng(5));
  EXPECT_EQ(ten.size(), 10u);
  EXPECT_TRUE(std::is_sorted(ten.begin(), ten.end()));
  EXPECT_TRUE(std::includes(twenty.begin(), twenty.end(), ten.begin(), ten.end()));
  EXPECT_EQ(std::set<int>(twenty.begin(), twenty.end()).size(), 20u);
  EXPECT_NE(ten, drawn_views(30, 10, Rng(6)));
  EXPECT_EQ(drawn_views(3, 3, Rng(1)), (std::vector<int>{0, 1, 2}));
}

TEST(ViewSets, NumbersThatThereAreNotAreRefused) {
  EXPECT_THROW(drawn_views(30, 31, Rng(1)), std::invalid_argument);
  EXPECT_THROW(drawn_views(30, 0, Rng(1)), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
