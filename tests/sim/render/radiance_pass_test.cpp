#include "sim/render/radiance_pass.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "tests/sim/render/test_scenes.h"

namespace cousin::test {
namespace {

Camera small_camera(int width, int height, double focal) {
  return strong_lens(LensModel::pinhole, width, height, focal);
}

double mean_green(const Image<Rgbf>& image) {
  double sum = 0;
  for (const Rgbf& p : image) sum += static_cast<double>(p.g);
  return sum / static_cast<double>(image.size());
}

TEST(RadiancePass, WhiteBallUnderEvenSkyCannotBeSeen) {
  // Albedo 1 under any coat reflects all light: every pixel is 1 in an even sky of radiance 1.
  for (const double ior : {1.0, 1.5}) {
    for (const double roughness : {0.2, 0.5, 1.0}) {
      Scene scene;
      Material white = matt(1);
      white.ior = ior;
      white.roughness = roughness;
      add(scene, ellipsoid({1, 0.8, 0.7}, 20), white);
      scene.lights.emplace_back(Sky{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}});
      const RayScene rays(scene);
      const RadianceConfig config{.irradiance_samples = 64, .max_bounces = 1, .board_texel_m = 1};
      const IrradianceCache cache(rays, scene, config, Rng(1));
      const TrueView view = view_from(small_camera(48, 48, 60), {0, -3, 1}, {0, 0, 0});
      const Image<Rgbf> image = render_radiance(rays, scene, cache, view, config, Rng(2));
      // The table of the coat's reflection is linear in 128 cells: 0.3 % near the outline.
      EXPECT_NEAR(mean_green(image), 1, 0.003) << "ior " << ior << " roughness " << roughness;
      for (const Rgbf& p : image) {
        // A matt pixel varies only by the flat faces near the outline; a glossy one by its four
        // draws.
        EXPECT_NEAR(p.g, 1, ior > 1 ? 0.35 : 0.02);
      }
    }
  }
}

TEST(RadiancePass, GreyCoatedBallReflectsBetweenItsBaseAndWhite) {
  Scene scene;
  Material grey = matt(0.3F);
  grey.ior = 1.5;
  add(scene, ellipsoid({1, 1, 1}, 20), grey);
  scene.lights.emplace_back(Sky{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}});
  const RayScene rays(scene);
  const RadianceConfig config{.max_bounces = 0, .board_texel_m = 1};
  const IrradianceCache cache(rays, scene, config, Rng(1));
  // Face on, radiance is E + (1 - E) a with E = 0.04 (1 +- 5 % for the roughness).
  const TrueView view = view_from(small_camera(32, 32, 400), {0, -3, 0}, {0, 0, 0});
  const Image<Rgbf> image = render_radiance(rays, scene, cache, view, config, Rng(2));
  EXPECT_NEAR(mean_green(image), 0.04 + 0.96 * 0.3, 0.003);
}

TEST(RadiancePass, IntegratingSphereHasItsClosedForm) {
  // Inside a sphere of albedo a, light bounced n times lights every point alike: flux / area * sum
  // of a^k.
  constexpr double kAlbedo = 0.6;
  constexpr int kBounces = 3;
  Scene scene;
  add(scene, inside_out(ellipsoid({1, 1, 1}, 24)), matt(static_cast<float>(kAlbedo)));
  scene.lights.emplace_back(Lamp{{0, 0, 0.1}, {0.1, 0, 0}, {0, 0.1, 0}, {100, 100, 100}});
  const RayScene rays(scene);
  const RadianceConfig config{
      .irradiance_samples = 256, .max_bounces = kBounces, .board_texel_m = 0.2};
  const IrradianceCache cache(rays, scene, config, Rng(1));
  // The lower half gets no direct light; look straight down from below the lamp.
  const TrueView view =
      view_from(small_camera(32, 32, 60), {0, 0, -0.1}, {0, 0, -1}, Eigen::Vector3d::UnitY());
  const Image<Rgbf> image = render_radiance(rays, scene, cache, view, config, Rng(2));
  const double flux = 100 * std::numbers::pi * 0.04;
  double series = 0;
  for (int k = 1; k <= kBounces; ++k) series += std::pow(kAlbedo, k);
  const double expected = flux / (4 * std::numbers::pi) * series * kAlbedo / std::numbers::pi;
  // Of the mesh: chords of 24 cells a face shrink area by 0.3 %.
  EXPECT_NEAR(mean_green(image) / expected, 1, 0.01);
}

