#include "sim/dataset/environment_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/truth_io.h"
#include "sim/imaging/exr_color.h"
#include "sim/render/path_tracer.h"
#include "sim/render/radiance_pass.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

constexpr double kPi = std::numbers::pi;

/// A square of 2 m in z = 0 with a coat or without, seen from straight above.
Scene floor_under(const Environment& environment, float albedo) {
  Scene scene;
  scene.name = "floor";
  ObjectModel model;
  model.name = "square";
  model.mesh.vertices_m = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  model.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  scene.models = {model};
  Material material;
  material.name = "matt";
  material.albedo = {albedo, albedo, albedo};
  material.ior = 1;
  scene.materials = {material};
  Instance instance;
  instance.id = 1;
  instance.name = "floor";
  scene.instances = {instance};
  scene.lights = {environment};
  return scene;
}

TrueView from_above() {
  TrueView view;
  view.camera.width_px = view.camera.height_px = 16;
  view.camera.fx_px = view.camera.fy_px = 2000;
  view.camera.cx_px = view.camera.cy_px = 7.5;
  view.camera_from_world = view.camera_from_world_end =
      look_at({0, 0, 1}, {0, 0, 0}, Eigen::Vector3d::UnitY());
  return view;
}

double mean_green(const Image<Rgbf>& image) {
  double sum = 0;
  for (const Rgbf& c : image) sum += static_cast<double>(c.g);
  return sum / static_cast<double>(image.size());
}

double path_traced(const Scene& scene, int samples) {
  const RayScene rays(scene);
  return mean_green(PathTracer(rays, scene)
                        .render(from_above(), {.pixel_samples = samples, .max_bounces = 0}, Rng(1))
                        .radiance);
}

double cached(const Scene& scene) {
  const RayScene rays(scene);
  RadianceConfig config;
  config.max_bounces = 0;
  config.irradiance_samples = 1024;
  const IrradianceCache cache(rays, scene, config, Rng(2));
  return mean_green(render_radiance(rays, scene, cache, from_above(), config, Rng(3)));
}

/// A dim gradient with a bright spot of 3 x 2 texels at 50 degrees' elevation.
Image<Rgbf> spotted_sky() {
  Image<Rgbf> picture(96, 48);
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 96; ++x) {
      const float v = 0.05F + 0.001F * static_cast<float>(x + y);
      picture(x, y) = {v, v, v};
    }
  }
  for (int y = 10; y < 12; ++y) {
    for (int x = 30; x < 33; ++x) picture(x, y) = {400, 400, 400};
  }
  return picture;
}

/// Irradiance of a floor by brute force: the picture, bilinear between texel centres, at 24 x 24
/// points a texel of the upper half.
double irradiance_of(const Image<Rgbf>& picture) {
  constexpr int kFine = 24;
  const int w = picture.width(), h = picture.height();
  double sum = 0;
  for (int j = 0; j < h / 2 * kFine; ++j) {
    const double y = (j + 0.5) / kFine - 0.5, polar = kPi * (y + 0.5) / h;
    const int y0 = static_cast<int>(std::floor(y));
    const double v = y - y0;
    const int a = std::clamp(y0, 0, h - 1), b = std::clamp(y0 + 1, 0, h - 1);
    for (int i = 0; i < w * kFine; ++i) {
      const double x = (i + 0.5) / kFine - 0.5;
      const int x0 = static_cast<int>(std::floor(x));
      const double u = x - x0;
      const int c = (x0 + w) % w, d = (x0 + 1) % w;
      const auto at = [&](int px, int py) { return static_cast<double>(picture(px, py).g); };
      const double radiance =
          (1 - v) * ((1 - u) * at(c, a) + u * at(d, a)) + v * ((1 - u) * at(c, b) + u * at(d, b));
      sum += radiance * std::cos(polar) * std::sin(polar);
    }
  }
  return sum * (kPi / h / kFine) * (2 * kPi / w / kFine);
}

TEST(EnvironmentIo, AConstantFileIsAFurnace) {
  const TemporaryFolder folder;
  write_exr_color(folder.path() / "even.exr", Image<Rgbf>(32, 16, {4, 4, 4}));
  const Environment environment = read_environment(folder.path() / "even.exr", 0.25);
  const Scene scene = floor_under(environment, 1);
  // White under an even light cannot be seen. The path tracer draws 16,384 samples; the cache 1,024
  // by each way at the few points that the view lies between.
  EXPECT_NEAR(path_traced(scene, 64), 1, 2e-3);
  EXPECT_NEAR(cached(scene), 1, 2e-3);
}

