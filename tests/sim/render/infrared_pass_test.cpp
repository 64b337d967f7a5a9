#include "sim/render/infrared_pass.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "sim/render/clear_sky.h"
#include "tests/sim/render/test_scenes.h"

namespace cousin {
namespace {

using test::add;
using test::square;
using test::view_from;

constexpr double kPi = std::numbers::pi;

Camera small_camera() {
  Camera camera;
  camera.width_px = 64;
  camera.height_px = 48;
  camera.fx_px = camera.fy_px = 60;
  camera.cx_px = 31.5;
  camera.cy_px = 23.5;
  return camera;
}

Material infrared_matt(float albedo, float transmittance = 0) {
  Material material = test::matt(0.5F);
  material.infrared_albedo = albedo;
  material.infrared_transmittance = transmittance;
  return material;
}

/// A floor in z = 0 seen from a metre above.
Scene floor_scene(float albedo) {
  Scene scene;
  add(scene, square(5), infrared_matt(albedo));
  return scene;
}
TrueView from_above() {
  return view_from(small_camera(), {0, 0, 1}, {0, 0, 0}, Eigen::Vector3d::UnitY());
}

/// An even projector at the camera's place, of 1 W/sr.
Projector even_projector(const TrueView& view) {
  Projector projector;
  projector.world_from_projector = inverse(view.camera_from_world);
  projector.lens = small_camera();
  projector.lens.fx_px = projector.lens.fy_px = 30;  // twice as wide
  projector.intensity = Image<Rgbf>(64, 48, Rgbf{1, 1, 1});
  return projector;
}

InfraredImage render(const Scene& scene, const TrueView& view,
                     const std::vector<Projector>& projectors, InfraredConfig config = {}) {
  return render_infrared(RayScene(scene), scene, view, projectors, config, Rng(1));
}

TEST(InfraredPass, AProjectorLightsAWallByTheInverseSquareAndTheCosine) {
  const TrueView view = from_above();
  const InfraredImage image =
      render(floor_scene(0.6F), view, {even_projector(view)}, {.speckle_contrast = 0});
  for (const auto& [x, y] : {std::pair{31, 23}, {5, 5}, {60, 40}, {0, 0}}) {
    const double u = (x - 31.5) / 60, v = (y - 23.5) / 60;
    const double cosine = 1 / std::sqrt(1 + u * u + v * v);
    // Distance 1 / cosine: 1/d^2 and the cosine together are its cube. A pixel spans 1/60, over
    // which this is nearly linear: 1e-3 is left.
    EXPECT_NEAR(image.radiance(x, y), 0.6 / kPi * std::pow(cosine, 3), 1e-3) << x << " " << y;
    EXPECT_EQ(image.projected(x, y), 1);
  }
}

TEST(InfraredPass, NothingOutsideTheProjectorsPictureIsLit) {
  const TrueView view = from_above();
  Projector narrow = even_projector(view);
  narrow.lens.fx_px = narrow.lens.fy_px = 240;  // a quarter of the camera's view each way
  const InfraredImage image = render(floor_scene(0.6F), view, {narrow}, {.speckle_contrast = 0});
  EXPECT_EQ(image.radiance(2, 2), 0);
  EXPECT_EQ(image.projected(2, 2), 0);
  EXPECT_GT(image.radiance(31, 23), 0.1F);
}

TEST(InfraredPass, AnObjectThrowsTheProjectorsShadowBySimilarTriangles) {
  Scene scene = floor_scene(0.6F);
  // A plate of half size 0.05 at half the height; the projector 0.4 to the side of the camera
  // throws its shadow from x = -0.4 - 0.1 to -0.4 + 0.1 on the floor.
  Pose half_way;
  half_way.translation_m = {0, 0, 0.5};
  add(scene, square(0.05), infrared_matt(0.6F), half_way);
  const TrueView view = from_above();
  Projector projector = even_projector(view);
  projector.world_from_projector.translation_m.x() += 0.4;
  projector.lens.fx_px = projector.lens.fy_px = 15;
  const InfraredImage image = render(scene, view, {projector}, {.speckle_contrast = 0});
  double dark = 0;
  for (int x = 0; x < 64; ++x) dark += 1 - image.projected(x, 23);
  // 0.2 m at 60 px/m; the ends are drawn by four samples a pixel.
  EXPECT_NEAR(dark, 0.2 * 60, 0.5);
  const int centre = static_cast<int>(std::lround(31.5 - 0.4 * 60));
  EXPECT_EQ(image.projected(centre, 23), 0);
}

TEST(InfraredPass, SunAndEvenSkyGiveTheirIrradiance) {
  const TrueView view = from_above();
  Scene sunny = floor_scene(0.5F);
  Sun sun;
  sun.to_sun = Eigen::Vector3d(0, std::sin(0.5), std::cos(0.5));
  sun.irradiance = {3, 2, 1};
  sunny.lights.emplace_back(sun);
  EXPECT_NEAR(render(sunny, view, {}, {.sun_share = 0.6}).radiance(20, 20),
              0.5 / kPi * 0.6 * 2 * std::cos(0.5), 1e-6);
  Scene cloudy = floor_scene(0.5F);
  cloudy.lights.emplace_back(Sky{{1, 2, 3}, {1, 2, 3}, {0, 0, 0}});
  // Irradiance pi L; the table's quadrature of 64 x 64 is good to 1e-3.
  EXPECT_NEAR(render(cloudy, view, {}, {.sky_share = 0.2}).radiance(20, 20), 0.5 * 0.2 * 2, 2e-4);
}

/// Share of an even sky that a parallel square of half size `half` at height `height` hides from
/// the point below its middle: four times the form factor of a corner.
double hidden_share(double half, double height) {
  const double x = half / height, root = std::sqrt(1 + x * x);
  return 4 / kPi * x / root * std::atan(x / root);
}

TEST(InfraredPass, ARoofHidesItsFormFactorOfTheSky) {
  Scene scene = floor_scene(0.5F);
  Pose above;
  above.translation_m = {0, 0, 2};  // the camera is between floor and roof
  add(scene, square(1), infrared_matt(0.5F), above);
  scene.lights.emplace_back(Sky{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}});
  const InfraredImage image =
      render(scene, from_above(), {}, {.pixel_samples = 64, .sky_share = 1});
  // 1024 points of a (0, 2) sequence over 16 pixels: an edge across the square costs some 1 / 1024
  // to 1 / 100, and the pixels span 0.07 m, over which the factor changes by 1e-3.
  EXPECT_NEAR(image.radiance(31, 23) / 0.5, 1 - hidden_share(1, 2), 0.01);
  scene.instances.pop_back();
  EXPECT_NEAR(render(scene, from_above(), {}, {.sky_share = 1}).radiance(31, 23) / 0.5, 1, 1e-3);
}

TEST(InfraredPass, TheGroundsLightIsNotHidden) {
  // A leaf over a floor: what comes from below stands for what the floor throws back.
  Scene scene = floor_scene(0.5F);
  Pose half_way;
  half_way.translation_m = {0, 0, 0.5};
  add(scene, square(5), infrared_matt(0.0F, 0.4F), half_way);
  scene.lights.emplace_back(Sky{{0, 0, 0}, {0, 0, 0}, {1, 1, 1}});
  EXPECT_NEAR(render(scene, from_above(), {}, {.sky_share = 1}).radiance(31, 23), 0.4, 1e-3);
}

TEST(InfraredPass, ALampThrowsAPenumbraAsWideAsItsFaceMakesIt) {
  Scene scene = floor_scene(0.5F);
  Lamp lamp;
  lamp.centre_in_world_m = {0, 0, 2};
  lamp.axis_u_m = {0.1, 0, 0};
  lamp.axis_v_m = {0, -0.1, 0};  // shines down
  lamp.radiance = {1, 1, 1};
  scene.lights.emplace_back(lamp);
  const InfraredImage open = render(scene, from_above(), {}, {.lamp_share = 1});
  ASSERT_GT(open.radiance(31, 23), 0);
  Pose blind;
  blind.translation_m = {-3, 0, 1.5};
  add(scene, square(3), infrared_matt(0.5F), blind);  // its edge is at x = 0
  const InfraredImage half = render(scene, from_above(), {}, {.lamp_share = 1});
  // From the edge, 0.5 below the lamp and 1.5 above the floor, its 0.2 m become 0.6 m of penumbra.
  const auto lit = [&](double x_m) {
    const int x = static_cast<int>(std::lround(31.5 + 60 * x_m));
    double sum = 0, all = 0;
    for (int y = 0; y < 48; ++y) {
      sum += static_cast<double>(half.radiance(x, y));
      all += static_cast<double>(open.radiance(x, y));
    }
    return sum / all;
  };
  const bool right_is_positive = lit(0.45) > lit(-0.45);
  const double side = right_is_positive ? 1 : -1;
  EXPECT_EQ(lit(-0.45 * side), 0);
  EXPECT_NEAR(lit(0.45 * side), 1, 1e-6);
  // 48 rows of 4 samples: a standard error of 0.035; a column is 0.03 of the penumbra.
  for (const double x : {-0.15, 0.0, 0.15}) EXPECT_NEAR(lit(x * side), (x + 0.3) / 0.6, 0.14) << x;
}

TEST(InfraredPass, TheSunShinesThroughTheSameAirAsInTheVisible) {
  Scene scene = floor_scene(0.5F);
  ClearSky sky;
  sky.turbidity = 3;
  scene.lights.emplace_back(sky);
  // Rayleigh 0.01695 and aerosol 0.09238 * 1.2352 = 0.11411 at 0.85 um; air mass 0.99943.
  const double share = std::exp(-0.99943 * (0.016954 + 0.114108));
  EXPECT_NEAR(clear_air_transmittance(sky, 850e-9), share, 1e-4);
  EXPECT_LT(clear_air_transmittance(sky, 450e-9), 0.75 * share);
  EXPECT_NEAR(render(scene, from_above(), {}, {.sun_share = 0.5, .sky_share = 0}).radiance(31, 23),
              0.5 / kPi * 0.5 * 128 * share, 2e-3);
}

TEST(InfraredPass, ALeafShinesOnItsFarSideByItsTransmittance) {
  Scene scene;
  add(scene, square(5), infrared_matt(0.5F, 0.4F));
  Sun sun;
  sun.to_sun = Eigen::Vector3d(0, 0, -1);  // from below
  sun.irradiance = {1, 1, 1};
  scene.lights.emplace_back(sun);
  EXPECT_NEAR(render(scene, from_above(), {}, {.sun_share = 1}).radiance(20, 20), 0.4 / kPi, 1e-6);
}

TEST(InfraredPass, SpeckleHasItsContrastStaysWithAStaticSceneAndMovesWithTheSurface) {
  const TrueView view = from_above();
  const std::vector<Projector> projectors = {even_projector(view)};
  const InfraredConfig config{.speckle_contrast = 0.3};
  Scene scene = floor_scene(0.6F);
  const InfraredImage even = render(scene, view, projectors, {.speckle_contrast = 0});
  const InfraredImage once = render(scene, view, projectors, config);
  EXPECT_EQ(once.radiance, render(scene, view, projectors, config).radiance);
  double n = 0, sum = 0, squares = 0;
  for (std::size_t i = 0; i < once.radiance.size(); ++i) {
    const double gain = once.radiance.data()[i] / even.radiance.data()[i];
    n += 1;
    sum += gain;
    squares += gain * gain;
  }
  const double mean = sum / n, sigma = std::sqrt(squares / n - mean * mean);
  // 3072 draws: standard errors 0.3/sqrt(n) = 0.0054 and, with a Gamma's kurtosis, 0.0043.
  EXPECT_NEAR(mean, 1, 4 * 0.0054);
  EXPECT_NEAR(sigma, 0.3, 4 * 0.0043);

  scene.instances[0].world_from_object.translation_m.z() = -0.01;  // a pixel's size is 17 mm
  const InfraredImage moved = render(scene, view, projectors, config);
  double product = 0;
  for (std::size_t i = 0; i < once.radiance.size(); ++i) {
    product += (once.radiance.data()[i] / even.radiance.data()[i] - mean) *
               (moved.radiance.data()[i] * 1.0201 / even.radiance.data()[i] - mean);
  }
  EXPECT_LT(std::abs(product / n), 4 * 0.09 / std::sqrt(n));  // uncorrelated
}

TEST(InfraredPass, GivesTheSameBytesForAnyNumberOfThreads) {
  const Scene scene = test::table_top(4, 6);
  const TrueView view = view_from(small_camera(), {0, -0.2, 0.3}, {0, 0, 0});
  const std::vector<Projector> projectors = {even_projector(view)};
  const auto with_threads = [&](std::size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    return render(scene, view, projectors);
  };
  const InfraredImage one = with_threads(1);
  EXPECT_EQ(one.radiance, with_threads(2).radiance);
  EXPECT_EQ(one.radiance, with_threads(7).radiance);
}

TEST(InfraredPass, RejectsWhatItCannotRender) {
  const TrueView view = from_above();
  const Scene scene = floor_scene(0.5F);
  EXPECT_THROW(render(scene, view, {}, {.pixel_samples = 3}), std::invalid_argument);
  EXPECT_THROW(render(scene, view, {}, {.speckle_contrast = -1}), std::invalid_argument);
  Projector projector = even_projector(view);
  projector.intensity = Image<Rgbf>(3, 3);
  EXPECT_THROW(render(scene, view, {projector}), std::invalid_argument);
  EXPECT_THROW(render_infrared(RayScene(test::table_top(1, 4)), scene, view, {}, {}, Rng(1)),
               std::invalid_argument);
}

}  // namespace
}  // namespace cousin
