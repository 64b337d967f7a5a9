#include "sim/render/path_tracer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <numbers>
#include <stdexcept>

#include "benchmarks/suites/light/closed_forms.h"
#include "benchmarks/suites/light/leafy_scene.h"
#include "tests/sim/render/test_scenes.h"

namespace cousin::test {
namespace {

constexpr double kPi = std::numbers::pi;

/// A pinhole with its centre in the middle.
Camera small_camera(int width, int height, double focal_px) {
  Camera camera;
  camera.width_px = width;
  camera.height_px = height;
  camera.fx_px = camera.fy_px = focal_px;
  camera.cx_px = 0.5 * (width - 1);
  camera.cy_px = 0.5 * (height - 1);
  return camera;
}

Sky even_sky(float radiance) {
  const Rgbf c{radiance, radiance, radiance};
  return {c, c, c};
}

double mean_green(const Image<Rgbf>& image) {
  double sum = 0;
  for (const Rgbf& c : image) sum += static_cast<double>(c.g);
  return sum / static_cast<double>(image.size());
}

/// Leaves, a coated ball, metal, glass, sky, sun, lamp and beam together.
Scene mixed_scene() {
  Scene scene = table_top(2, 6);
  Material leaf = matt(0.4F);
  leaf.kind = SurfaceKind::leaf;
  leaf.transmittance = {0.3F, 0.4F, 0.2F};
  leaf.ior = 1.4;
  Pose above;
  above.translation_m = {0.01, 0, 0.03};
  above.rotation = Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitX());
  add(scene, square(0.01), leaf, above);
  Material metal = matt(0.9F);
  metal.kind = SurfaceKind::conductor;
  metal.roughness = 0.3;
  Pose aside;
  aside.translation_m = {-0.02, 0.02, 0.008};
  add(scene, ellipsoid({0.006, 0.006, 0.006}, 8), metal, aside);
  Material glass = matt(1);
  glass.kind = SurfaceKind::glass;
  glass.roughness = 0.1;
  glass.ior = 1.5;
  aside.translation_m = {0.02, -0.02, 0.008};
  add(scene, ellipsoid({0.006, 0.006, 0.006}, 8), glass, aside);
  Material soil = matt(0.2F);
  soil.noise = NoiseTexture{{0.4F, 0.3F, 0.2F}, 0.004, 4};
  aside.translation_m = {-0.02, -0.02, 0.006};
  add(scene, ellipsoid({0.006, 0.006, 0.006}, 8), soil, aside);
  ClearSky sky;
  sky.to_sun = Eigen::Vector3d(0.5, 0.3, 0.8).normalized();
  sky.scale = 0.02;
  scene.lights.emplace_back(sky);
  Projector projector;
  projector.world_from_projector = inverse(look_at({0.05, 0.05, 0.2}, {0, 0, 0}));
  projector.lens = small_camera(16, 16, 20);
  projector.intensity = Image<Rgbf>(16, 16, {0.01F, 0.01F, 0.01F});
  scene.lights.emplace_back(projector);
  return scene;
}

TEST(PathTracer, MeetsClosedForms) {
  // 32 scenes at 99 %: one failure is chance, and the seed is fixed.
  for (const ClosedForm& form : closed_forms(1 << 16, 3)) {
    EXPECT_TRUE(form.agrees) << form.name << ": " << form.estimate << " +- " << form.standard_error
                             << ", not " << form.truth;
  }
}

TEST(PathTracer, ClosedFormsWouldTellOnePercent) {
  for (const ClosedForm& form : closed_forms(1 << 16, 3))
    EXPECT_LT(form.standard_error, 0.0045 * form.truth) << form.name;
}

TEST(PathTracer, SameBytesOnAnyNumberOfThreads) {
  const Scene scene = mixed_scene();
  const RayScene rays(scene);
  const PathTracer tracer(rays, scene);
  const TrueView view = view_from(small_camera(61, 37, 80), {0, -0.1, 0.08}, {0, 0, 0});
  for (const bool adaptive : {false, true}) {
    const PathConfig config{.pixel_samples = 24, .adaptive = adaptive, .min_samples = 8};
    PathImage first;
    for (const std::size_t threads : {1U, 2U, 7U}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      const PathImage image = tracer.render(view, config, Rng(5));
      if (threads == 1) {
        first = image;
        EXPECT_GT(mean_green(image.radiance), 0);
        continue;
      }
      EXPECT_EQ(std::memcmp(image.radiance.data(), first.radiance.data(),
                            image.radiance.size() * sizeof(Rgbf)),
                0);
      EXPECT_EQ(image.samples, first.samples);
    }
  }
}

TEST(PathTracer, MoreSamplesGoOnWhereFewerStopped) {
  // The first 16 samples of 32 are those of 16: the mean of 16 and of the next 16 is that of 32.
  const Scene scene = mixed_scene();
  const RayScene rays(scene);
  const PathTracer tracer(rays, scene);
  const TrueView view = view_from(small_camera(16, 16, 20), {0, -0.1, 0.08}, {0, 0, 0});
  const auto at = [&](int samples) {
    return tracer.render(view, {.pixel_samples = samples}, Rng(5)).radiance;
  };
  const Image<Rgbf> a = at(16), b = at(17);
  for (std::size_t i = 0; i < a.size(); ++i) {
    const float last = 17 * b.data()[i].g - 16 * a.data()[i].g;
    EXPECT_GE(last, -1e-4F * (1 + a.data()[i].g));  // one sample's radiance, not a new set of them
  }
}

TEST(PathTracer, ErrorItStatesIsTheSpreadOverSeeds) {
  const Scene scene = leafy_scene();
  const RayScene rays(scene);
  const PathTracer tracer(rays, scene);
  TrueView view = leafy_view();
  view.camera = resized(view.camera, 40, 30);
  constexpr int kSeeds = 24;
  std::vector<PathImage> images;
  for (std::uint64_t s = 0; s < kSeeds; ++s)
    images.push_back(tracer.render(view, {.pixel_samples = 32}, Rng(s)));
  double stated = 0, seen = 0;
  for (std::size_t i = 0; i < images[0].radiance.size(); ++i) {
    double sum = 0, sum2 = 0;
    for (const PathImage& image : images) {
      const Rgbf& c = image.radiance.data()[i];
      const double y = 0.2126 * static_cast<double>(c.r) + 0.7152 * static_cast<double>(c.g) +
                       0.0722 * static_cast<double>(c.b);
      sum += y;
      sum2 += y * y;
      const auto error = static_cast<double>(image.luminance_error.data()[i]);
      stated += error * error / kSeeds;
    }
    seen += (sum2 - sum * sum / kSeeds) / (kSeeds - 1);
  }
  // Blocks of four are taken as independent though the sequence makes them complete each other, so
  // the stated variance is the larger one, but by less than two.
  EXPECT_GE(stated, 0.95 * seen);
  EXPECT_LE(stated, 2 * seen);
}

TEST(PathTracer, AdaptiveSamplesLowerTheErrorAndKeepTheMean) {
  const Scene scene = leafy_scene();
  const RayScene rays(scene);
  const PathTracer tracer(rays, scene);
  TrueView view = leafy_view();
  view.camera = resized(view.camera, 80, 60);
  const auto error_of = [&](bool adaptive, double* mean) {
    Image<Rgbf> image[2];
    for (std::uint64_t i = 0; i < 2; ++i) {
      const PathConfig config{.pixel_samples = 64, .adaptive = adaptive, .min_samples = 16};
      image[i] = tracer.render(view, config, Rng(10 + i)).radiance;
    }
    *mean = 0.5 * (mean_green(image[0]) + mean_green(image[1]));
    double sum = 0;
    for (std::size_t i = 0; i < image[0].size(); ++i) {
      const double a = static_cast<double>(image[0].data()[i].g),
                   b = static_cast<double>(image[1].data()[i].g);
      const double scale = 0.5 * (a + b) + 0.1 * *mean;
      sum += (a - b) * (a - b) / (scale * scale);
    }
    return std::sqrt(sum);
  };
  double plain_mean = 0, adaptive_mean = 0;
  const double plain = error_of(false, &plain_mean), adaptive = error_of(true, &adaptive_mean);
  EXPECT_LT(adaptive, plain);
  // 9,600 pixels of 6 % each: 0.06 % of the mean; allow five.
  EXPECT_NEAR(adaptive_mean / plain_mean, 1, 0.003);
}

TEST(PathTracer, StopsWhenTheErrorAskedForIsReached) {
  const Scene scene = mixed_scene();
  const RayScene rays(scene);
  const PathTracer tracer(rays, scene);
  const TrueView view = view_from(small_camera(32, 24, 40), {0, -0.1, 0.08}, {0, 0, 0});
  const auto spent = [&](double target) {
    const PathConfig config{
        .pixel_samples = 512, .adaptive = true, .min_samples = 8, .target_error = target};
    double sum = 0;
    for (const std::uint32_t n : tracer.render(view, config, Rng(1)).samples) sum += n;
    return sum / (32 * 24);
  };
  EXPECT_LE(spent(1), 8.5);
  EXPECT_LT(spent(0.2), 512);
  EXPECT_GT(spent(1e-6), 400);
}

TEST(PathTracer, LensOutOfFocusSpreadsAPointOverItsDisk) {
  // A bright square of 1 mm at 1 m seen by a lens of 10 mm focused at 0.5 m: its disk is
  // 2 * 10 mm * (1 - 0.5) / 0.5 across in the sharp plane's scale, f * 20 mm / 1 m = 20 px.
  Scene scene;
  scene.lights.emplace_back(Lamp{{0, 0, 1}, {0.0005, 0, 0}, {0, -0.0005, 0}, {1e4F, 1e4F, 1e4F}});
  add(scene, square(1e-6), matt(0), {});
  TrueView view;
  view.camera = small_camera(41, 41, 1000);
  view.aperture_radius_m = 0.01;
  view.focus_m = 0.5;
  const RayScene rays(scene);
  const PathTracer tracer(rays, scene);
  const Image<Rgbf> image = tracer.render(view, {.pixel_samples = 4096}, Rng(2)).radiance;
  double sum = 0, second = 0;
  for (int y = 0; y < 41; ++y) {
    for (int x = 0; x < 41; ++x) {
      const double w = static_cast<double>(image(x, y).g);
      sum += w;
      second += w * ((x - 20) * (x - 20) + (y - 20) * (y - 20));
    }
  }
  ASSERT_GT(sum, 0);
  // Mean squared radius of an even disk of radius r is r^2 / 2. r = f a |1/z - 1/focus| = 10 px.
  // Some thousand rays meet the lamp: 1 % of the radius.
  EXPECT_NEAR(std::sqrt(2 * second / sum), 10, 0.3);
}

TEST(PathTracer, MovingObjectIsBlurredByItsWayDuringTheExposure) {
  // A white square 20 px wide moves 10 px during the exposure before a dark sky: a column is as
  // bright as the share of the time it is covered.
  Scene scene;
  add(scene, square(0.01), matt(0.5F));
  Instance& instance = scene.instances[0];
  instance.motion = {{0, {}}, {1, {}}};
  instance.motion[0].world_from_object.translation_m = {-0.005, 0, 0};
  instance.motion[1].world_from_object.translation_m = {0.005, 0, 0};
  scene.lights.emplace_back(Lamp{{0, 0, 5}, {50, 0, 0}, {0, -50, 0}, {1, 1, 1}});
  TrueView view = view_from(small_camera(64, 16, 1000), {0, 0, 1}, {0, 0, 0}, {0, 1, 0});
  view.time_s = 0.5;
  view.exposure_s = 1;
  const RayScene rays(scene, TimeSpan{0, 1});
  const PathTracer tracer(rays, scene);
  const Image<Rgbf> image = tracer.render(view, {.pixel_samples = 256}, Rng(2)).radiance;
  const double full = static_cast<double>(image(31, 8).g);
  for (int x = 0; x < 64; ++x) {
    // Centre of the pixel from the middle of the path, in pixels; the square's half width is 10.
    const double at = std::abs(x - 31.5);
    const double expected = std::clamp((15 - at) / 10, 0.0, 1.0);
    EXPECT_NEAR(static_cast<double>(image(x, 8).g) / full, expected, 0.03) << "column " << x;
  }
}

TEST(PathTracer, MovingCameraIsBlurredAsItsPosesSay) {
  Scene scene;
  add(scene, square(0.01), matt(0.5F));
  scene.lights.emplace_back(Lamp{{0, 0, 5}, {50, 0, 0}, {0, -50, 0}, {1, 1, 1}});
  TrueView view = view_from(small_camera(64, 16, 1000), {-0.005, 0, 1}, {-0.005, 0, 0}, {0, 1, 0});
  view.camera_from_world_end = look_at({0.005, 0, 1}, {0.005, 0, 0}, {0, 1, 0});
  view.exposure_s = 1;
  const RayScene rays(scene);
  const Image<Rgbf> image =
      PathTracer(rays, scene).render(view, {.pixel_samples = 256}, Rng(2)).radiance;
  const double full = static_cast<double>(image(31, 8).g);
  for (int x = 0; x < 64; ++x) {
    const double expected = std::clamp((15 - std::abs(x - 31.5)) / 10, 0.0, 1.0);
    // Eight instants: steps of an eighth.
    EXPECT_NEAR(static_cast<double>(image(x, 8).g) / full, expected, 0.08) << "column " << x;
  }
}

TEST(PathTracer, ABodyDarkInsideEndsPathsAndLeafDoesNot) {
  Scene scene;
  add(scene, inside_out(ellipsoid({1, 1, 1}, 10)), matt(0.5F));
  scene.lights.emplace_back(even_sky(1));
  const RayScene rays(scene);
  const TrueView view = view_from(small_camera(16, 16, 40), {0, -3, 0}, {0, 0, 0});
  EXPECT_EQ(mean_green(PathTracer(rays, scene).render(view, {}, Rng(1)).radiance), 0);
  scene.materials[0].kind = SurfaceKind::leaf;
  EXPECT_GT(mean_green(PathTracer(rays, scene).render(view, {}, Rng(1)).radiance), 0.1);
}

TEST(PathTracer, APartHasItsOwnMaterial) {
  Scene scene;
  add(scene, square(1), matt(0.2F));
  scene.materials.push_back(matt(0.8F));
  scene.models[0].part_names = {"left", "right"};
  scene.models[0].triangle_part = {0, 1};
  scene.instances[0].part_materials = {0, 1};
  scene.lights.emplace_back(even_sky(1));
  const RayScene rays(scene);
  const TrueView view = view_from(small_camera(16, 16, 40), {0, 0, 3}, {0, 0, 0}, {0, 1, 0});
  const Image<Rgbf> image = PathTracer(rays, scene).render(view, {}, Rng(1)).radiance;
  // Under an even sky a flat matt surface shines with its albedo; draws by the cosine have one
  // weight, so only rounding is left. Half of the pixels show each triangle, but for the diagonal.
  int dark = 0, bright = 0;
  for (const Rgbf& c : image) {
    dark += std::abs(c.g - 0.2F) < 1e-3F;
    bright += std::abs(c.g - 0.8F) < 1e-3F;
  }
  EXPECT_EQ(dark + bright, 16 * 16 - 16);
  EXPECT_EQ(dark, bright);
}

TEST(PathTracer, CameraInALeafAndLightlessScenesGiveNumbers) {
  Scene scene;
  Material leaf = matt(0.4F);
  leaf.kind = SurfaceKind::leaf;
  leaf.transmittance = {0.5F, 0.5F, 0.5F};
  add(scene, square(1), leaf);
  const RayScene rays(scene);
  // In the leaf's own plane, looking through and along it.
  for (const Eigen::Vector3d& target : {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0, 1, 0)}) {
    TrueView view = view_from(small_camera(16, 16, 10), {0, 0, 0}, target,
                              target.z() > 0 ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ());
    const Image<Rgbf> dark = PathTracer(rays, scene).render(view, {}, Rng(1)).radiance;
    EXPECT_EQ(mean_green(dark), 0);
    Scene lit = scene;
    lit.lights.emplace_back(even_sky(1));
    for (const Rgbf& c : PathTracer(rays, lit).render(view, {}, Rng(1)).radiance) {
      EXPECT_TRUE(std::isfinite(c.g));
      EXPECT_LE(c.g, 1.001F);
    }
  }
}