TEST(EnvironmentIo, SamplingByImportanceAgreesWithBruteForce) {
  const TemporaryFolder folder;
  write_exr_color(folder.path() / "spot.exr", spotted_sky());
  const Scene scene = floor_under(read_environment(folder.path() / "spot.exr"), 0.5F);
  const double expected = 0.5 / kPi * irradiance_of(spotted_sky());
  // The spot gives most of the light; drawn by the surface's cosine alone, one ray in 2,000 meets
  // it and 64 samples of 256 pixels would err by 35 % / 16 * sqrt(30). Drawn by its brightness the
  // error of the path tracer is below 0.2 %, the cache's, of fewer points, 0.8 %.
  EXPECT_NEAR(path_traced(scene, 64), expected, 0.01 * expected);
  EXPECT_NEAR(cached(scene), expected, 0.04 * expected);
}

TEST(EnvironmentIo, APictureComesBackBitByBitWithTheTruth) {
  const TemporaryFolder folder;
  SceneTruth truth;
  truth.scene = floor_under(Environment{spotted_sky()}, 0.5F);
  truth.scene.lights.insert(truth.scene.lights.begin(), Sky{});
  write_truth(folder.path(), truth);
  EXPECT_TRUE(fs::exists(folder.path() / "truth" / "environments" / "000001.exr"));
  const SceneTruth read = read_truth(folder.path());
  ASSERT_EQ(read.scene.lights.size(), 2U);
  const auto* environment = std::get_if<Environment>(&read.scene.lights[1]);
  ASSERT_NE(environment, nullptr);
  EXPECT_EQ(environment->radiance, spotted_sky());
}

/// What read_truth says when scene.json's environment is `light`; empty if it reads.
std::string said(const TemporaryFolder& folder, const std::string& light) {
  SceneTruth truth;
  truth.scene = floor_under(Environment{Image<Rgbf>(4, 2, {1, 1, 1})}, 0.5F);
  write_truth(folder.path(), truth);
  const fs::path file = folder.path() / "truth" / "scene.json";
  std::string text = read_file(file);
  const std::size_t lights = text.find("\"lights\"");
  const std::size_t begin = text.find('{', lights), end = text.find('}', begin) + 1;
  write_file(file, text.replace(begin, end - begin, light));
  try {
    read_truth(folder.path());
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return {};
}

TEST(EnvironmentIo, ASceneNamesAFileAndItsScale) {
  const TemporaryFolder folder;
  EXPECT_EQ(said(folder, R"({"kind": "environment", "file": "environments/000000.exr",
                             "scale": 0.5})"),
            "");
  const Light light = read_truth(folder.path()).scene.lights.at(0);
  EXPECT_EQ(std::get<Environment>(light).radiance(0, 0).g, 0.5F);
}

TEST(EnvironmentIo, BadFilesAreNamedAndNothingLeavesTheDataset) {
  const TemporaryFolder folder;
  EXPECT_THAT(said(folder, R"({"kind": "environment", "file": "../../../etc/passwd"})"),
              HasSubstr("passwd"));
  EXPECT_THAT(said(folder, R"({"kind": "environment", "file": "missing.exr"})"),
              HasSubstr("missing.exr"));
  EXPECT_THAT(said(folder, R"({"kind": "environment", "file": "seed"})"), HasSubstr("seed: EXR"));
  EXPECT_THAT(said(folder, R"({"kind": "environment", "file": "x.exr", "scale": -1})"),
              AllOf(HasSubstr("scene.json"), HasSubstr("scale")));
  EXPECT_THAT(said(folder, R"({"kind": "environment", "file": "x.exr", "gain": 1})"),
              HasSubstr("gain"));
  const auto refused = [&](const Image<Rgbf>& picture, double scale) -> std::string {
    write_exr_color(folder.path() / "sky.exr", picture);
    try {
      read_environment(folder.path() / "sky.exr", scale);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return {};
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(refused(Image<Rgbf>(4, 2, {1, nan, 1}), 1),
              AllOf(HasSubstr("sky.exr"), HasSubstr("radiance = nan")));
  EXPECT_THAT(refused(Image<Rgbf>(4, 2, {1, -2, 1}), 1), HasSubstr("radiance = -2"));
  EXPECT_THAT(refused(Image<Rgbf>(4, 2, {1e15F, 1, 1}), 1e10), HasSubstr("is not in [0, 1e20]"));
  EXPECT_EQ(refused(Image<Rgbf>(4, 2, {1, 1, 1}), 2), "");
}

}  // namespace
}  // namespace cousin
