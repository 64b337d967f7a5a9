#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks/suites/light/closed_form_case.h"

namespace cousin::closed_form {
namespace {

constexpr double kWater = 1.333;
constexpr int kAll = 1024;  ///< bounces

/// Share of light that smooth water mirrors to a direction `cosine` from its outside.
double mirrored(double cosine) {
  const double g = std::sqrt(kWater * kWater - 1 + cosine * cosine);
  const double a = (g - cosine) / (g + cosine);
  const double b = (cosine * (g + cosine) - 1) / (cosine * (g - cosine) + 1);
  return 0.5 * a * a * (1 + b * b);
}

/// Water 1 m deep over a floor of albedo 0.6, seen from the air at an angle.
struct Pool {
  Case c;
  double seen_down = 0;  ///< share that comes through the face on the way to the camera
  double inner = 0;      ///< mirrored down again of diffuse light from below
};
constexpr double kFloorAlbedo = 0.6;

Pool pool(const std::string& name, std::vector<Light> lights) {
  // Light that is diffuse below comes out by 1 - Fi = (1 - Fe) / n^2, where Fe is what diffuse
  // light from above loses.
  constexpr int kCells = 20000;
  double outer = 0;
  for (int i = 0; i < kCells; ++i) {
    const double cosine = (i + 0.5) / kCells;
    outer += 2 * cosine * mirrored(cosine) / kCells;
  }
  Pool p;
  p.inner = 1 - (1 - outer) / (kWater * kWater);
  const Eigen::Vector3d eye_m(0, -0.8, 1.1), on_water_m(0, 0, 0.5);
  p.seen_down = 1 - mirrored((eye_m - on_water_m).normalized().z());
  p.c.name = name;
  p.c.scene =
      scene_of(box({500, 500, 0.5}), grey(1, SurfaceKind::clear, kWater), std::move(lights));
  p.c.view = view_from(eye_m, on_water_m, 4e4);
  p.c.max_bounces = kAll;
  Instance floor;
  floor.id = 2;
  floor.name = "floor";
  floor.model = floor.material = 1;
  p.c.scene.models.push_back(square(600));
  p.c.scene.materials.push_back(grey(static_cast<float>(kFloorAlbedo)));
  p.c.scene.instances.push_back(floor);
  return p;
}

/// In an even sky what water lets in, less what it mirrors down again of each return, comes out:
/// F + (1 - F) a (1 - Fi) / (1 - a Fi) towards a direction of mirroring F.
Case floor_under_water() {
  Pool p = pool("floor under water", {even_sky(1)});
  const double up = kFloorAlbedo * (1 - p.inner) / (1 - kFloorAlbedo * p.inner);
  p.c.truth = (1 - p.seen_down) + p.seen_down * up;
  return p.c;
}

/// A sun lets (1 - F) E cos reach the floor, whose radiance is less by n^2 in the air.
Case sun_under_water() {
  const Eigen::Vector3d to_sun = Eigen::Vector3d(0.6, 0.3, 0.7).normalized();
  Pool p = pool("floor under water in the sun", {Sun{to_sun, 1e-3, {3, 3, 3}}});
  const double floor = (1 - mirrored(to_sun.z())) * 3 * to_sun.z() * kFloorAlbedo /
                       std::numbers::pi / (1 - kFloorAlbedo * p.inner);
  p.c.truth = p.seen_down * floor / (kWater * kWater);
  return p.c;
}

Material flesh(float albedo, float mean_free_path_m, double ior = 1) {
  Material m = grey(albedo, SurfaceKind::coated, ior);
  m.mean_free_path_m = {mean_free_path_m, mean_free_path_m, mean_free_path_m};
  return m;
}

/// White flesh between two planes one mean free path apart, lit evenly from above and seen from
/// below: 0.5532 of the light comes through [Heaslet & Warming, IJHMT 8, 1965, table 1: radiative
/// flux through a grey layer is the same integral equation].
Case white_slab() {
  const Rgbf one{1, 1, 1}, zero{0, 0, 0};
  return {"white flesh one mean free path thick, let through",
          scene_of(box({200, 200, 0.5}), flesh(1, 1), {Sky{one, one, zero}}),
          view_from({0, 0, -3}, {0, 0.3, 0}, 64), 0.5532, kAll};
}

}  // namespace

void add_media(std::vector<Case>& cases) {
  const TrueView of_sphere = view_from({0, -3, 0.4}, {0, 0, 0}, 64);
  const auto add = [&](const std::string& name, ObjectModel model, const Material& material,
                       const TrueView& view, double truth) {
    cases.push_back({name, scene_of(std::move(model), material, {even_sky(1)}), view, truth, kAll});
  };
  // No facet of a sphere keeps light in for ever: what goes in comes out.
  add("furnace, water", sphere(48, false), grey(1, SurfaceKind::clear, kWater), of_sphere, 1);
  add("furnace, smooth glass, shaded smooth", sphere(48, true), grey(1, SurfaceKind::clear, 1.5),
      of_sphere, 1);
  cases.push_back(floor_under_water());
  cases.push_back(sun_under_water());
  // White flesh loses nothing, however thin the body.
  for (const float path_m : {0.03F, 0.3F}) {
    const std::string text = std::to_string(path_m).substr(0, 4);
    add("furnace, flesh, mean free path " + text, sphere(24, true), flesh(1, path_m), of_sphere, 1);
  }
  add("furnace, flesh under a skin", sphere(24, true), flesh(1, 0.1F, 1.4), of_sphere, 1);
  cases.push_back(white_slab());
  const TrueView of_face = view_from({0.2, -0.3, 3}, {0.2, -0.1, 1}, 64);
  add("furnace, plate of flesh", box({3, 3, 1}), flesh(1, 4), of_face, 1);
  // Flat and 250 mean free paths from any edge, lit evenly: its albedo, in every direction.
  for (const float albedo : {0.4F, 0.8F}) {
    add("deep flesh of albedo " + std::to_string(albedo).substr(0, 3), box({3, 3, 1}),
        flesh(albedo, 0.004F), of_face, static_cast<double>(albedo));
  }
}

}  // namespace cousin::closed_form