TEST(RadiancePass, SunOnAPlaneIsLambert) {
  Scene scene;
  add(scene, square(1), matt(0.5F));
  const Eigen::Vector3d to_sun = Eigen::Vector3d(0.3, 0.2, 0.8).normalized();
  scene.lights.emplace_back(Sun{to_sun, 0.00465, {2, 2, 2}});
  const RayScene rays(scene);
  const RadianceConfig config{.max_bounces = 0};
  const IrradianceCache cache(rays, scene, config, Rng(1));
  const TrueView view = view_from(small_camera(16, 16, 60), {0, -0.3, 0.8}, {0, 0, 0});
  const Image<Rgbf> image = render_radiance(rays, scene, cache, view, config, Rng(2));
  EXPECT_NEAR(mean_green(image), 0.5 / std::numbers::pi * 2 * to_sun.z(), 1e-4);
}

TEST(RadiancePass, SameBytesOnAnyNumberOfThreads) {
  const Scene scene = table_top(3, 6);
  const RadianceConfig config{
      .edge_samples = 16, .irradiance_samples = 16, .max_bounces = 1, .board_texel_m = 0.004};
  const TrueView view =
      view_from(strong_lens(LensModel::opencv5, 80, 60, 90), {0.1, -0.1, 0.15}, {0, 0, 0});
  std::vector<Image<Rgbf>> images;
  for (const std::size_t threads : {1U, 2U, 7U}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const RayScene rays(scene);
    const IrradianceCache cache(rays, scene, config, Rng(1));
    images.push_back(render_radiance(rays, scene, cache, view, config, Rng(2)));
  }
  EXPECT_EQ(images[0], images[1]);
  EXPECT_EQ(images[0], images[2]);
}

TEST(RadiancePass, IndependentRendersDifferByLessThanAQuarterOfTheSensorsVariance) {
  const Scene scene = table_top(4, 6);
  // Half of this close view is ink, where the sensor's own noise is least: nine samples instead of
  // four.
  const RadianceConfig config{
      .pixel_samples = 9, .irradiance_samples = 32, .max_bounces = 2, .board_texel_m = 0.0008};
  const RayScene rays(scene);
  // Squares of 14 px, as at 46 cm in an image 1280 px wide.
  const TrueView view =
      view_from(strong_lens(LensModel::opencv5, 240, 180, 700), {0.1, -0.16, 0.24}, {0, 0, 0});
  std::vector<Image<Rgbf>> images;
  for (const std::uint64_t seed : {1U, 2U}) {
    const IrradianceCache cache(rays, scene, config, Rng(seed));
    images.push_back(render_radiance(rays, scene, cache, view, config, Rng(seed + 10)));
  }
  // A sensor of 6000 electrons at radiance 1 with 2 electrons of read noise.
  double ratio = 0, difference = 0;
  for (std::size_t i = 0; i < images[0].size(); ++i) {
    const double a = static_cast<double>(images[0].data()[i].g),
                 b = static_cast<double>(images[1].data()[i].g);
    ratio += 0.5 * (a - b) * (a - b) / ((0.5 * (a + b) * 6000 + 4) / 36e6);
    difference += a - b;
  }
  const auto count = static_cast<double>(images[0].size());
  EXPECT_LT(ratio / count, 0.25);
  EXPECT_LT(std::abs(difference / count), 0.002);  // the mean of 43 200 pixels agrees
}

TEST(RadiancePass, RefusesConfigurationsAndLightsThatMakeNoSense) {
  EXPECT_THROW(validate(RadianceConfig{.pixel_samples = 5}), std::invalid_argument);
  EXPECT_THROW(validate(RadianceConfig{.pixel_samples = 1}), std::invalid_argument);
  EXPECT_THROW(validate(RadianceConfig{.max_bounces = -1}), std::invalid_argument);
  EXPECT_THROW(validate(RadianceConfig{.board_texel_m = std::nan("")}), std::invalid_argument);
  Scene scene = table_top(1, 3);
  scene.lights.emplace_back(Lamp{{0, 0, 1}, {1, 0, 0}, {2, 0, 0}, {1, 1, 1}});
  EXPECT_THROW(RayScene{scene}, std::invalid_argument);
  const Scene good = table_top(1, 3);
  const RayScene rays(good);
  EXPECT_THROW(IrradianceCache(rays, scene, {}, Rng(1)), std::invalid_argument);
}

}  // namespace
}  // namespace cousin::test
