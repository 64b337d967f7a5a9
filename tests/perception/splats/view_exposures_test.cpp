#include "perception/splats/view_exposures.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "sim/imaging/color.h"
#include "sim/types/rng.h"

namespace cousin {
namespace {

constexpr int kWidth = 48, kHeight = 36;
constexpr Vignetting kLens{-0.3, 0.05};

/// Photographs of the plane z = 0, straight down from 1 m above it.
struct Plane {
  std::vector<SplatView> views;
  std::vector<Image<float>> depths_m;
};

double albedo(const Eigen::Vector3d& at_m, int channel) {
  return 0.3 + 0.12 * std::sin(20 * at_m.x() + channel) + 0.08 * std::sin(17 * at_m.y());
}

void add_view(Plane& plane, double x_m, double y_m, double log_gain, double noise, const Rng& rng) {
  SplatView view;
  view.frame = static_cast<int>(plane.views.size());
  view.camera_from_world = look_at({x_m, y_m, 1}, {x_m, y_m, 0}, Eigen::Vector3d::UnitY());
  SplatViewLevel& level = view.full;
  level.camera = {LensModel::pinhole, kWidth, kHeight, 50, 50, 23.5, 17.5};
  for (Image<float>& channel : level.color.channel) channel = Image<float>(kWidth, kHeight);
  const Lens lens(level.camera);
  const Pose world_from_camera = inverse(view.camera_from_world);
  Rng own = rng.fork(static_cast<std::uint64_t>(view.frame));
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const Eigen::Vector3d ray = *lens.unproject({x, y});
      const Eigen::Vector3d at_m = world_from_camera * Eigen::Vector3d(ray / ray.z());
      const double dx = x - 23.5, dy = y - 17.5;
      const double r2 = 4 * (dx * dx + dy * dy) / (kWidth * kWidth + kHeight * kHeight);
      for (int c = 0; c < 3; ++c) {
        const double light = albedo(at_m, c) * std::exp(log_gain + kLens.log_at(r2));
        const auto ch = static_cast<std::size_t>(c);
        level.color.channel[ch](x, y) =
            srgb_from_linear(static_cast<float>(light * (1 + noise * normal(own))));
      }
    }
  }
  plane.views.push_back(view);
  plane.depths_m.emplace_back(kWidth, kHeight, 1.0F);
}

constexpr double kGains[] = {0.3, -0.2, 0.1, -0.4, 0.15, 0.05};  // their sum is zero
Plane six_views(double noise, std::uint64_t seed) {
  Plane plane;
  const double x_m[] = {0, 0.2, -0.2, 0.1, -0.1, 0.3}, y_m[] = {0, 0.1, 0.1, -0.15, -0.1, 0};
  for (int i = 0; i < 6; ++i) add_view(plane, x_m[i], y_m[i], kGains[i], noise, Rng(seed));
  return plane;
}

TEST(ViewExposures, GainsAndVignettingAreFoundOnSharedSurfaces) {
  const Plane plane = six_views(0, 1);
  const ViewExposures found = estimate_exposures(plane.views, plane.depths_m);
  ASSERT_EQ(found.status, ExposureStatus::ok);
  double sum = 0;
  for (std::size_t v = 0; v < 6; ++v) {
    EXPECT_NEAR(found.log_gain[v], kGains[v], 0.003) << v;
    sum += found.log_gain[v];
  }
  EXPECT_NEAR(sum, 0, 1e-9);
  for (const double r2 : {0.2, 0.5, 0.9})
    EXPECT_NEAR(found.vignetting.log_at(r2), kLens.log_at(r2), 0.004) << r2;
  EXPECT_GT(found.points, 100);
  EXPECT_GT(found.sightings, 2 * found.points);
}

class DeviationsOfExposures : public testing::TestWithParam<double> {};

TEST_P(DeviationsOfExposures, AreTheScatterOfRepeatedEstimates) {
  const double noise = GetParam();
  int within = 0, all = 0;
  double gains = 0, corner = 0;
  constexpr int kRuns = 60;
  for (int run = 0; run < kRuns; ++run) {
    const Plane plane = six_views(noise, 100 + static_cast<std::uint64_t>(run));
    const ViewExposures found = estimate_exposures(plane.views, plane.depths_m);
    ASSERT_EQ(found.status, ExposureStatus::ok);
    for (std::size_t v = 0; v < 6; ++v, ++all) {
      const double off = (found.log_gain[v] - kGains[v]) / found.sigma[v];
      within += std::abs(off) <= 2 ? 1 : 0;
      gains += off * off;
    }
    const double off = found.vignetting.log_at(1) - kLens.log_at(1);
    corner += off * off / (found.vignetting_sigma * found.vignetting_sigma) / kRuns;
  }
  // 0.95 and 1 where errors are what is said.
  EXPECT_GT(static_cast<double>(within) / all, 0.88);
  EXPECT_LT(gains / all, 1.6);
  EXPECT_GT(gains / all, 0.5);
  EXPECT_LT(corner, 2);
  EXPECT_GT(corner, 0.3);
}

