#include "perception/splats/splat_growth.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "perception/splats/splat_growth_kinds.h"
#include "perception/splats/splat_render.h"
#include "tests/perception/splats/random_splats.h"

namespace cousin {
namespace {

/// Colour and alpha where one Gaussian, or `copies` that share it, stands before the camera.
SplatImage shared_image(int copies, double opacity) {
  const SharedOpacity shared = share_opacity(opacity, copies);
  SplatModel model;
  model.splats.resize(static_cast<std::size_t>(copies));
  for (Splat& s : model.splats) {
    s.centre_m = {0, 0, 1};
    s.log_scale.setConstant(static_cast<float>(std::log(0.15 * shared.scale_factor)));
    s.opacity_logit = static_cast<float>(std::log(shared.opacity / (1 - shared.opacity)));
  }
  Camera camera = pinhole(64, 64, 60);
  camera.cx_px = camera.cy_px = 32;
  return render_splats(model, camera, Pose{});
}

TEST(SplatGrowth, SharedOpacityIsTheOpacityOfOne) {
  for (const int copies : {1, 2, 3, 7}) {
    const SharedOpacity shared = share_opacity(0.7, copies);
    EXPECT_NEAR(1 - std::pow(1 - shared.opacity, copies), 0.7, 1e-12);
    // In the middle exactly, and the sum along a line through it: what the scale is made for.
    const SplatImage one = shared_image(1, 0.7), many = shared_image(copies, 0.7);
    EXPECT_NEAR(many.alpha(32, 32), one.alpha(32, 32), 1e-4);
    double sum_one = 0, sum_many = 0;
    for (int x = 0; x < 64; ++x) {
      sum_one += one.alpha(x, 32);
      sum_many += many.alpha(x, 32);
    }
    // Alphas below 1/255 are cut, of copies more: 1 % of the sum.
    EXPECT_NEAR(sum_many, sum_one, 0.015 * sum_one) << copies;
  }
}

SplatTrainState state_of(int count) {
  SplatModel model;
  model.splats = random_splats(count, 21, 0.02);
  return start_training(model);
}

TEST(SplatGrowth, AdaptiveClonesTheSmallSplitsTheLargeAndPrunesTheFaint) {
  SplatTrainState state = state_of(3);
  for (int k = 0; k < 3; ++k) {
    state.values.at(SplatPlane::log_scale + k, 0) = std::log(0.001F);
    state.values.at(SplatPlane::log_scale + k, 1) = std::log(0.05F);
  }
  state.values.at(SplatPlane::opacity, 0) = 0;
  state.values.at(SplatPlane::opacity, 1) = 0;
  state.values.at(SplatPlane::opacity, 2) = -9;
  std::fill(state.gradient_sum.begin(), state.gradient_sum.end(), 1.0F);
  std::fill(state.gradient_count.begin(), state.gradient_count.end(), 1.0F);
  SplatTrainConfig config;
  config.growth = SplatGrowth::adaptive;
  grow_splats(state, config, 1, 0.5, Rng(1));
  ASSERT_EQ(state.values.size(), 4);
  int small = 0, parts = 0;
  for (int i = 0; i < 4; ++i) {
    const float scale = std::exp(state.values.at(SplatPlane::log_scale, i));
    small += std::abs(scale - 0.001F) < 1e-6F ? 1 : 0;
    parts += std::abs(scale - 0.05F / 1.6F) < 1e-6F ? 1 : 0;
  }
  EXPECT_EQ(small, 2);
  EXPECT_EQ(parts, 2);
  EXPECT_EQ(state.gradient_count[0], 0);
}

// The dead move onto the living, drawn by opacity; those that share a place share its opacity.
TEST(SplatGrowth, McmcMovesTheDeadOntoTheLiving) {
  SplatTrainState state = state_of(40);
  const auto at = [&](int i) {
    return Eigen::Vector3f(state.values.at(0, i), state.values.at(1, i), state.values.at(2, i));
  };
  for (int i = 0; i < 40; ++i) state.values.at(SplatPlane::opacity, i) = i < 20 ? 0 : -9;
  for (int i = 0; i < 5; ++i) state.values.at(SplatPlane::opacity, i) = 3;
  std::vector<Eigen::Vector3f> living;
  for (int i = 0; i < 20; ++i) living.push_back(at(i));
  SplatTrainConfig config;
  config.growth = SplatGrowth::mcmc;
  config.most_splats = 1000;
  grow_splats(state, config, 1, 0.5, Rng(1));
  ASSERT_EQ(state.values.size(), 42);  // 5 % more
  int of_strong = 0;
  for (std::size_t l = 0; l < living.size(); ++l) {
    double left = 1;
    int copies = 0;
    for (int i = 0; i < 42; ++i) {
      if (at(i) != living[l]) continue;
      left *= 1 - splat_opacity(state.values, i);
      ++copies;
    }
    EXPECT_GE(copies, 1);
    EXPECT_NEAR(1 - left, l < 5 ? 0.9526 : 0.5, 2e-3) << l;
    of_strong += l < 5 ? copies - 1 : 0;
  }
  // 22 places are drawn, each with 5 * .95 / (5 * .95 + 15 * .5) = .39: eight or nine of them.
  EXPECT_GE(of_strong, 3);
  EXPECT_LE(of_strong, 15);
}

// In memory neighbours in space are side by side: the first would be one corner of the scene.
TEST(SplatGrowth, AdaptiveGivesItsLastRoomToTheLargestGradients) {
  SplatTrainState state = state_of(6);
  for (int i = 0; i < 6; ++i) {
    state.values.at(SplatPlane::opacity, i) = 0;
    state.gradient_sum[static_cast<std::size_t>(i)] = i == 1 || i == 4 ? 2.0F : 1.0F;
    for (int k = 0; k < 3; ++k) {
      state.values.at(k, i) = static_cast<float>(i);
      state.values.at(SplatPlane::log_scale + k, i) = std::log(0.001F);
    }
  }
  std::fill(state.gradient_count.begin(), state.gradient_count.end(), 1.0F);
  SplatTrainConfig config;
  config.growth = SplatGrowth::adaptive;
  config.most_splats = 8;
  grow_splats(state, config, 1, 0.5, Rng(1));
  ASSERT_EQ(state.values.size(), 8);
  std::array<int, 6> count{};
  for (int i = 0; i < 8; ++i)
    ++count.at(static_cast<std::size_t>(std::lround(state.values.at(0, i))));
  EXPECT_EQ(count, (std::array<int, 6>{1, 2, 1, 1, 2, 1}));
}

// As the reference: what parts into two that are not too large is kept, what does not part is not.
TEST(SplatGrowth, AdaptivePrunesTheLargeAfterItSplits) {
  SplatTrainState state = state_of(3);
  for (int i = 0; i < 3; ++i) {
    state.values.at(SplatPlane::opacity, i) = 0;
    for (int k = 0; k < 3; ++k)
      state.values.at(SplatPlane::log_scale + k, i) = std::log(i == 2 ? 0.3F : 0.12F);
  }
  state.gradient_sum[0] = state.gradient_sum[2] = 1;
  std::fill(state.gradient_count.begin(), state.gradient_count.end(), 1.0F);
  SplatTrainConfig config;
  config.growth = SplatGrowth::adaptive;
  config.reset_every = 0.1;
  state.step = 200;  // of 2000: the first reset is now
  SplatTrainState later = state;
  later.step = 300;
  grow_splats(state, config, 1, 0.5, Rng(1));
  EXPECT_EQ(state.values.size(), 5);
  grow_splats(later, config, 1, 0.5, Rng(1));
  ASSERT_EQ(later.values.size(), 2);
  for (int i = 0; i < 2; ++i)
    EXPECT_NEAR(std::exp(later.values.at(SplatPlane::log_scale, i)), 0.12 / 1.6, 1e-6);
}

TEST(SplatGrowth, NeighboursInMemoryAreNeighboursInSpace) {
  SplatTrainState state = state_of(4000);
  const auto mean_step = [&] {
    double sum = 0;
    for (int i = 1; i < state.values.size(); ++i) {
      double square = 0;
      for (int k = 0; k < 3; ++k) {
        const double d = state.values.at(k, i) - state.values.at(k, i - 1);
        square += d * d;
      }
      sum += std::sqrt(square);
    }
    return sum / state.values.size();
  };
  const double before = mean_step();
  SplatTrainConfig config;
  config.growth = SplatGrowth::fixed;
  grow_splats(state, config, 1, 0.5, Rng(1));
  EXPECT_EQ(state.values.size(), 4000);
  // Random pairs are 0.66 apart; neighbours on the curve about a cell of the 4000.
  EXPECT_LT(mean_step(), 0.2 * before);
}

TEST(SplatGrowth, ResetLeavesNoOpacityAboveAHundredth) {
  SplatTrainState state = state_of(50);
  reset_opacity(state);
  for (int i = 0; i < 50; ++i) {
    EXPECT_LE(1 / (1 + std::exp(-state.values.at(SplatPlane::opacity, i))), 0.010001);
  }
}

TEST(SplatGrowth, NoiseMovesTheFaintOnlyAndAsTheirShape) {
  SplatTrainState state = state_of(4000);
  for (int i = 0; i < 4000; ++i) {
    const bool faint = i % 2 == 0;
    state.values.at(SplatPlane::opacity, i) = faint ? -12.0F : 2.0F;
    for (int k = 0; k < 3; ++k) {
      state.values.at(k, i) = 0;
      state.values.at(SplatPlane::log_scale + k, i) = std::log(k == 0 ? 0.2F : 0.1F);
      state.values.at(SplatPlane::rotation + 1 + k, i) = 0;
    }
    state.values.at(SplatPlane::rotation, i) = 1;
  }
  add_centre_noise(state.values, 1, Rng(4));
  double squares[3] = {};
  for (int i = 0; i < 4000; ++i) {
    for (int k = 0; k < 3; ++k) {
      const double moved = state.values.at(k, i);
      if (i % 2 == 1) {
        EXPECT_EQ(moved, 0);
      }
      squares[k] += moved * moved / 2000;
    }
  }
  // The gate is 1 / (1 + e^-0.5) for the transparent; 2000 draws: 1.6 % of sigma, allow five.
  const double gate = 1 / (1 + std::exp(-100 * (1 - 1 / (1 + std::exp(12.0)) - 0.995)));
  EXPECT_NEAR(std::sqrt(squares[0]), gate * 0.04, 5 * 0.016 * gate * 0.04);
  EXPECT_NEAR(std::sqrt(squares[1]), gate * 0.01, 5 * 0.016 * gate * 0.01);
}

}  // namespace
}  // namespace cousin
