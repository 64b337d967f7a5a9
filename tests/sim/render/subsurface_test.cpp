#include "sim/render/subsurface.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "benchmarks/suites/light/closed_form_case.h"
#include "sim/render/path_tracer.h"
#include "sim/render/ray_scene.h"

namespace cousin {
namespace {

using namespace closed_form;

constexpr double kPi = std::numbers::pi;

Material flesh(float albedo, float mean_free_path_m) {
  Material m = grey(albedo);
  m.mean_free_path_m = {mean_free_path_m, mean_free_path_m, mean_free_path_m};
  return m;
}

double mean_green(const Image<Rgbf>& image) {
  double sum = 0;
  for (const Rgbf& c : image) sum += static_cast<double>(c.g);
  return sum / static_cast<double>(image.size());
}

Image<Rgbf> picture(const Scene& scene, const TrueView& view, int samples) {
  const RayScene rays(scene);
  return PathTracer(rays, scene)
      .render(view, {.pixel_samples = samples, .max_bounces = 64}, Rng(1))
      .radiance;
}

/// A deep body with its top at z = 0, in a sun of irradiance pi that stands above; a black sheet
/// close above it shades x > 0.
Scene half_shaded(const Material& material) {
  constexpr auto kPiF = static_cast<float>(kPi);
  Scene scene = scene_of(box({0.5, 0.5, 0.5}), material,
                         {Sun{Eigen::Vector3d::UnitZ(), 1e-3, {kPiF, kPiF, kPiF}}});
  scene.instances[0].world_from_object.translation_m = {0, 0, -0.5};
  Instance sheet;
  sheet.id = 2;
  sheet.name = "sheet";
  sheet.model = sheet.material = 1;
  sheet.world_from_object.translation_m = {0.6, 0, 1e-4};
  scene.models.push_back(square(0.6));
  scene.materials.push_back(grey(0));
  scene.instances.push_back(sheet);
  return scene;
}

/// Radiance of the lit side `away_m` from the shadow's edge, over a spot of 0.1 mm.
double beside_shadow(const Scene& scene, double away_m) {
  return mean_green(
      picture(scene, view_from({-away_m, 0, 0.1}, {-away_m, 0, 0}, 32 * 0.1 / 1e-4), 64));
}

/// Share of light that comes out less than `x` to one side of where it went in, by the normalised
/// diffusion profile for light that goes in diffusely: exp(-r / d) / 8 pi d r + exp(-r / 3 d) /
/// 8 pi d r with d = path / (1.9 - A + 3.5 (A - 0.8)^2) [Christensen & Burley 2015, eq. 3 and 6].
double diffused_within(double x, double albedo, double path_m) {
  const double d = path_m / (1.9 - albedo + 3.5 * std::pow(albedo - 0.8, 2));
  double beyond = 0;
  constexpr int kCells = 20000;
  const double most = x + 60 * d;
  for (int i = 0; i < kCells; ++i) {
    const double r = x + (most - x) * (i + 0.5) / kCells;
    const double ring = (std::exp(-r / d) + std::exp(-r / (3 * d))) / (4 * d);
    beyond += ring * std::acos(x / r) / kPi * (most - x) / kCells;
  }
  return 1 - beyond;
}

TEST(Subsurface, AlbedoOfADeepBodyIsInverted) {
  EXPECT_EQ(kept_at_turn(0), 0);
  EXPECT_EQ(kept_at_turn(1), 1);
  // 1 - 2 s * integral of H(mu) mu at s = sqrt(1 - kept), H iterated with 64 points of Gauss and
  // Legendre in another program.
  struct Known {
    float root, albedo;
  };
  for (const Known& k : {Known{0.9F, 0.0436597F}, Known{0.5F, 0.2952794F}, Known{0.2F, 0.6305810F},
                         Known{0.1F, 0.7945637F}, Known{0.03F, 0.9331910F}}) {
    EXPECT_NEAR(std::sqrt(1 - kept_at_turn(k.albedo)), k.root, 1e-4F);
  }
  float last = 0;
  for (int i = 1; i <= 1000; ++i) {
    const float kept = kept_at_turn(static_cast<float>(i) / 1000);
    EXPECT_GT(kept, last);
    last = kept;
  }
}

TEST(Subsurface, ShadowsEdgeIsAsSoftAsDiffusionSays) {
  constexpr double kPath_m = 0.004;
  for (const double albedo : {0.5, 0.8}) {
    const Scene scene = half_shaded(flesh(static_cast<float>(albedo), static_cast<float>(kPath_m)));
    double last = 0;
    for (const double paths : {0.25, 0.5, 1.0, 2.0, 8.0}) {
      const double share = beside_shadow(scene, paths * kPath_m) / albedo;
      // The profile is itself a fit, to within about 5 % of the walk's profile; 2^16 samples add
      // 0.3 %.
      EXPECT_NEAR(share, diffused_within(paths * kPath_m, albedo, kPath_m), 0.03)
          << albedo << ", " << paths << " paths away";
      EXPECT_GT(share, last);
      last = share;
    }
  }
}

TEST(Subsurface, ShortFreePathsLookDiffuse) {
  const Scene diffuse = half_shaded(flesh(0.6F, 0));
  const TrueView view = view_from({-0.01, 0, 0.1}, {-0.01, 0, 0}, 32);
  // Below 32 ray offsets: the very same paths.
  EXPECT_EQ(picture(diffuse, view, 8), picture(half_shaded(flesh(0.6F, 1e-9F)), view, 8));
  // 2 mm beside the edge: the difference falls with the free path, to noise.
  const double sharp = beside_shadow(diffuse, 0.002);
  EXPECT_NEAR(sharp, 0.6, 1e-3);
  const auto off = [&](float path_m) {
    return std::abs(beside_shadow(half_shaded(flesh(0.6F, path_m)), 0.002) - sharp);
  };
  EXPECT_GT(off(4e-3F), 0.05);
  EXPECT_LT(off(4e-4F), 0.01);
  EXPECT_LT(off(1e-4F), 0.004);  // of 2^16 walks of variance 0.6 * 0.4: sigma is 0.002
}

TEST(Subsurface, ColoursSpreadByTheirOwnFreePaths) {
  Material m = flesh(0.6F, 0.004F);
  m.mean_free_path_m = {0.008F, 0.004F, 0.001F};
  const Scene scene = half_shaded(m);
  const TrueView view = view_from({-0.002, 0, 0.1}, {-0.002, 0, 0}, 32 * 0.1 / 1e-4);
  std::array<double, 3> sum{};
  for (const Rgbf& c : picture(scene, view, 64)) {
    sum[0] += static_cast<double>(c.r);
    sum[1] += static_cast<double>(c.g);
    sum[2] += static_cast<double>(c.b);
  }
  const double path_m[] = {0.008, 0.004, 0.001};
  for (std::size_t k = 0; k < 3; ++k) {
    const double share = sum[k] / (kSide * kSide) / 0.6;
    EXPECT_NEAR(share, diffused_within(0.002, 0.6, path_m[k]), 0.03) << k;  // as above
  }
}

TEST(Subsurface, NeedsAClosedBody) {
  Scene scene = scene_of(square(1), flesh(0.5F, 0.001F), {even_sky(1)});
  const RayScene rays(scene);
  try {
    const PathTracer tracer(rays, scene);
    FAIL() << "accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("\"body\""), std::string::npos) << error.what();
  }
  scene.materials[0].kind = SurfaceKind::leaf;
  scene.materials[0].albedo = {0.4F, 0.4F, 0.4F};
  EXPECT_THROW(RayScene{scene}, std::invalid_argument);
  scene.materials[0] = flesh(0.5F, -1);
  EXPECT_THROW(RayScene{scene}, std::invalid_argument);
}

}  // namespace
}  // namespace cousin