INSTANTIATE_TEST_SUITE_P(Noise, DeviationsOfExposures, testing::Values(0.05, 0.2));

TEST(ViewExposures, WhatShinesInSomeViewsDoesNotCount) {
  Plane plane = six_views(0.01, 2);
  for (std::size_t v : {1U, 4U}) {  // a glint over a fifth of two views
    for (Image<float>& channel : plane.views[v].full.color.channel) {
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 5; x < 15; ++x) channel(x, y) = 0.9F;
      }
    }
  }
  const ViewExposures found = estimate_exposures(plane.views, plane.depths_m);
  for (std::size_t v = 0; v < 6; ++v) EXPECT_NEAR(found.log_gain[v], kGains[v], 0.01) << v;
}

TEST(ViewExposures, AViewWithoutDepthsIsPlacedByTheOthersSurfaces) {
  Plane plane = six_views(0.01, 3);
  plane.depths_m[2] = {};
  plane.depths_m[3] = Image<float>(kWidth, kHeight, std::numeric_limits<float>::quiet_NaN());
  const ViewExposures found = estimate_exposures(plane.views, plane.depths_m);
  for (std::size_t v = 0; v < 6; ++v) EXPECT_NEAR(found.log_gain[v], kGains[v], 0.01) << v;
}

TEST(ViewExposures, AViewOfAnotherPlaceIsNotKnown) {
  Plane plane = six_views(0.01, 4);
  add_view(plane, 40, 0, 0.7, 0.01, Rng(4));
  const ViewExposures found = estimate_exposures(plane.views, plane.depths_m);
  ASSERT_EQ(found.status, ExposureStatus::ok);
  EXPECT_TRUE(std::isnan(found.log_gain[6]));
  EXPECT_TRUE(std::isnan(found.sigma[6]));
  EXPECT_EQ(found.gain_of(6), 0);
  for (std::size_t v = 0; v < 6; ++v) EXPECT_NEAR(found.log_gain[v], kGains[v], 0.01) << v;
}

// Two pairs of views of two places, and one wrong depth that says they share a point.
TEST(ViewExposures, OneWrongPointLinksNothing) {
  Plane plane;
  for (const double x_m : {0.0, 0.1, 40.0, 40.1})
    add_view(plane, x_m, 0, x_m < 1 ? 0.2 : -0.2, 0.01, Rng(11));
  SplatView& near = plane.views[2];  // sees one pixel of the first place
  near.camera_from_world = plane.views[0].camera_from_world;
  plane.depths_m[2] = Image<float>(kWidth, kHeight, std::numeric_limits<float>::quiet_NaN());
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 2; ++x) plane.depths_m[2](20 + x, 20 + y) = 1;
  }
  const ViewExposures found =
      estimate_exposures(plane.views, plane.depths_m, {.least_sightings = 100});
  ASSERT_EQ(found.status, ExposureStatus::ok);
  EXPECT_TRUE(std::isnan(found.log_gain[3]));
  EXPECT_NEAR(found.log_gain[0] - found.log_gain[1], 0, 0.01);
}

// Surfaces about the axis alone do not say what the corners have.
TEST(ViewExposures, CornersThatNoSurfaceShowsAreHeldNearNone) {
  for (std::uint64_t seed = 30; seed < 40; ++seed) {
    Plane plane = six_views(0.3, seed);
    for (Image<float>& depth_m : plane.depths_m) {
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          if (std::hypot(x - 23.5, y - 17.5) > 7)
            depth_m(x, y) = std::numeric_limits<float>::quiet_NaN();
        }
      }
    }
    for (SplatView& view : plane.views)  // all from one place, so that they share what they show
      view.camera_from_world = plane.views[0].camera_from_world;
    const ViewExposures found =
        estimate_exposures(plane.views, plane.depths_m, {.least_sightings = 10});
    ASSERT_EQ(found.status, ExposureStatus::ok);
    EXPECT_LT(std::abs(found.vignetting.log_at(1)), 1.5) << seed;
    EXPECT_GT(found.vignetting_sigma, 0.3) << seed;  // and it says so
  }
}