TEST(PathTracer, RefusesWhatItCannotDoByName) {
  const auto message = [](const Material& material, const std::vector<Light>& lights,
                          const PathConfig& config) -> std::string {
    Scene scene;
    add(scene, square(1), material);
    scene.lights = lights;
    try {
      const RayScene rays(scene);
      PathTracer(rays, scene)
          .render(view_from(small_camera(4, 4, 4), {0, 0, 1}, {0, 0, 0}, {0, 1, 0}), config,
                  Rng(1));
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  using testing::HasSubstr;
  Material leaf = matt(0.7F);
  leaf.name = "blade";
  leaf.kind = SurfaceKind::leaf;
  leaf.transmittance = {0.5F, 0, 0};
  EXPECT_THAT(message(leaf, {}, {}), HasSubstr("\"blade\": albedo + transmittance = 1.2"));
  Material rough = matt(0.5F);
  rough.roughness = 0;
  EXPECT_THAT(message(rough, {}, {}), HasSubstr("roughness"));
  Material noisy = matt(0.5F);
  noisy.noise = NoiseTexture{{0, 0, 0}, 0, 4};
  EXPECT_THAT(message(noisy, {}, {}), HasSubstr("noise.scale_m"));
  Material bright = matt(1.5F);
  EXPECT_THAT(message(bright, {}, {}), HasSubstr("albedo"));
  EXPECT_THAT(message(matt(0.5F), {Lamp{{0, 0, 1}, {0, 0, 0}, {0, 1, 0}, {1, 1, 1}}}, {}),
              HasSubstr("lamp"));
  EXPECT_THAT(message(matt(0.5F), {Environment{}}, {}), HasSubstr("environment"));
  ClearSky night;
  night.to_sun = {0, 1, -0.1};
  EXPECT_THAT(message(matt(0.5F), {night}, {}), HasSubstr("below the horizon"));
  EXPECT_THAT(message(matt(0.5F), {}, {.pixel_samples = 0}), HasSubstr("pixel_samples"));
  EXPECT_THAT(message(matt(0.5F), {}, {.max_bounces = -1}), HasSubstr("max_bounces"));
  EXPECT_EQ(message(matt(0.5F), {even_sky(1)}, {}), "");
}

TEST(PathTracer, DistantAndTinyScenesLookTheSame) {
  // The same picture from a scene moved by 1e4 m, and from one a thousand times as large.
  const auto picture = [](double scale, const Eigen::Vector3d& offset_m) {
    Scene scene;
    Pose pose;
    pose.translation_m = offset_m;
    add(scene, ellipsoid(Eigen::Vector3d(0.03, 0.02, 0.025) * scale, 12), matt(0.5F), pose);
    Pose floor = pose;
    floor.translation_m.z() -= 0.03 * scale;
    add(scene, square(0.3 * scale), matt(0.3F), floor);
    scene.lights.emplace_back(even_sky(1));
    const RayScene rays(scene);
    const TrueView view = view_from(small_camera(24, 24, 60),
                                    offset_m + scale * Eigen::Vector3d(0.1, -0.1, 0.1), offset_m);
    return PathTracer(rays, scene).render(view, {.pixel_samples = 64}, Rng(1)).radiance;
  };
  const double usual = mean_green(picture(1, {0, 0, 0}));
  EXPECT_NEAR(mean_green(picture(1, {1e4, -1e4, 100})), usual, 0.01 * usual);
  EXPECT_NEAR(mean_green(picture(1e3, {0, 0, 0})), usual, 0.01 * usual);
  EXPECT_NEAR(mean_green(picture(1e-3, {0, 0, 0})), usual, 0.01 * usual);
}

}  // namespace
}  // namespace cousin::test
