#include "benchmarks/sensors/depth_wall.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "sim/render/ray_scene.h"

namespace cousin {
namespace {

/// Square of two triangles about the origin in z = 0, facing +z.
ObjectModel square(double half_m) {
  ObjectModel model;
  model.name = "wall";
  model.mesh.vertices_m = {
      {-half_m, -half_m, 0}, {half_m, -half_m, 0}, {half_m, half_m, 0}, {-half_m, half_m, 0}};
  model.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return model;
}

struct Sums {
  double n = 0, sum = 0, squares = 0;
  void add(double v) {
    n += 1;
    sum += v;
    squares += v * v;
  }
  double mean() const { return sum / n; }
  double sigma() const { return std::sqrt(std::max(0.0, squares / n - mean() * mean())); }
};

}  // namespace

WallScene make_wall(const WallCase& wall) {
  WallScene out;
  Scene& scene = out.scene;
  scene.name = "wall";
  Material material;
  material.name = "wall";
  material.infrared_albedo = static_cast<float>(wall.albedo);
  material.ior = 1;
  if (wall.texture > 0) {
    NoiseTexture noise;
    const auto dark = static_cast<float>(0.5 * (1 - wall.texture));
    noise.other_albedo = {dark, dark, dark};
    noise.scale_m = 0.006 * wall.distance_m;  // some pixels
    noise.octaves = 3;
    material.noise = noise;
  }
  scene.models.push_back(square(6 * std::max(wall.distance_m, 0.1)));
  scene.materials.push_back(material);
  Instance instance;
  instance.id = 1;
  instance.name = "wall";
  // Faces -x, then turns about the vertical.
  instance.world_from_object.rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(wall.incidence_rad, Eigen::Vector3d::UnitZ()) *
                         Eigen::AngleAxisd(-0.5 * std::numbers::pi, Eigen::Vector3d::UnitY()));
  instance.world_from_object.translation_m = {wall.distance_m, 0, 0};
  scene.instances.push_back(instance);
  const auto radiance = static_cast<float>(wall.light / std::numbers::pi);
  const Rgbf even{radiance, radiance, radiance};
  scene.lights.emplace_back(Sky{even, even, even});
  out.rig_from_world = look_at({0, 0, 0}, {1, 0, 0});
  return out;
}

WallScores score_wall(const WallCase& wall, const ActiveStereoConfig& config,
                      const ActiveStereoUnit& unit, int frames, Rng rng) {
  const WallScene scene = make_wall(wall);
  const RayScene rays(scene.scene);
  const InfraredPair pair = render_infrared_pair(rays, scene.scene, scene.rig_from_world, config,
                                                 unit, rng.fork("light"));
  const int width = pair.depth_m.width(), height = pair.depth_m.height();
  const double focal_baseline = unit.imager.fx_px * unit.baseline_m;
  std::vector<Sums> pixels(pair.depth_m.size());
  Sums errors, depth_errors;
  double asked = 0;
  for (int k = 0; k < frames; ++k) {
    const StereoDepth depth =
        sense_depth(pair, config, unit, rng.fork("frame").fork(static_cast<std::uint64_t>(k)));
    for (int y = height / 4; y < 3 * height / 4; ++y) {
      for (int x = width / 4; x < 3 * width / 4; ++x) {
        const auto z = static_cast<double>(pair.depth_m(x, y));
        const double truth_px = focal_baseline / z;
        if (!(x - truth_px >= 8)) continue;
        asked += 1;
        if (depth.depth(x, y) == 0) continue;
        const double error_px = static_cast<double>(depth.disparity_px(x, y)) - truth_px;
        errors.add(error_px);
        depth_errors.add(depth.depth(x, y) * config.depth_unit_m - z);
        pixels[static_cast<std::size_t>(y * width + x)].add(error_px);
      }
    }
  }
  WallScores scores;
  scores.pixels = static_cast<std::int64_t>(asked / frames);
  scores.fill = asked > 0 ? errors.n / asked : 0;
  if (errors.n < 2) return scores;
  scores.bias_px = errors.mean();
  scores.sigma_px = errors.sigma();
  scores.sigma_m = depth_errors.sigma();
  Sums means;
  std::vector<double> temporal;
  for (const Sums& p : pixels) {
    if (p.n < std::max(1.0, 0.5 * frames)) continue;
    means.add(p.mean());
    if (p.n >= 2) temporal.push_back(p.sigma() * std::sqrt(p.n / (p.n - 1)));
  }
  if (means.n > 1) scores.spatial_px = means.sigma();
  if (!temporal.empty()) {
    const auto middle = temporal.begin() + static_cast<std::ptrdiff_t>(temporal.size() / 2);
    std::nth_element(temporal.begin(), middle, temporal.end());
    scores.temporal_px = *middle;
  }
  return scores;
}

}  // namespace cousin
