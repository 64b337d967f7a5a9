#include <cmath>
#include <string>
#include <utility>

#include "benchmarks/renderers/closed_form_case.h"

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

/// A floor of albedo a under still water in an even sky: what water lets in, less what it mirrors
/// down again of each return, comes out: F + (1 - F) a (1 - Fi) / (1 - a Fi) towards a direction of
/// mirroring F. Light that is diffuse below comes out by 1 - Fi = (1 - Fe) / n^2, where Fe is what
/// diffuse light from above loses.
Case floor_under_water() {
  constexpr double kAlbedo = 0.6;
  constexpr int kCells = 20000;
  double outer = 0;
  for (int i = 0; i < kCells; ++i) {
    const double cosine = (i + 0.5) / kCells;
    outer += 2 * cosine * mirrored(cosine) / kCells;
  }
  const double inner = 1 - (1 - outer) / (kWater * kWater);
  const Eigen::Vector3d eye_m(0, -0.8, 1.1), on_water_m(0, 0, 0.5);
  const double cosine = (eye_m - on_water_m).normalized().z();
  const double up = kAlbedo * (1 - inner) / (1 - kAlbedo * inner);
  Case c{"floor under water",
         scene_of(box({500, 500, 0.5}), grey(1, SurfaceKind::clear, kWater), {even_sky(1)}),
         view_from(eye_m, on_water_m, 4e4), mirrored(cosine) + (1 - mirrored(cosine)) * up, kAll};
  Instance floor;
  floor.id = 2;
  floor.name = "floor";
  floor.model = floor.material = 1;
  c.scene.models.push_back(square(600));
  c.scene.materials.push_back(grey(static_cast<float>(kAlbedo)));
  c.scene.instances.push_back(floor);
  return c;
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
  for (const float albedo : {0.2F, 0.8F}) {
    add("deep flesh of albedo " + std::to_string(albedo).substr(0, 3), box({3, 3, 1}),
        flesh(albedo, 0.004F), of_face, static_cast<double>(albedo));
  }
}

}  // namespace cousin::closed_form
