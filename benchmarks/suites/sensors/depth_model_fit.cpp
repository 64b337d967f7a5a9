#include "benchmarks/suites/sensors/depth_model_fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "benchmarks/suites/sensors/depth_model_curves.h"
#include "sim/render/ray_scene.h"

namespace cousin {
namespace {

/// Depths over which the configuration measures, in steps of a constant factor.
std::vector<double> depths(const ActiveStereoConfig& config, int steps, double shift) {
  const double nearest = 1.25 * least_depth_m(config);
  const double farthest = std::min(0.6 * config.largest_depth_m, 14 * nearest);
  std::vector<double> result;
  for (int i = 0; i < steps; ++i)
    result.push_back(nearest * std::pow(farthest / nearest, (i + shift) / (steps - 1 + 2 * shift)));
  return result;
}

double rounded(double v) { return std::round(v * 1e4) / 1e4; }

ObjectModel plate_model(double half_m) {
  ObjectModel model;
  model.name = "plate";
  model.mesh.vertices_m = {
      {-half_m, -half_m, 0}, {half_m, -half_m, 0}, {half_m, half_m, 0}, {-half_m, half_m, 0}};
  model.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return model;
}

}  // namespace

std::vector<WallCase> fit_walls(const ActiveStereoConfig& config) {
  std::vector<WallCase> walls;
  const double texture = config.has_projector ? 0 : 0.6;
  // Without a projector the contrast is the light's alone.
  const std::vector<double> lights = config.has_projector
                                         ? std::vector<double>{0.01, 0.1, 1}
                                         : std::vector<double>{0.03, 0.06, 0.15, 0.3, 0.6, 3};
  const std::vector<double> distances = depths(config, config.has_projector ? 8 : 6, 0);
  // Fractions of the disparity by the golden section, so that all of them meet all of the light.
  double fraction = 0;
  const auto facing = [&](double z_m, double albedo, double light) {
    fraction += std::numbers::phi - 1;
    fraction -= std::floor(fraction);
    walls.push_back({at_fraction_m(config, z_m, fraction), 0, albedo, light, texture});
  };
  for (std::size_t i = 0; i < distances.size(); ++i) {
    for (const double light : lights) {
      facing(distances[i], 0.5, light);
      if (config.has_projector && i >= 3) facing(distances[i], 0.08, light);
    }
  }
  for (const double z : depths(config, 3, 0.5)) {
    for (const double incidence : {0.5, 0.8, 1.05}) {
      for (const std::size_t i : {std::size_t{0}, std::size_t{1}})
        walls.push_back({z, incidence, 0.5, lights[config.has_projector ? i : 5 - 2 * i], texture});
    }
  }
  return walls;
}

std::vector<WallCase> test_walls(const ActiveStereoConfig& config) {
  std::vector<WallCase> walls;
  const double texture = config.has_projector ? 0 : 0.6;
  const std::vector<double> lights =
      config.has_projector ? std::vector<double>{0.03, 0.3} : std::vector<double>{0.1, 1};
  for (const double z : depths(config, 5, 0.3)) {
    for (const double light : lights) walls.push_back({z, 0, 0.3, light, texture});
  }
  for (const double z : depths(config, 2, 0.7)) {
    for (const double incidence : {0.35, 0.65, 0.95})
      walls.push_back({z, incidence, 0.3, config.has_projector ? lights[0] : lights[1], texture});
  }
  return walls;
}

DepthModelConfig fit_depth_model(const ActiveStereoConfig& config, const ActiveStereoUnit& unit,
                                 int frames, const Rng& rng,
                                 const std::function<void(int, int)>& progress) {
  DepthModelConfig model = config.model;
  const std::vector<WallCase> walls = fit_walls(config);
  std::vector<WallScores> seen;
  double band = 0, bands = 0, grain = 0, grains = 0;
  for (std::size_t i = 0; i < walls.size(); ++i) {
    if (progress) progress(static_cast<int>(i), static_cast<int>(walls.size()));
    const Rng own = rng.fork(i);
    seen.push_back(score_full_model(see_wall(walls[i], config, unit, own), config, unit, frames,
                                    own.fork("full")));
    const WallScores& s = seen.back();
    if (walls[i].incidence_rad != 0 || s.fill < 0.99) continue;
    band += s.band_px - s.disparity_px;
    bands += 1;
    if (s.neighbours > 0 && s.neighbours < 1) {
      grain += 3 / (1 - s.neighbours);  // averages over squares correlate by 1 - lag / width
      grains += 1;
    }
  }
  fit_depth_curves(seen, config, model);
  if (bands > 0) model.band_px = rounded(band / bands);
  if (grains > 0) model.grain_px = rounded(std::clamp(grain / grains, 1.0, 65.0));
  const PlateEdges edges = plate_edges(config, unit, rng.fork("plate"));
  model.fatten_px = rounded(std::clamp(edges.growth_px, 0.0, 32.0));
  model.rim_px = rounded(std::clamp(edges.rim_px, 0.0, 32.0));
  return model;
}

std::vector<ModelComparison> compare_models(const std::vector<WallCase>& walls,
                                            const ActiveStereoConfig& config,
                                            const ActiveStereoUnit& unit, int frames,
                                            const Rng& rng) {
  constexpr int kScenes = 8;  // holes of single scenes: 1.5 points about a fill of a half
  std::vector<ModelComparison> result;
  for (std::size_t i = 0; i < walls.size(); ++i) {
    const Rng own = rng.fork(i);
    const WallView view = see_wall(walls[i], config, unit, own);
    result.push_back({walls[i], score_full_model(view, config, unit, frames, own.fork("full")),
                      score_fast_model(view, config, unit, frames, own.fork("fast"), kScenes)});
  }
  return result;
}

PlateEdges plate_edges(const ActiveStereoConfig& config, const ActiveStereoUnit& unit,
                       const Rng& rng) {
  const double near_m = 2.5 * least_depth_m(config), far_m = 1.6 * near_m;
  const double texture = config.has_projector ? 0 : 0.6;
  WallScene scene = make_wall({far_m, 0, 0.5, config.has_projector ? 0.02 : 1.0, texture});
  const double half_m = 0.25 * near_m;
  Instance plate = scene.scene.instances[0];
  plate.id = 2;
  plate.model = static_cast<int>(scene.scene.models.size());
  plate.world_from_object.translation_m.x() = near_m;
  scene.scene.models.push_back(plate_model(half_m));
  scene.scene.instances.push_back(plate);
  const RayScene rays(scene.scene);
  const InfraredPair pair = render_infrared_pair(rays, scene.scene, scene.rig_from_world, config,
                                                 unit, rng.fork("light"));
  const StereoDepth depth = sense_depth(pair, config, unit, rng.fork("sensor"));
  const Image<std::uint8_t> hidden = stereo_occlusion(pair.depth_m, config);
  const double split_m = 0.5 * (near_m + far_m);
  const double focal_baseline = unit.imager.fx_px * unit.baseline_m;
  double found = 0, truth = 0, none = 0;
  for (int y = 0; y < depth.depth.height(); ++y) {
    for (int x = 0; x < depth.depth.width(); ++x) {
      const double z = depth.depth(x, y) * config.depth_unit_m;
      const auto true_z = static_cast<double>(pair.depth_m(x, y));
      found += z > 0.8 * near_m && z < split_m ? 1 : 0;
      truth += true_z < split_m ? 1 : 0;
      const bool is_seen = hidden(x, y) == 0 && x - focal_baseline / true_z > 8;
      const bool is_near_plate =
          std::abs(std::abs(x - unit.imager.cx_px) - half_m / near_m * unit.imager.fx_px) < 12 ||
          std::abs(std::abs(y - unit.imager.cy_px) - half_m / near_m * unit.imager.fy_px) < 12;
      none += is_seen && is_near_plate && z == 0 ? 1 : 0;
    }
  }
  return {0.5 * (std::sqrt(found) - std::sqrt(truth)), none / (4 * std::sqrt(truth))};
}

}  // namespace cousin
