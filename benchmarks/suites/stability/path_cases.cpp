#include "benchmarks/suites/stability/path_cases.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <utility>

#include "benchmarks/suites/stability/path_scenes.h"
#include "sim/render/path_tracer.h"
#include "sim/render/ray_scene.h"

namespace cousin {
namespace {

using Eigen::Vector3d;
using namespace path_scenes;
/// Mean of green over the image; NaN or infinite if any pixel is.
double mean_of(const Image<Rgbf>& image) {
  double sum = 0;
  for (const Rgbf& c : image) sum += static_cast<double>(c.g);
  return sum / static_cast<double>(image.size());
}

Image<Rgbf> picture(const Scene& scene, const TrueView& view, int samples, int bounces) {
  const RayScene rays(scene);
  const PathConfig config{.pixel_samples = samples, .max_bounces = bounces};
  return PathTracer(rays, scene).render(view, config, Rng(1)).radiance;
}

double mean_radiance(const Scene& scene, const TrueView& view, int samples, int bounces) {
  return mean_of(picture(scene, view, samples, bounces));
}

std::string text_of(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

// ---- scale and offset ---------------------------------------------------------------------------

/// A box on a floor beside a leaf, lit by an even sky and a lamp: everything in units of `scale_m`.
Scene still_life(double scale_m, const Vector3d& at_m) {
  Scene scene;
  scene.name = "still life";
  add(scene, box(scale_m * Vector3d(0.3, 0.2, 0.25)), matt(0.5F),
      at_m + scale_m * Vector3d(0, 0, 0.25));
  add(scene, square(3 * scale_m), matt(0.3F), at_m);
  add(scene, square(0.25 * scale_m), leaf_of(0.3F, 0.5F),
      at_m + scale_m * Vector3d(0.5, -0.3, 0.3));
  scene.lights.emplace_back(even_sky(0.5F));
  scene.lights.emplace_back(Lamp{at_m + scale_m * Vector3d(0.5, -1, 2),
                                 scale_m * Vector3d(0.2, 0, 0),
                                 scale_m * Vector3d(0, -0.2, 0),
                                 {10, 10, 10}});
  return scene;
}

void add_scale_rows(std::vector<StabilityRow>& rows, bool quick) {
  const auto mean_at = [&](double scale_m, const Vector3d& at_m) {
    return mean_radiance(
        still_life(scale_m, at_m),
        view_from(at_m + scale_m * Vector3d(1.5, -2, 1.6), at_m + scale_m * Vector3d(0.1, 0, 0.2)),
        quick ? 64 : 256, 4);
  };
  const double usual = mean_at(1, Vector3d::Zero());
  for (const double scale_m : {1e-4, 1e-2, 1.0, 1e2, 1e4}) {
    for (const double offset_m : {0.0, 1e3, 1e5}) {
      if (scale_m == 1 && offset_m == 0) continue;
      const double mean = mean_at(scale_m, offset_m * Vector3d(1, -0.7, 0.3));
      // The same random numbers: only rounding parts them, and edges that rays pass by chance. A
      // scene of 0.1 mm 1e5 m off is 1e-4 / 1e-11 of a double's steps there.
      rows.push_back(make_row(
          "light, scale " + text_of(scale_m) + " m at " + text_of(offset_m) + " m",
          "deviation of the mean radiance from scale 1", "", 1e-3, std::abs(mean / usual - 1)));
    }
  }
}

// ---- sheets that nearly touch -------------------------------------------------------------------

/// Two leaves of 0.1 m one over the other, `gap_m` apart and `away_m` from the scene's centre,
/// under a sky of 1 and above a ground of 0, seen from close above or below.
double leaf_pair(double gap_m, double away_m, bool from_above, int samples) {
  constexpr double kHalf_m = 0.05;
  Scene scene;
  scene.name = "two leaves";
  const Vector3d middle(away_m, 0, 0);
  for (const double z : {0.5 * gap_m, -0.5 * gap_m})
    add(scene, square(kHalf_m), leaf_of(0.3F, 0.5F), middle + Vector3d(0, 0, z));
  add(scene, square(1e-3), matt(0), -middle - Vector3d(0, 0, 1));
  scene.lights.emplace_back(Sky{{1, 1, 1}, {1, 1, 1}, {0, 0, 0}});
  const Vector3d eye_m = middle + Vector3d(0, 0, (from_above ? 1 : -1) * (gap_m + 1e-3));
  return mean_radiance(scene, view_from(eye_m, middle), samples, 64);
}

/// A leaf of 0.6 m close above soil of 1 m that is an open sheet, in a sky of 1 and over a ground
/// of 0, seen from above.
double leaf_on_soil(double gap_m, int samples) {
  Scene scene;
  scene.name = "leaf on soil";
  add(scene, square(0.5), matt(0.4F), {0, 0, 0.3});
  add(scene, square(0.3), leaf_of(0.3F, 0.5F), {0, 0, 0.3 + gap_m});
  scene.lights.emplace_back(Sky{{1, 1, 1}, {1, 1, 1}, {0, 0, 0}});
  return mean_radiance(scene, view_from({0, 0, 0.31 + gap_m}, {0, 0, 0.3}), samples, 64);
}

void add_sheet_rows(std::vector<StabilityRow>& rows, bool quick) {
  const int samples = quick ? 256 : 1024;
  // Layers of reflectance r and transmittance t add up as r + t^2 r / (1 - r^2) and
  // t^2 / (1 - r^2).
  const double r = 0.3, t = 0.5;
  const double reflected = r + t * t * r / (1 - r * r), transmitted = t * t / (1 - r * r);
  struct Pair {
    double gap_m, away_m;
  };
  for (const Pair& p : {Pair{2e-4, 1}, Pair{2e-4, 100}, Pair{1e-6, 1}, Pair{1e-8, 1},
                        Pair{1e-8, 100}, Pair{0, 1}}) {
    const std::string name = "leaf of two sheets " + text_of(p.gap_m * 1e6) + " um apart, " +
                             text_of(p.away_m) + " m from the centre";
    rows.push_back(make_row(name, "deviation of what it reflects", "", 0.01,
                            std::abs(leaf_pair(p.gap_m, p.away_m, true, samples) / reflected - 1)));
    rows.push_back(
        make_row(name, "deviation of what it lets through", "", 0.01,
                 std::abs(leaf_pair(p.gap_m, p.away_m, false, samples) / transmitted - 1)));
  }
  // A leaf on open soil of albedo a: r + t^2 a / (1 - r a). Light that passed the soil would be
  // lost below it.
  const double a = 0.4, on_soil = r + t * t * a / (1 - r * a);
  for (const double gap_m : {1e-3, 1e-7, 1e-9}) {
    rows.push_back(make_row("leaf " + text_of(gap_m * 1e6) + " um above soil",
                            "deviation of what both reflect", "", 0.01,
                            std::abs(leaf_on_soil(gap_m, samples) / on_soil - 1)));
  }
}

/// Mean of a white closed plate thinner and thinner in an even sky: it cannot be seen.
void add_thin_plate_rows(std::vector<StabilityRow>& rows, int samples) {
  for (const double thickness_m : {1e-3, 1e-5, 1e-7, 1e-9}) {
    Scene scene;
    scene.name = "plate";
    add(scene, box({0.5, 0.5, 0.5 * thickness_m}), matt(1), {2, 1, 0.5});
    scene.lights.emplace_back(even_sky(1));
    const double mean =
        mean_radiance(scene, view_from({2.1, 0.2, 1.1}, {2, 1, 0.5}, 60), samples, 8);
    rows.push_back(make_row("white plate " + text_of(thickness_m) + " m thick in an even sky",
                            "deviation of its radiance from the sky's", "", 1e-4,
                            std::abs(mean - 1)));
  }
}

// ---- cameras, boxes, lights ---------------------------------------------------------------------

void add_place_rows(std::vector<StabilityRow>& rows, int samples) {
  Scene sheet;
  sheet.name = "sheet";
  add(sheet, square(1), leaf_of(0.5F, 0.5F), {0, 0, 0});
  sheet.lights.emplace_back(even_sky(1));
  // A leaf that loses nothing cannot be seen, from wherever.
  const auto seen = [&](const Scene& scene, const Vector3d& eye_m, const Vector3d& target_m) {
    return std::abs(mean_radiance(scene, view_from(eye_m, target_m, 20), samples, 16) - 1);
  };
  const char* const kQuantity = "deviation from the sky's radiance";
  rows.push_back(make_row("camera on a leaf, looking away", kQuantity, "", 1e-4,
                          seen(sheet, {0.1, 0.07, 0}, {0.1, 0.07, 1})));
  rows.push_back(make_row("camera on a leaf, looking along it", kQuantity, "", 1e-4,
                          seen(sheet, {0.1, 0.07, 0}, {0.1, 1.07, 0})));
  Scene thick;
  thick.name = "leaf of two sheets";
  for (const double z : {1e-4, -1e-4}) add(thick, square(0.05), leaf_of(0.5F, 0.5F), {0, 0, z});
  thick.lights.emplace_back(even_sky(1));
  rows.push_back(make_row("camera inside a leaf of 0.2 mm", kQuantity, "", 2e-3,
                          seen(thick, {0, 0, 0}, {0, 0.01, 0.1})));
  Scene dense;
  dense.name = "overlapping leaves";
  for (int i = 0; i < 1000; ++i)
    add(dense, square(0.05), leaf_of(0.5F, 0.5F), {0, 0, 1e-4 * (i / 10)});  // tens coincide
  dense.lights.emplace_back(even_sky(1));
  // Paths of at most 64 bounces lose what goes on.
  const double mean =
      mean_radiance(dense, view_from({0.01, 0.01, 0.2}, {0, 0, 0.05}, 200), samples, 64);
  rows.push_back(
      make_row("1000 overlapping leaves", "radiance above the sky's", "", 1e-3, mean - 1));
  rows.push_back(make_row("1000 overlapping leaves", "radiance", "", 0.7, mean, false));
}

void add_light_rows(std::vector<StabilityRow>& rows, int samples) {
  const auto floor_of = [](std::vector<Light> lights) {
    Scene scene;
    scene.name = "lit floor";
    add(scene, square(1), matt(0.5F), {0, 0, 0});
    scene.lights = std::move(lights);
    return scene;
  };
  const TrueView above = view_from({0, 0, 1}, {0, 0, 0}, 2000);
  Scene closed;
  closed.name = "closed box";
  add(closed, box({1, 1, 1}, true), matt(1), {0, 0, 0});
  closed.lights.emplace_back(Lamp{{0, 0, 0}, {0.2, 0, 0}, {0, 0.2, 0}, {1, 1, 1}});
  const double white = mean_radiance(closed, view_from({0, 0.9, -0.9}, {0, 0, 0}), 16, 1024);
  rows.push_back(make_row("closed box of albedo 1, 1024 bounces", "radiance is a positive number",
                          "", 1, std::isfinite(white) && white > 0 ? 1 : 0, false));
  Scene inside = floor_of({Lamp{{0, 0, 0.5}, {0.1, 0, 0}, {0, -0.1, 0}, {5, 5, 5}}});
  add(inside, box({0.2, 0.2, 0.2}), matt(0.5F), {0, 0, 0.5});
  rows.push_back(
      make_row("lamp inside a closed body", "radiance outside", "", 0,
               mean_radiance(inside, view_from({0.6, 0, 0.3}, {0.6, 0, 0}), samples, 4)));
  Scene dark = floor_of({});
  rows.push_back(make_row("no light", "radiance", "", 0, mean_radiance(dark, above, 8, 4)));
  const auto lamp_mean = [&](double half_m, float radiance) {
    return mean_radiance(
        floor_of(
            {Lamp{{0, 0, 2}, {half_m, 0, 0}, {0, -half_m, 0}, {radiance, radiance, radiance}}}),
        above, samples, 0);
  };
  // Straight below at 2 m: albedo / pi * L * area / 4.
  for (const auto& [half_m, radiance] :
       {std::pair(1e-9, 1e20F), std::pair(1e-6, 1e12F), std::pair(1e-3, 1e-12F)}) {
    const double expected = 0.5 / M_PI * static_cast<double>(radiance) * 4 * half_m * half_m / 4;
    rows.push_back(make_row("lamp of " + text_of(2 * half_m) + " m and radiance " +
                                text_of(static_cast<double>(radiance)),
                            "relative error below it", "", 1e-3,
                            std::abs(lamp_mean(half_m, radiance) / expected - 1)));
  }
  const Environment texel{Image<Rgbf>(1, 1, {2, 2, 2})};
  rows.push_back(make_row("environment of one texel", "relative error of a floor's radiance", "",
                          0.01,
                          std::abs(mean_radiance(floor_of({texel}), above, 4 * samples, 0) - 1)));
  Environment spike{Image<Rgbf>(2048, 1024, {0, 0, 0})};
  spike.radiance(100, 300) = {1e20F, 1e20F, 1e20F};
  const double spiked = mean_radiance(floor_of({spike}), above, samples, 0);
  rows.push_back(make_row("environment with one texel of 1e20", "radiance is a positive number", "",
                          1, std::isfinite(spiked) && spiked > 0 ? 1 : 0, false));
}

}  // namespace

std::vector<StabilityRow> path_cases(bool quick) {
  std::vector<StabilityRow> rows;
  const int samples = quick ? 32 : 256;
  add_scale_rows(rows, quick);
  add_sheet_rows(rows, quick);
  add_thin_plate_rows(rows, samples);
  add_place_rows(rows, samples);
  add_light_rows(rows, samples);
  add_path_extremes(rows, samples);
  add_path_refusals(rows);
  return rows;
}

}  // namespace cousin
