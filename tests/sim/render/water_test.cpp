#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "benchmarks/suites/light/closed_form_case.h"
#include "sim/render/path_tracer.h"
#include "sim/render/ray_scene.h"

namespace cousin {
namespace {

using namespace closed_form;
using Eigen::Vector3d;

constexpr double kWater = 1.333;

Material water() { return grey(1, SurfaceKind::clear, kWater); }

double mean_green(const Image<Rgbf>& image) {
  double sum = 0;
  for (const Rgbf& c : image) sum += static_cast<double>(c.g);
  return sum / static_cast<double>(image.size());
}

double mean_radiance(const Scene& scene, const TrueView& view, int samples, int bounces) {
  const RayScene rays(scene);
  return mean_green(PathTracer(rays, scene)
                        .render(view, {.pixel_samples = samples, .max_bounces = bounces}, Rng(1))
                        .radiance);
}

Instance another(Scene& scene, ObjectModel model, Material material, const Vector3d& at_m) {
  Instance instance;
  instance.id = static_cast<int>(scene.instances.size()) + 1;
  instance.name = "thing " + std::to_string(instance.id);
  instance.model = static_cast<int>(scene.models.size());
  instance.material = static_cast<int>(scene.materials.size());
  instance.world_from_object.translation_m = at_m;
  scene.models.push_back(std::move(model));
  scene.materials.push_back(std::move(material));
  scene.instances.push_back(instance);
  return instance;
}

TEST(Water, RefractsBySnellsLaw) {
  // A pool 1 m deep, seen at 45 degrees through the point above the origin: the ray meets the
  // bottom tan(asin(sin 45 / 1.333)) = 0.6259 of its depth further on. A floor that a lamp in the
  // water lights begins just before or just after.
  const double through_m = std::tan(std::asin(std::sqrt(0.5) / kWater));
  const auto seen = [&](double border_m) {
    Scene scene =
        scene_of(box({5, 5, 0.5}), water(), {Lamp{{0, 0, 0.4}, {2, 0, 0}, {0, -2, 0}, {1, 1, 1}}});
    another(scene, square(1), grey(0.8F), {0, border_m + 1, -0.499});
    return mean_radiance(scene, view_from({0, -1, 1.5}, {0, 0, 0.5}, 1e5), 16, 1);
  };
  EXPECT_GT(seen(0.999 * through_m - 0.001), 0.3);
  // Else the box's bottom, which mirrors 3 % of the lamp.
  EXPECT_LT(seen(0.999 * through_m + 0.002), 0.05);
}

TEST(Water, MirrorsByFresnelsShareAndTotallyFromBelow) {
  // Straight down on water over a black floor, under a sky of 1: ((n - 1) / (n + 1))^2.
  Scene pool = scene_of(box({5, 5, 0.5}), water(), {even_sky(1)});
  another(pool, square(6), grey(0), {0, 0, 0});
  const double share = std::pow((kWater - 1) / (kWater + 1), 2);
  // 32 x 32 x 256 choices of a share of 0.02: sigma is 1.4 % of it, less by stratification.
  EXPECT_NEAR(mean_radiance(pool, view_from({0.3, 0.2, 2}, {0.3, 0.2, 0}, 2e4), 256, 4), share,
              0.03 * share);
  // From in the water at 60 degrees, beyond the critical angle of 48.6: the sky is not seen, but
  // all of the white floor that the surface mirrors.
  Scene bright = scene_of(box({50, 50, 0.5}), water(), {});
  bright.lights.emplace_back(Lamp{{0, 0, -0.45}, {40, 0, 0}, {0, 40, 0}, {1, 1, 1}});
  bright.lights.emplace_back(Sky{{7, 7, 7}, {7, 7, 7}, {7, 7, 7}});
  const double at = mean_radiance(
      bright, view_from({0, 0, 0}, {0, std::tan(std::numbers::pi / 3) * 0.5, 0.5}, 2e3), 16, 0);
  EXPECT_NEAR(at, 1, 1e-5);
}

/// A white floor below a plate of water.
Scene below_plate(const Light& light) {
  Scene scene = scene_of(box({500, 500, 0.05}), water(), {light});
  another(scene, square(400), grey(1), {0, 0, -0.2});
  return scene;
}

TEST(Water, LosesNothingOfASkyAboveAWhiteFloor) {
  // 2^16 samples of light that is mirrored up and down: the furnace.
  EXPECT_NEAR(
      mean_radiance(below_plate(even_sky(1)), view_from({0, 0, -0.1}, {0, 0, -0.2}, 2e3), 64, 64),
      1, 0.02);
}

TEST(Water, SunsShineStraightThroughOrAsRefractedPathsFindThem) {
  const Vector3d to_sun = Vector3d(0.5, 0, 1).normalized();
  const TrueView view = view_from({0, 0, -0.1}, {0, 0, -0.2}, 2e3);
  // A plate mirrors at both faces; of light from the air each lets 1 - F through.
  const double cosine = to_sun.z();
  const double g = std::sqrt(kWater * kWater - 1 + cosine * cosine);
  const double a = (g - cosine) / (g + cosine);
  const double b = (cosine * (g + cosine) - 1) / (cosine * (g - cosine) + 1);
  const double through = 1 - 0.5 * a * a * (1 + b * b);
  const Scene narrow = below_plate(Sun{to_sun, 1e-4, {1, 1, 1}});
  EXPECT_NEAR(mean_radiance(narrow, view, 16, 0), through * through * cosine / std::numbers::pi,
              1e-5);
  // A disk of 0.2 rad is met often enough for paths to find it: what is mirrored to and fro within
  // the plate, F^2 of it, they have besides, and what the plate and the floor throw to and fro.
  const Scene wide = below_plate(Sun{to_sun, 0.2, {1, 1, 1}});
  const RayScene rays(wide);
  const PathTracer tracer(rays, wide);
  const auto mean = [&](bool refracts_sun) {
    const PathConfig config{.pixel_samples = 256, .max_bounces = 6, .refracts_sun = refracts_sun};
    return mean_green(tracer.render(view, config, Rng(1)).radiance);
  };
  EXPECT_NEAR(mean(true) / mean(false), 1, 0.03);
}

TEST(Water, ASunMirroredByADropIsSeenOnce) {
  // Camera, water, sun: the glint has the mirrored share of the disk's radiance, whichever way
  // shadow rays go.
  const double share = std::pow((kWater - 1) / (kWater + 1), 2);
  Scene scene = scene_of(box({5, 5, 0.5}), water(), {Sun{Vector3d::UnitZ(), 0.01, {1, 1, 1}}});
  another(scene, square(6), grey(0), {0, 0, 0});
  const double disk = 1 / (std::numbers::pi * std::pow(std::sin(0.01), 2));
  EXPECT_NEAR(mean_radiance(scene, view_from({0, 0, 2}, {0, 0, 0}, 2e4), 256, 4) / disk, share,
              0.03 * share);
}

TEST(Water, NeedsAnIndexAboveOne) {
  Scene scene = scene_of(box({1, 1, 1}), grey(1, SurfaceKind::clear, 1), {});
  EXPECT_THROW(RayScene{scene}, std::invalid_argument);
}

}  // namespace
}  // namespace cousin
