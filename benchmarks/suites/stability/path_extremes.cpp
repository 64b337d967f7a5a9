#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>

#include "benchmarks/suites/stability/path_scenes.h"
#include "sim/render/path_tracer.h"
#include "sim/render/ray_scene.h"

namespace cousin {
namespace {

using Eigen::Vector3d;
using namespace path_scenes;

constexpr int kAllBounces = 1024;

/// Mean and largest green of an image; NaN or infinite if any pixel is.
struct Brightness {
  double mean = 0, most = 0;
};
Brightness brightness(const Scene& scene, const TrueView& view, int samples, int bounces) {
  const RayScene rays(scene);
  const PathConfig config{.pixel_samples = samples, .max_bounces = bounces};
  const Image<Rgbf> image = PathTracer(rays, scene).render(view, config, Rng(1)).radiance;
  Brightness b;
  for (const Rgbf& c : image) {
    const auto green = static_cast<double>(c.g);
    b.mean += green / static_cast<double>(image.size());
    b.most = std::isfinite(green) ? std::max(b.most, green) : green;
  }
  return b;
}

std::string text_of(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

Material water() {
  Material m = matt(1);
  m.name = "water";
  m.kind = SurfaceKind::clear;
  m.ior = 1.333;
  return m;
}

Material flesh(float albedo, float mean_free_path_m) {
  Material m = matt(albedo);
  m.name = "flesh";
  m.mean_free_path_m = {mean_free_path_m, mean_free_path_m, mean_free_path_m};
  return m;
}

Scene lit(ObjectModel model, Material material, float sky) {
  Scene scene;
  scene.name = "extreme";
  add(scene, std::move(model), std::move(material), {0, 0, 0});
  scene.lights.emplace_back(even_sky(sky));
  return scene;
}

/// A square of 2 m as strips `width_m` wide, and a hundred triangles without area upon it.
ObjectModel strips(double width_m, int count) {
  ObjectModel model;
  model.name = "strips";
  auto& mesh = model.mesh;
  const auto n = static_cast<std::uint32_t>(count);
  for (std::uint32_t i = 0; i <= n; ++i) {
    mesh.vertices_m.emplace_back(-1, i * width_m, 0);
    mesh.vertices_m.emplace_back(1, i * width_m, 0);
  }
  for (std::uint32_t i = 0; i < 2 * n; i += 2) {
    mesh.triangles.push_back({i, i + 1, i + 3});
    mesh.triangles.push_back({i, i + 3, i + 2});
  }
  for (std::uint32_t i = 0; i < 100; ++i) {
    mesh.triangles.push_back({i % n, i % n, (i + 7) % n});
    mesh.triangles.push_back({i % n, (i + 2) % n, (i + 4) % n});  // on one line
  }
  return model;
}

void add_bright_rows(std::vector<StabilityRow>& rows, int samples) {
  // Under an even sky a floor of albedo a has radiance a times the sky's, and in the sun a over pi.
  for (const float light : {1e6F, 1e20F}) {
    const std::string name = "sky of radiance " + text_of(static_cast<double>(light));
    const Brightness b = brightness(lit(square(10), matt(0.5F), light),
                                    view_from({0, 0, 1}, {0, 0, 0}, 60), 4 * samples, 4);
    rows.push_back(make_row(name, "relative error of a floor's radiance", "", 1e-4,
                            std::abs(b.mean / (0.5 * static_cast<double>(light)) - 1)));
  }
  Scene sunny = lit(square(10), matt(0.5F), 0);
  sunny.lights.emplace_back(Sun{Vector3d::UnitZ(), 0.00465, {1e6F, 1e6F, 1e6F}});
  const Brightness b = brightness(sunny, view_from({0, 0, 1}, {0, 0, 0}, 60), samples, 4);
  rows.push_back(make_row("sun of irradiance 1e+06", "relative error of a floor's radiance", "",
                          1e-3, std::abs(b.mean / (0.5e6 / M_PI) - 1)));
  const Brightness at_sun = brightness(sunny, view_from({0, 0, 1}, {0, 0, 2}, 6000), samples, 4);
  const double sine = std::sin(0.00465);
  rows.push_back(make_row("camera that looks into a sun of irradiance 1e+06",
                          "relative error of its disk's radiance", "", 1e-4,
                          std::abs(at_sun.mean / (1e6 / (M_PI * sine * sine)) - 1)));
}

void add_triangle_rows(std::vector<StabilityRow>& rows, int samples) {
  for (const double width_m : {1e-3, 1e-5, 1e-7}) {
    const ObjectModel floor = strips(width_m, 200);
    const double middle_m = 100 * width_m;
    const Brightness b = brightness(
        lit(floor, matt(1), 1),
        view_from({0, middle_m, 0.01}, {0, middle_m, 0}, 24 * 0.01 / (100 * width_m)), samples, 4);
    rows.push_back(make_row("white floor of needles 2 m long and " + text_of(width_m) +
                                " m wide, with triangles of no area",
                            "deviation from the sky's radiance", "", 1e-4, std::abs(b.mean - 1)));
  }
  ObjectModel nothing = square(1);
  for (auto& v : nothing.mesh.vertices_m) v.setZero();
  const Brightness b =
      brightness(lit(nothing, matt(0.5F), 1), view_from({0, 0, 1}, {0, 0, 0}), samples, 4);
  rows.push_back(make_row("all triangles in one point", "deviation from the sky's radiance", "",
                          1e-6, std::abs(b.mean - 1)));
}

void add_inside_rows(std::vector<StabilityRow>& rows, int samples) {
  // Towards one face: water keeps light that meets all faces of a box at a slant.
  const TrueView inside = view_from({0.1, 0.2, -0.1}, {0.2, 1, 0.1}, 60);
  const auto most = [&](const Material& material, float sky) {
    return brightness(lit(box({1, 1, 1}), material, sky), inside, samples, kAllBounces);
  };
  rows.push_back(make_row("camera inside a closed fruit", "largest radiance", "", 0,
                          most(flesh(0.8F, 0.01F), 1).most));
  rows.push_back(make_row("camera inside a drop of water", "deviation from the sky's radiance", "",
                          1e-4, std::abs(most(water(), 1).mean - 1)));
  rows.push_back(make_row("water without light", "largest radiance", "", 0, most(water(), 0).most));
  const TrueView outside = view_from({0, -3, 0.4}, {0, 0, 0}, 20);
  rows.push_back(
      make_row("flesh without light", "largest radiance", "", 0,
               brightness(lit(box({1, 1, 1}), flesh(1, 0.1F), 0), outside, samples, 8).most));
}

/// White bodies lose nothing and cannot be seen.
void add_flesh_rows(std::vector<StabilityRow>& rows, int samples) {
  const auto seen = [&](const ObjectModel& model, float mean_free_path_m, const TrueView& view) {
    return std::abs(
        brightness(lit(model, flesh(1, mean_free_path_m), 1), view, samples, kAllBounces).mean - 1);
  };
  const char* const kQuantity = "deviation from the sky's radiance";
  const TrueView view = view_from({0.3, -3, 0.4}, {0, 0, 0}, 30);
  for (const float path_m : {1e-12F, 1e-4F, 1e-2F, 1e6F}) {
    rows.push_back(make_row("white flesh of mean free path " +
                                text_of(static_cast<double>(path_m)) + " m in a body of 2 m",
                            kQuantity, "", 1e-4, seen(box({1, 1, 1}), path_m, view)));
  }
  for (const double thickness_m : {1e-3, 1e-6, 1e-9}) {
    rows.push_back(make_row(
        "white flesh " + text_of(thickness_m) + " m thick, mean free path 1 cm", kQuantity, "",
        1e-4,
        seen(box({1, 1, 0.5 * thickness_m}), 0.01F, view_from({0.1, -0.4, 1.1}, {0, 0, 0}, 60))));
  }
}

/// A drop whose foot coincides with the leaf or the floor that it lies on.
void add_drop_rows(std::vector<StabilityRow>& rows, int samples) {
  for (const double gap_m : {1e-3, 0.0, -1e-3}) {
    Scene scene = lit(square(3), matt(1), 1);
    add(scene, box({0.5, 0.5, 0.1}), water(), {0, 0, 0.1 + gap_m});
    const double mean =
        brightness(scene, view_from({0.1, -0.4, 1}, {0, 0, 0.2}, 60), samples, kAllBounces).mean;
    rows.push_back(make_row("water " + text_of(gap_m * 1000) + " mm above a white floor",
                            "deviation from the sky's radiance", "", 0.01, std::abs(mean - 1)));
  }
  Scene nested = lit(box({1, 1, 1}), water(), 1);
  for (int i = 1; i < 30; ++i)
    add(nested, box(std::pow(0.9, i) * Vector3d(1, 1, 1)), water(), {0, 0, 0});
  const Brightness b =
      brightness(nested, view_from({0.4, -3, 0.7}, {0, 0, 0}, 20), samples, kAllBounces);
  rows.push_back(make_row("30 bodies of water in each other", "radiance above the sky's", "", 1e-3,
                          b.mean - 1));
  // What gets in through one face and meets another at a slant stays.
  rows.push_back(make_row("30 bodies of water in each other", "radiance", "", 0.9, b.mean, false));
}

}  // namespace

void add_path_extremes(std::vector<StabilityRow>& rows, int samples) {
  add_bright_rows(rows, samples);
  add_triangle_rows(rows, samples);
  add_inside_rows(rows, samples);
  add_flesh_rows(rows, samples);
  add_drop_rows(rows, samples);
}

}  // namespace cousin
