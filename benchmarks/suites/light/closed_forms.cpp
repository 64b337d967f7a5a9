#include "benchmarks/suites/light/closed_forms.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "benchmarks/suites/light/closed_form_case.h"
#include "sim/render/path_tracer.h"
#include "sim/types/pi.h"

namespace cousin {
namespace {

using namespace closed_form;

// ---- measuring ----------------------------------------------------------------------------------

ClosedForm measure(const Case& c, std::int64_t samples, std::uint64_t seed) {
  const RayScene rays(c.scene);
  const PathTracer tracer(rays, c.scene);
  PathConfig config;
  config.pixel_samples = static_cast<int>(samples / (kSide * kSide));
  config.max_bounces = c.max_bounces;
  const PathImage image = tracer.render(c.view, config, Rng(seed).fork(c.name));
  ClosedForm form;
  form.name = c.name;
  form.truth = c.truth;
  form.samples = static_cast<std::int64_t>(config.pixel_samples) * kSide * kSide;
  double variance = 0;
  for (std::size_t i = 0; i < image.radiance.size(); ++i) {
    form.estimate += static_cast<double>(image.radiance.data()[i].g);
    const auto error = static_cast<double>(image.luminance_error.data()[i]);
    variance += error * error;
  }
  const auto pixels = static_cast<double>(image.radiance.size());
  form.estimate /= pixels;
  form.standard_error = std::sqrt(variance) / pixels;
  form.agrees = std::abs(form.estimate - form.truth) <=
                2.576 * form.standard_error + 2e-5 * std::abs(form.truth);
  return form;
}

// ---- cases --------------------------------------------------------------------------------------

void add_furnaces(std::vector<Case>& cases) {
  // The sphere fills the image up to 5 degrees from its outline.
  const TrueView view = view_from({0, -3, 0.4}, {0, 0, 0}, 64);
  const auto add = [&](const std::string& name, const Material& material) {
    const bool is_glass = material.kind == SurfaceKind::glass;
    cases.push_back({"furnace, " + name, scene_of(sphere(48, false), material, {even_sky(1)}), view,
                     1, is_glass ? 1024 : 8});
  };
  add("diffuse", grey(1));
  for (const double roughness : {0.1, 0.5, 1.0}) {
    const std::string text = ", roughness " + std::to_string(roughness).substr(0, 3);
    add("coat" + text, grey(1, SurfaceKind::coated, 1.5, roughness));
    add("metal" + text, grey(1, SurfaceKind::conductor, 1, roughness));
    add("glass" + text, grey(1, SurfaceKind::glass, 1.5, roughness));
    Material leaf = grey(0.6F, SurfaceKind::leaf, 1.4, roughness);
    leaf.transmittance = {0.4F, 0.4F, 0.4F};
    cases.push_back({"furnace, leaf" + text, scene_of(square(50), leaf, {even_sky(1)}),
                     view_from({0, 0, 1}, {0, 0.6, 0}, 40), 1, 0});
  }
}

/// Mean over the image of albedo * cosine, the sphere and the pinhole taken exactly; the middle of
/// 64 x 64 cells a pixel.
double lambert_sphere_mean(const TrueView& view, const Eigen::Vector3d& to_sun, double albedo) {
  const Eigen::Vector3d eye_m = centre_in_world_m(view.camera_from_world);
  const Eigen::Matrix3d world_from_camera =
      view.camera_from_world.rotation.conjugate().toRotationMatrix();
  constexpr int kCells = 64 * kSide;
  double sum = 0;
  for (int y = 0; y < kCells; ++y) {
    for (int x = 0; x < kCells; ++x) {
      const double px = (x + 0.5) / 64 - 0.5, py = (y + 0.5) / 64 - 0.5;
      const Eigen::Vector3d d =
          world_from_camera * Eigen::Vector3d((px - view.camera.cx_px) / view.camera.fx_px,
                                              (py - view.camera.cy_px) / view.camera.fy_px, 1)
                                  .normalized();
      const double b = eye_m.dot(d), disc = b * b - eye_m.squaredNorm() + 1;
      if (disc < 0) continue;
      const Eigen::Vector3d n = eye_m + (-b - std::sqrt(disc)) * d;
      sum += albedo * std::max(0.0, n.dot(to_sun));
    }
  }
  return sum / kCells / kCells;
}

Case lambert_sphere() {
  const Eigen::Vector3d to_sun = Eigen::Vector3d(1, -1, 0.7).normalized();
  const TrueView view = view_from({0, -4, 0}, {0, 0, 0}, 56);
  constexpr auto kPiF = static_cast<float>(kPi);
  // A sun of 1e-3 rad: its own width changes the mean by less than 1e-6.
  return {"Lambert sphere in the sun",
          scene_of(sphere(250, true), grey(0.5F), {Sun{to_sun, 1e-3, {kPiF, kPiF, kPiF}}}), view,
          lambert_sphere_mean(view, to_sun, 0.5), 0};
}

/// Form factor of a parallel rectangle a x b above one of its corners at height 1.
double corner_form_factor(double a, double b) {
  const double p = std::sqrt(1 + a * a), q = std::sqrt(1 + b * b);
  return (a / p * std::atan(b / p) + b / q * std::atan(a / q)) / (2 * kPi);
}

Case area_light() {
  // Lamp of 1.2 x 0.8 m, 0.5 m above the floor; seen from between through 0.2 mm of the floor.
  const Lamp lamp{{0, 0, 0.5}, {0.6, 0, 0}, {0, -0.4, 0}, {2, 2, 2}};
  const double factor = 4 * corner_form_factor(0.6 / 0.5, 0.4 / 0.5);
  return {"form factor of an area light", scene_of(square(5), grey(0.7F), {lamp}),
          view_from({0, 0, 0.25}, {0, 0, 0}, 4e4), 0.7 * 2 * factor, 0};
}

Case mirror() {
  // Radiance of the sky is the sine of the elevation. Straight down, facets seen are tilted by t
  // with density D cos t, and reflect to elevation 90 degrees - 2 t: the mean of cos 2 t over GGX
  // is 1 - 2 a^2 (ln(1 / a^2) - 1 + a^2) / (1 - a^2)^2.
  const double a2 = std::pow(0.05, 4);
  const double truth = 1 - 2 * a2 * (std::log(1 / a2) - 1 + a2) / ((1 - a2) * (1 - a2));
  return {"mirror",
          scene_of(square(5), grey(1, SurfaceKind::conductor, 1, 0.05),
                   {Sky{{1, 1, 1}, {0, 0, 0}, {0, 0, 0}}}),
          view_from({0, 0, 1}, {0, 0, 0}, 4e4), truth, 1};
}

Case leaf(bool from_above) {
  Material m = grey(0.3F, SurfaceKind::leaf);
  m.transmittance = {0.45F, 0.45F, 0.45F};
  const Rgbf one{1, 1, 1}, zero{0, 0, 0};
  return {from_above ? "thin leaf, reflected" : "thin leaf, transmitted",
          scene_of(square(500), m, {Sky{one, one, zero}}),
          view_from({0, 0, from_above ? 1.0 : -1.0}, {0, 0.3, 0}, 64),
          static_cast<double>(from_above ? 0.3F : 0.45F), 0};
}

Case beam() {
  // 3 W/sr from 2 m above: 3 / 4 W/m^2 on the floor straight below.
  Projector projector;
  projector.world_from_projector = inverse(look_at({0, 0, 2}, {0, 0, 0}, Eigen::Vector3d::UnitY()));
  projector.lens = view_from({0, 0, 2}, {0, 0, 0}, 64).camera;
  projector.intensity = Image<Rgbf>(kSide, kSide, {3, 3, 3});
  return {"beam", scene_of(square(5), grey(0.8F), {projector}),
          view_from({0, 0, 1}, {0, 0, 0}, 4e4), 0.8 / kPi * 3 / 4, 0};
}

Case integrating_sphere() {
  // A lamp in the middle shines at one half; on the other half there is only what the wall of
  // albedo a sends itself: a * flux / (area * (1 - a)), the mesh's own area. Seen past the lamp.
  constexpr double kAlbedo = 0.5, kHalf = 0.02;
  const ObjectModel wall = sphere(128, true, true);
  double area = 0;
  for (const auto& t : wall.mesh.triangles) {
    const Eigen::Vector3d a = wall.mesh.vertices_m[t[0]];
    area += 0.5 * (wall.mesh.vertices_m[t[1]] - a).cross(wall.mesh.vertices_m[t[2]] - a).norm();
  }
  const double flux = kPi * 40 * 4 * kHalf * kHalf;
  return {"integrating sphere",
          scene_of(wall, grey(static_cast<float>(kAlbedo)),
                   {Lamp{{0, 0, 0}, {kHalf, 0, 0}, {0, kHalf, 0}, {40, 40, 40}}}),
          view_from({0, 0, -0.1}, {0, 0, -1}, 64),
          kAlbedo / kPi * kAlbedo * flux / (area * (1 - kAlbedo)), 64};
}

Case environment() {
  // One bright texel in a dark sky: the floor's irradiance is its picture's, bilinear between texel
  // centres, integrated over the upper half at 16 x 16 points a texel.
  constexpr int kWidth = 64, kHeight = 32, kFine = 16, kX = 20, kY = 5;
  Environment light{Image<Rgbf>(kWidth, kHeight, {0.1F, 0.1F, 0.1F})};
  light.radiance(kX, kY) = {200, 200, 200};
  double irradiance = kPi * 0.1;
  for (int v = -kFine; v < kFine; ++v) {
    const double y = (v + 0.5) / kFine, polar = kPi * (kY + 0.5 + y) / kHeight;
    // The bump's share along the row integrates to one texel.
    const double cell = kPi / (kHeight * kFine) * (2 * kPi / kWidth);
    irradiance += (200 - static_cast<double>(0.1F)) * (1 - std::abs(y)) * std::sin(polar) *
                  std::cos(polar) * cell;
  }
  return {"environment picture", scene_of(square(5), grey(0.6F), {light}),
          view_from({0, 0, 1}, {0, 0, 0}, 4e4), 0.6 / kPi * irradiance, 0};
}

}  // namespace

std::vector<ClosedForm> closed_forms(std::int64_t samples, std::uint64_t seed) {
  std::vector<Case> cases;
  add_furnaces(cases);
  add_media(cases);
  cases.push_back(lambert_sphere());
  cases.push_back(area_light());
  cases.push_back(mirror());
  cases.push_back(leaf(true));
  cases.push_back(leaf(false));
  cases.push_back(beam());
  cases.push_back(integrating_sphere());
  cases.push_back(environment());
  std::vector<ClosedForm> forms;
  for (const Case& c : cases)
    forms.push_back(measure(c, std::max<std::int64_t>(samples, kSide * kSide), seed));
  return forms;
}

}  // namespace cousin