TEST(ViewExposures, TooLittleSaysSo) {
  Plane apart;
  EXPECT_EQ(estimate_exposures(apart.views, apart.depths_m).status, ExposureStatus::too_few_views);
  add_view(apart, 0, 0, 0, 0, Rng(1));
  EXPECT_EQ(estimate_exposures(apart.views, apart.depths_m).status, ExposureStatus::too_few_views);
  add_view(apart, 40, 0, 0, 0, Rng(1));
  const ViewExposures found = estimate_exposures(apart.views, apart.depths_m);
  EXPECT_EQ(found.status, ExposureStatus::too_few_sightings);
  EXPECT_TRUE(std::isnan(found.log_gain[0]));
  EXPECT_EQ(found.gain_of(0), 0);
  EXPECT_EQ(found.vignetting.log_at(1), 0);
}

TEST(ViewExposures, WhatIsBlackWhiteBehindOrWithoutWeightIsNoSurface) {
  Plane plane = six_views(0, 5);
  plane.views[1].full.color.channel[0] = Image<float>(kWidth, kHeight, 0.99F);
  for (Image<float>& channel : plane.views[4].full.color.channel)
    channel = Image<float>(kWidth, kHeight, 0.05F);
  const ViewExposures some = estimate_exposures(plane.views, plane.depths_m);
  for (std::size_t v = 0; v < 6; ++v)
    EXPECT_EQ(std::isnan(some.log_gain[v]), v == 1 || v == 4) << v;
  for (SplatView& view : plane.views) view.full.weight = Image<float>(kWidth, kHeight, 0.5F);
  EXPECT_EQ(estimate_exposures(plane.views, plane.depths_m).status,
            ExposureStatus::too_few_sightings);
  for (SplatView& view : plane.views) {
    view.full.weight = {};
    view.full.behind = Image<float>(kWidth, kHeight, 1.0F);
  }
  EXPECT_EQ(estimate_exposures(plane.views, plane.depths_m).status,
            ExposureStatus::too_few_sightings);
}

TEST(ViewExposures, ReexposingGivesThePhotographBack) {
  const Plane plane = six_views(0.02, 6);
  const SplatViewLevel& level = plane.views[1].full;
  const SplatViewLevel even = at_mean_exposure(level, 0.4, kLens);
  const ColorPlanes back = as_exposed(even.color, level.camera, 0.4, kLens);
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t i = 0; i < back.channel[c].size(); ++i)
      ASSERT_NEAR(back.channel[c].data()[i], level.color.channel[c].data()[i], 1e-5);
  }
  // Brighter than white as the mean camera would see it: kept, so that it comes back.
  const SplatViewLevel bright = at_mean_exposure(level, -3, {});
  EXPECT_GT(bright.color.channel[0](20, 20), 1);
}

TEST(ViewExposures, ErrorsNameWhatIsWrong) {
  Plane plane = six_views(0, 7);
  EXPECT_THROW(estimate_exposures(plane.views, std::span(plane.depths_m).first(5)),
               std::invalid_argument);
  EXPECT_THROW(estimate_exposures(plane.views, plane.depths_m, {.stride_px = 0}),
               std::invalid_argument);
  Plane small = plane;
  small.depths_m[0] = Image<float>(3, 3, 1.0F);
  EXPECT_THROW(estimate_exposures(small.views, small.depths_m), std::invalid_argument);
  small = plane;
  small.depths_m[0] = {};
  small.views[0].full.color.channel[1] = {};  // nothing is there to be read
  EXPECT_THROW(estimate_exposures(small.views, small.depths_m), std::invalid_argument);
  small = plane;
  small.views[0].full.weight = Image<float>(kWidth, 2, 1.0F);
  EXPECT_THROW(estimate_exposures(small.views, small.depths_m), std::invalid_argument);
}

// Depths of estimates: zero, negative, infinite.
TEST(ViewExposures, DepthsThatAreNoneAreLeftOut) {
  Plane plane = six_views(0.01, 8);
  for (int x = 0; x < kWidth; ++x) {
    plane.depths_m[0](x, 4) = 0;
    plane.depths_m[1](x, 6) = -1;
    plane.depths_m[2](x, 8) = std::numeric_limits<float>::infinity();
  }
  const ViewExposures found = estimate_exposures(plane.views, plane.depths_m);
  for (std::size_t v = 0; v < 6; ++v) EXPECT_NEAR(found.log_gain[v], kGains[v], 0.01) << v;
}

TEST(ViewExposures, TheSameBytesOnAnyNumberOfThreads) {
  const Plane plane = six_views(0.03, 9);
  const auto with = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return estimate_exposures(plane.views, plane.depths_m);
  };
  const ViewExposures one = with(1), four = with(4);
  EXPECT_EQ(std::memcmp(one.log_gain.data(), four.log_gain.data(), 6 * sizeof(double)), 0);
  EXPECT_EQ(one.vignetting.a, four.vignetting.a);
  EXPECT_EQ(one.scatter, four.scatter);
}

}  // namespace
}  // namespace cousin
