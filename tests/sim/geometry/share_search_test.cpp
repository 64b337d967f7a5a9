#include "sim/geometry/share_search.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cousin {
namespace {

Eigen::VectorXd place(double x, double y) { return Eigen::Vector2d(x, y); }

TEST(ShareSearch, TakesTheFirstStartThatMeetsIt) {
  const ShareFound found = find_share({place(0.1, 0), place(0.51, 0), place(0.5, 0)},
                                      [](const auto& p) { return p[0]; }, {.wanted = 0.5});
  EXPECT_TRUE(found.met);
  EXPECT_EQ(found.at[0], 0.51);
  EXPECT_EQ(found.tried, 2);
}

TEST(ShareSearch, HalvesTheWayBetweenStartsOnEitherSide) {
  const auto share = [](const Eigen::VectorXd& p) { return 0.5 + 0.5 * std::tanh(9 * p[0]); };
  const ShareFound found =
      find_share({place(-1, 0.2), place(2, 0.7)}, share, {.wanted = 0.3, .tolerance = 1e-3});
  EXPECT_TRUE(found.met);
  EXPECT_NEAR(share(found.at), 0.3, 1e-3);
  EXPECT_EQ(share(found.at), found.share);
}

TEST(ShareSearch, SaysWhereAShareJumpsOverWhatIsWanted) {
  const ShareFound found =
      find_share({place(-1, 0), place(1, 0)}, [](const auto& p) { return p[0] < 0.1 ? 0.2 : 0.9; },
                 {.wanted = 0.5});
  EXPECT_FALSE(found.met);
  EXPECT_NEAR(found.share, 0.2, 1e-12);  // the nearest that there is
}

TEST(ShareSearch, WalksAroundPlacesThatAreNotAllowed) {
  const auto share = [](const Eigen::VectorXd& p) {
    return std::abs(p[1]) < 0.1 ? std::nan("") : p[0];
  };
  const ShareFound found = find_share({place(0, 0), place(0, 1), place(1, -1), place(1, 1)}, share,
                                      {.wanted = 0.625, .tolerance = 1e-6});
  EXPECT_TRUE(found.met);
  EXPECT_EQ(found.at[1], 1);
  EXPECT_TRUE(find_share({place(0, 0)}, share, {}).at.size() == 0);
}

}  // namespace
}  // namespace cousin
