#include "perception/splats/depth_mesh.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/geometry/isosurface.h"
#include "sim/types/camera.h"

namespace cousin {
namespace {

/// A view as the lattice asks it.
struct DepthSource {
  Lens lens;
  Pose camera_from_world;
  const Image<float>& depth_m;

  /// Depth along the axis at a pixel of the image: between its four neighbours where they belong
  /// to one surface, else the nearest one's; NaN = none. Nothing outside the image.
  std::optional<double> depth_at(const Eigen::Vector2d& pixel, double jump_m) const {
    const int x = static_cast<int>(std::floor(pixel.x() + 0.5));
    const int y = static_cast<int>(std::floor(pixel.y() + 0.5));
    if (!depth_m.contains(x, y)) return std::nullopt;
    const auto nearest = static_cast<double>(depth_m(x, y));
    const int x0 = static_cast<int>(std::floor(pixel.x()));
    const int y0 = static_cast<int>(std::floor(pixel.y()));
    if (!depth_m.contains(x0, y0) || !depth_m.contains(x0 + 1, y0 + 1)) return nearest;
    const double u = pixel.x() - x0, v = pixel.y() - y0;
    const auto a = static_cast<double>(depth_m(x0, y0));
    const auto b = static_cast<double>(depth_m(x0 + 1, y0));
    const auto c = static_cast<double>(depth_m(x0, y0 + 1));
    const auto d = static_cast<double>(depth_m(x0 + 1, y0 + 1));
    const double spread = std::max({a, b, c, d}) - std::min({a, b, c, d});
    const double mean = (1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * c + u * d);
    return std::isfinite(mean) && spread < jump_m ? mean : nearest;
  }
};

/// What the views say of one place.
struct Votes {
  double near_sum_m = 0;  ///< signed distances within the truncation
  int near = 0;
  int free = 0;    ///< views that see through it
  int hidden = 0;  ///< views for which it lies behind a surface
};

Votes votes_of(const std::vector<DepthSource>& sources, const Eigen::Vector3d& point_m,
               const DepthMeshConfig& config) {
  Votes votes;
  for (const DepthSource& source : sources) {
    const Eigen::Vector3d in_camera_m = source.camera_from_world * point_m;
    if (!(in_camera_m.z() > 0)) continue;
    const auto pixel = source.lens.project(in_camera_m);
    if (!pixel || !(pixel->cwiseAbs().maxCoeff() < 1e6)) continue;
    const std::optional<double> depth = source.depth_at(*pixel, 2 * config.truncation_m);
    if (!depth) continue;
    if (!std::isfinite(*depth)) {
      votes.free += config.no_depth == DepthMeshConfig::NoDepth::free ? 1 : 0;
      continue;
    }
    // Along the ray, not the axis: nearer to the distance across a surface.
    const double distance_m = (*depth / in_camera_m.z() - 1) * in_camera_m.norm();
    if (distance_m > config.truncation_m) {
      ++votes.free;
    } else if (distance_m < -config.truncation_m) {
      ++votes.hidden;
    } else {
      votes.near_sum_m += distance_m;
      ++votes.near;
    }
  }
  return votes;
}

double signed_distance_m(const Votes& votes, const DepthMeshConfig& config) {
  const bool is_free = votes.free >= config.free_views;
  if (votes.near > 0) {
    const int free = is_free ? votes.free : 0;
    return (votes.near_sum_m + free * config.truncation_m) / (votes.near + free);
  }
  return is_free || votes.hidden == 0 ? config.truncation_m : -config.truncation_m;
}

std::vector<DepthSource> sources_of(const Poses& poses, const Depths& depths) {
  if (poses.size() != depths.size()) {
    throw std::invalid_argument("mesh_of_depths: " + std::to_string(poses.size()) + " poses for " +
                                std::to_string(depths.size()) + " depth images");
  }
  std::vector<DepthSource> sources;
  for (std::size_t i = 0; i < depths.size(); ++i) {
    const Image<float>& depth_m = depths[i].depth_m;
    if (poses[i].status != PoseStatus::ok || depth_m.empty()) continue;
    const Camera& camera = poses[i].camera;
    if (camera.width_px != depth_m.width() || camera.height_px != depth_m.height()) {
      throw std::invalid_argument("mesh_of_depths: frame " + std::to_string(depths[i].frame) +
                                  ": the depth image is " + std::to_string(depth_m.width()) +
                                  " x " + std::to_string(depth_m.height()) + ", its camera " +
                                  std::to_string(camera.width_px) + " x " +
                                  std::to_string(camera.height_px));
    }
    validate(camera);
    sources.push_back({Lens(camera), poses[i].camera_from_world, depth_m});
  }
  return sources;
}

}  // namespace

void validate(const DepthMeshConfig& config) {
  const auto fail = [](const std::string& what) {
    throw std::invalid_argument("mesh_of_depths: " + what);
  };
  const auto require = [&](const char* key, double value, double low, double high) {
    if (value >= low && value <= high) return;
    fail(std::string(key) + " = " + std::to_string(value) + " is not in " + std::to_string(low) +
         ".." + std::to_string(high));
  };
  require("step_m", config.step_m, 1e-6, 1e3);
  require("truncation_m", config.truncation_m, config.step_m, 1e4);
  require("free_views", config.free_views, 1, 1e6);
  require("least_part", config.least_part, 0, 1);
  require("most_points", config.most_points, 1, 268435456);
  const Eigen::Vector3d side_m = config.high_m - config.low_m;
  if (!config.low_m.allFinite() || !config.high_m.allFinite() || !(side_m.array() > 0).all())
    fail("high_m is not above low_m");
  const double points =
      (side_m / config.step_m).array().ceil().unaryExpr([](double n) { return n + 3; }).prod();
  if (!(points <= config.most_points)) {
    fail("the box has " + std::to_string(points) + " lattice points; most_points is " +
         std::to_string(config.most_points));
  }
}

Mesh mesh_of_depths(const Poses& poses, const Depths& depths, const DepthMeshConfig& config) {
  validate(config);
  const std::vector<DepthSource> sources = sources_of(poses, depths);
  // A margin of one point all around is outside, so that the surface closes there.
  ValueLattice lattice;
  lattice.step_m = config.step_m;
  lattice.low_m = config.low_m - Eigen::Vector3d::Constant(config.step_m);
  for (int k = 0; k < 3; ++k) {
    lattice.size[static_cast<std::size_t>(k)] =
        static_cast<int>(std::ceil((config.high_m[k] - config.low_m[k]) / config.step_m)) + 3;
  }
  const int nz = lattice.size[2];
  lattice.values.assign(lattice.index(0, 0, nz), static_cast<float>(config.truncation_m));
  tbb::parallel_for(1, nz - 1, [&](int z) {
    for (int y = 1; y + 1 < lattice.size[1]; ++y) {
      for (int x = 1; x + 1 < lattice.size[0]; ++x) {
        const Votes votes = votes_of(sources, lattice.point_m(x, y, z), config);
        lattice.values[lattice.index(x, y, z)] =
            static_cast<float>(signed_distance_m(votes, config));
      }
    }
  });
  return large_parts(isosurface(lattice), config.least_part);
}

}  // namespace cousin
