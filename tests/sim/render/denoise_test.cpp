#include "sim/render/denoise.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

#include "sim/render/truth_pass.h"
#include "tests/sim/render/test_scenes.h"

namespace cousin::test {
namespace {

Camera camera_of(int width, int height) {
  return {LensModel::pinhole, width, height, 1.2 * width, 1.2 * width, 0.5 * (width - 1),
          0.5 * (height - 1), {},    {}};
}

/// Balls on matt ground under a small lamp and an even sky: what noise there is comes from light,
/// not from a print's edges.
Scene balls() {
  Scene scene;
  scene.name = "balls";
  add(scene, square(0.3), matt(0.5F));
  for (int i = 0; i < 4; ++i) {
    Pose pose;
    pose.translation_m = Eigen::Vector3d(0.03 * i - 0.045, 0.01 * (i % 2), 0.012);
    add(scene, ellipsoid({0.012, 0.012, 0.012}, 12), matt(0.6F), pose);
  }
  scene.lights.emplace_back(Sky{{0.5F, 0.5F, 0.5F}, {0.5F, 0.5F, 0.5F}, {0.5F, 0.5F, 0.5F}});
  scene.lights.emplace_back(Lamp{{0.1, 0, 0.3}, {0.1, 0, 0}, {0, -0.1, 0}, {5, 5, 5}});
  return scene;
}

/// A view of them, traced by paths, with what guides the denoiser.
struct TracedView {
  Scene scene = balls();
  RayScene rays{scene};
  PathTracer tracer{rays, scene};
  TrueView view = view_from(camera_of(120, 80), {0, -0.12, 0.12}, {0, 0, 0.005});
  TruthImages guide =
      render_truth(rays, scene, view, {.depth = true, .normal = true, .position = true});

  PathImage at(int samples, std::uint64_t seed) const {
    return tracer.render(view, {.pixel_samples = samples}, Rng(seed));
  }
};

/// Mean over pixels of the squared luminance error relative to the truth.
double relative_error(const Image<Rgbf>& image, const Image<Rgbf>& truth) {
  double sum = 0;
  for (std::size_t i = 0; i < image.size(); ++i) {
    const auto g = static_cast<double>(truth.data()[i].g);
    sum += std::pow((static_cast<double>(image.data()[i].g) - g) / (g + 0.01), 2);
  }
  return sum / static_cast<double>(image.size());
}

TEST(Denoise, LeavesAThirdOfTheErrorOfFewSamplesAndNoMoreThanAllOfThatOfMany) {
  const TracedView traced;
  const Image<Rgbf> truth = traced.at(4096, 1).radiance;
  const PathImage few = traced.at(16, 2), many = traced.at(256, 3);
  const auto clean = [&](const PathImage& image) {
    return denoise(image, traced.view, traced.guide, {});
  };
  EXPECT_LT(relative_error(clean(few), truth), relative_error(few.radiance, truth) / 3);
  EXPECT_LT(relative_error(clean(many), truth), relative_error(many.radiance, truth));
}

TEST(Denoise, LeavesAnImageWithoutErrorAsItIs) {
  const TracedView traced;
  PathImage image = traced.at(16, 2);
  image.luminance_error = Image<float>(120, 80, 0.0F);
  EXPECT_EQ(denoise(image, traced.view, traced.guide, {}), image.radiance);
}

TEST(Denoise, DoesNotMixSurfacesThatStandApart) {
  const TracedView traced;
  // Grey noise everywhere, but brighter on what is nearer than the board's middle: only depth,
  // normals and positions tell the two apart where the noise hides the step.
  PathImage image;
  image.radiance = Image<Rgbf>(120, 80);
  image.luminance_error = Image<float>(120, 80, 0.5F);
  TruthImages guide = traced.guide;
  Rng rng(4);
  for (int y = 0; y < 80; ++y) {
    for (int x = 0; x < 120; ++x) {
      const bool left = x < 60;
      const auto value = static_cast<float>((left ? 1 : 1.5) + uniform(rng, -0.5, 0.5));
      image.radiance(x, y) = {value, value, value};
      guide.depth_m(x, y) = left ? 1.0F : 2.0F;
      guide.normal(x, y) = {0, 0, -1};
      const Eigen::Vector3f in_camera(static_cast<float>(x) / 144, static_cast<float>(y) / 144, 1);
      const Pose world_from_camera = inverse(traced.view.camera_from_world);
      guide.position_m(x, y) =
          (world_from_camera * (in_camera * guide.depth_m(x, y)).cast<double>().eval())
              .cast<float>();
    }
  }
  const Image<Rgbf> clean = denoise(image, traced.view, guide, {});
  double left = 0, right = 0;
  for (int y = 10; y < 70; ++y) {
    left += static_cast<double>(clean(59, y).g) / 60;
    right += static_cast<double>(clean(60, y).g) / 60;
  }
  // A window of 15 x 8 pixels has a standard error of 0.03, the mean of 60 rows far less.
  EXPECT_NEAR(left, 1, 0.03);
  EXPECT_NEAR(right, 1.5, 0.03);
}

TEST(Denoise, GivesTheSameBytesOnAnyNumberOfThreads) {
  const TracedView traced;
  const PathImage image = traced.at(16, 2);
  Image<Rgbf> first;
  for (const std::size_t threads : {1U, 2U, 7U}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const Image<Rgbf> clean = denoise(image, traced.view, traced.guide, {});
    if (threads == 1) first = clean;
    EXPECT_EQ(clean, first) << threads;
  }
}

TEST(Denoise, NamesWhatItLacks) {
  const TracedView traced;
  const PathImage image = traced.at(16, 2);
  const auto message = [&](const TruthImages& guide, const DenoiseConfig& config) {
    try {
      denoise(image, traced.view, guide, config);
    } catch (const std::invalid_argument& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  TruthImages lacking = traced.guide;
  lacking.normal = {};
  EXPECT_THAT(message(lacking, {}), testing::HasSubstr("the normal image is 0 x 0 px"));
  EXPECT_THAT(message(traced.guide, {.radius_px = 99}),
              testing::HasSubstr("radius_px = 99.000000 is not in 1..32"));
}

}  // namespace
}  // namespace cousin::test
