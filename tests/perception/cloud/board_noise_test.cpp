#include "perception/cloud/board_noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "sim/types/rng.h"

namespace cousin {
namespace {

/// A board of 0.1 m with 40 000 points of a noise, all patches of 5 mm off together by another, and
/// objects on a share of it.
Cloud noisy_board(double sigma_m, double patch_sigma_m, double offset_m, double objects) {
  Rng rng(5);
  std::vector<double> patch_m(400);
  for (double& p : patch_m) p = patch_sigma_m * normal(rng);
  Cloud cloud;
  for (int i = 0; i < 40000; ++i) {
    const double x = uniform(rng, -0.05, 0.05), y = uniform(rng, -0.05, 0.05);
    const auto column = static_cast<std::size_t>((x + 0.05) / 0.005);
    const auto row = static_cast<std::size_t>((y + 0.05) / 0.005);
    double z =
        offset_m + sigma_m * normal(rng) + patch_m[std::min<std::size_t>(399, row * 20 + column)];
    // Objects in whole columns of patches.
    if (static_cast<double>(column % 10) < 10 * objects) z += 0.006;
    CloudPoint point;
    point.position_m = Eigen::Vector3d(x, y, z).cast<float>();
    cloud.push_back(point);
  }
  return cloud;
}

TEST(BoardNoise, FindsTheSpreadOfPointsAndOfPatchesBelowObjects) {
  for (const double objects : {0.0, 0.2}) {
    const BoardNoise noise = board_noise(noisy_board(3e-4, 1.5e-4, 2e-4, objects), 0.1, 0.005);
    // The mode of a normal distribution's half is known to a fifth of its sigma here: 225 patches
    // of about 100 points share their errors.
    EXPECT_NEAR(noise.offset_m, 2e-4, 0.2 * 3.4e-4) << objects;
    EXPECT_NEAR(noise.sigma_m, std::hypot(3e-4, 1.5e-4), 0.15 * 3.4e-4) << objects;
    // A patch's mean of 100 points adds 0.3e-4. Half of 180 patches know a robust sigma to 12 %,
    // and the mode adds as much: allow 2.5 of both.
    EXPECT_NEAR(noise.patch_sigma_m, 1.53e-4, 0.4 * 1.53e-4) << objects;
    EXPECT_GT(noise.patches, 190);
  }
}

TEST(BoardNoise, WithoutCommonErrorsAPatchErrsByTheRootOfItsPoints) {
  const BoardNoise noise = board_noise(noisy_board(3e-4, 0, 0, 0), 0.1, 0.005);
  EXPECT_LT(noise.patch_sigma_m, 2 * 3e-4 / std::sqrt(100));
}

TEST(BoardNoise, SaysNothingOfACloudThatIsNotThere) {
  const BoardNoise noise = board_noise({}, 0.1, 0.005);
  EXPECT_EQ(noise.patches, 0);
  EXPECT_TRUE(std::isnan(noise.sigma_m) && std::isnan(noise.patch_sigma_m));
  Cloud astray(3);
  for (CloudPoint& point : astray) point.position_m.setConstant(NAN);
  EXPECT_TRUE(std::isnan(board_noise(astray, 0.1, 0.005).sigma_m));
  Cloud few(4);  // of which no spread is known
  for (std::size_t i = 0; i < few.size(); ++i)
    few[i].position_m.z() = 1e-3F * static_cast<float>(i);
  EXPECT_TRUE(std::isnan(board_noise(few, 0.1, 0.005).sigma_m));
  few.emplace_back();
  const BoardNoise one_patch = board_noise(few, 0.1, 0.005);
  EXPECT_GT(one_patch.sigma_m, 0);
  EXPECT_EQ(one_patch.patches, 1);
  EXPECT_TRUE(std::isnan(one_patch.patch_sigma_m));
  EXPECT_THROW(board_noise({}, 0, 0.005), std::invalid_argument);
  EXPECT_THROW(board_noise({}, 0.1, -1), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
