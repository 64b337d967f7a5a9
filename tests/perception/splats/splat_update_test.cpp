#include <gtest/gtest.h>

#include <algorithm>

#include "perception/splats/splat_frame.h"
#include "tests/perception/splats/random_splats.h"

namespace cousin {
namespace {

constexpr std::array<float, 3> kBlack{};

std::vector<const SplatKernels*> all_kernels() {
  std::vector<const SplatKernels*> all = {&portable_splat_kernels()};
  if (avx2_splat_kernels() != nullptr) all.push_back(avx2_splat_kernels());
  return all;
}

/// One image with gradients, ready for an update.
struct Ready {
  SplatPlanes values, first, second;
  SplatFrame frame;
  UpdateTask task;
};

Ready ready(const SplatKernels& kernels, const std::vector<Splat>& splats, const Camera& camera,
            const Pose& pose, const ColorPlanes& gradient) {
  Ready r;
  r.values = to_planes(splats);
  r.first = r.second = SplatPlanes(SplatPlane::count, r.values.size());
  draw_splats(kernels, r.values, 3, splat_camera(camera, pose, {0, 0, 0}, 0.05), kBlack,
              SplatDepths::none, r.frame);
  blend_gradients(kernels, gradient, kBlack, r.frame);
  r.task.camera = r.frame.camera;
  r.task.projected = r.frame.projected.data();
  r.task.partials = r.frame.partials.data();
  r.task.pair_first = r.frame.lists.pair_first.data();
  r.task.pair_count = r.frame.lists.pair_count.data();
  return r;
}

ColorPlanes random_gradient(int width, int height) {
  ColorPlanes planes;
  Rng rng(31);
  for (Image<float>& channel : planes.channel) {
    channel = Image<float>(width, height);
    for (float& x : channel) x = static_cast<float>(normal(rng));
  }
  return planes;
}

void point_at(Ready& r) {
  r.task.planes = &r.values;
  r.task.first_moment = &r.first;
  r.task.second_moment = &r.second;
}

// With both moments corrected from zero, m is the gradient and sqrt(v) its magnitude.
TEST(SplatUpdate, AFirstStepOfAdamIsItsRateAgainstTheGradient) {
  for (const SplatKernels* kernels : all_kernels()) {
    std::vector<Splat> splats = random_splats(100, 5);
    splats[7].centre_m = {90, 0, 0};  // not in the image
    Ready r = ready(*kernels, splats, pinhole(75, 53, 70), view_of_cube(), random_gradient(75, 53));
    const SplatPlanes before = r.values;
    const SplatPlanes gradient = parameter_gradients(*kernels, r.values, r.frame);
    point_at(r);
    AdamRate* rates[] = {&r.task.centre,  &r.task.log_scale, &r.task.rotation,
                         &r.task.opacity, &r.task.dc,        &r.task.rest};
    const auto scale = static_cast<float>(1 / std::sqrt(1 - 0.999));
    for (AdamRate* rate : rates) *rate = {0.01F / (1 - 0.9F), scale};
    kernels->update(r.task, 0, r.values.padded());
    int moved = 0;
    for (int k = 0; k < SplatPlane::count; ++k) {
      for (int i = 0; i < 100; ++i) {
        const float g = gradient.at(k, i);
        const float step = r.values.at(k, i) - before.at(k, i);
        if (g == 0) {
          EXPECT_EQ(step, 0) << k << " of " << i;
        } else if (std::abs(g) > 1e-6F) {
          // A float near 1 keeps 6e-8; the rate's own rounding is 1e-6 of it.
          EXPECT_NEAR(step, g > 0 ? -0.01 : 0.01, 2e-6) << k << " of " << i;
          ++moved;
        }
      }
      EXPECT_EQ(r.values.at(k, 7), before.at(k, 7));
    }
    EXPECT_GT(moved, 4000) << kernels->name;
  }
}

TEST(SplatUpdate, CoefficientsBeyondTheFirstWaitForTheirTurn) {
  for (const SplatKernels* kernels : all_kernels()) {
    Ready r = ready(*kernels, random_splats(50, 5), pinhole(75, 53, 70), view_of_cube(),
                    random_gradient(75, 53));
    const SplatPlanes before = r.values;
    point_at(r);
    r.task.with_rest = false;
    r.task.rest = r.task.dc = {1, 1};
    kernels->update(r.task, 0, r.values.padded());
    EXPECT_NE(r.values.at(SplatPlane::dc, 3), before.at(SplatPlane::dc, 3));
    for (int k = SplatPlane::rest; k < SplatPlane::count; ++k) {
      for (int i = 0; i < 50; ++i) {
        EXPECT_EQ(r.values.at(k, i), before.at(k, i));
        EXPECT_EQ(r.second.at(k, i), 0);
      }
    }
  }
}

TEST(SplatUpdate, PullsOfDifferentTilesDoNotCancelWhenSummedByTile) {
  // A disc whose middle is the corner of four tiles, pulled outwards on all sides alike.
  std::vector<Splat> one(1);
  one[0].centre_m = {0, 0, 1};
  one[0].log_scale.setConstant(std::log(0.1F));
  Camera camera = pinhole(64, 64, 60);
  camera.fy_px = 60;
  camera.cx_px = camera.cy_px = 31.5;
  ColorPlanes outwards;
  for (Image<float>& channel : outwards.channel) channel = Image<float>(64, 64, 1.0F);
  for (const SplatKernels* kernels : all_kernels()) {
    const auto sum = [&](bool by_tile) {
      Ready r = ready(*kernels, one, camera, Pose{}, outwards);
      point_at(r);
      std::vector<float> sums(8, 0), counts(8, 0);
      r.task.by_tile = by_tile;
      r.task.gradient_sum = sums.data();
      r.task.gradient_count = counts.data();
      kernels->update(r.task, 0, 8);
      EXPECT_EQ(counts[0], 1);
      EXPECT_EQ(counts[1], 0);
      return sums[0];
    };
    EXPECT_GT(sum(true), 100 * sum(false)) << kernels->name;
    EXPECT_GT(sum(true), 0);
  }
}

TEST(SplatUpdate, TheOrderOfGaussiansChangesNoByteOfTheImage) {
  std::vector<Splat> splats = random_splats(500, 17);
  const Camera camera = pinhole(75, 53, 70);
  const ColorPlanes gradient = random_gradient(75, 53);
  for (const SplatKernels* kernels : all_kernels()) {
    const Ready forwards = ready(*kernels, splats, camera, view_of_cube(), gradient);
    std::vector<Splat> reversed = splats;
    std::reverse(reversed.begin(), reversed.end());
    const Ready backwards = ready(*kernels, reversed, camera, view_of_cube(), gradient);
    EXPECT_TRUE(forwards.frame.color.channel == backwards.frame.color.channel);
  }
}

}  // namespace
}  // namespace cousin
