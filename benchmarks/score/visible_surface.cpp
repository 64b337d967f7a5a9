#include "benchmarks/score/visible_surface.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace cousin {
namespace {

/// Whether a way from `from` along `way` meets a box before its end.
bool meets_box(const Eigen::Vector3d& from, const Eigen::Vector3d& way, const Eigen::Vector3d& low,
               const Eigen::Vector3d& high) {
  double enter = 0, leave = 1;
  for (int k = 0; k < 3; ++k) {
    if (way[k] == 0) {
      if (from[k] < low[k] || from[k] > high[k]) return false;
      continue;
    }
    const double a = (low[k] - from[k]) / way[k], b = (high[k] - from[k]) / way[k];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  // A share of rounding wider, so that flat boxes are met.
  return enter <= leave + 1e-12;
}

/// Moller & Trumbore's test, edges included by a share of rounding.
bool crosses(const Eigen::Vector3d& from, const Eigen::Vector3d& way, const Eigen::Vector3d& a,
             const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  constexpr double kRounding = 1e-12;
  const Eigen::Vector3d ab = b - a, ac = c - a;
  const Eigen::Vector3d across = way.cross(ac);
  const double determinant = ab.dot(across);
  if (determinant == 0) return false;
  const Eigen::Vector3d to = from - a;
  const double u = to.dot(across) / determinant;
  const Eigen::Vector3d turned = to.cross(ab);
  const double v = way.dot(turned) / determinant;
  const double t = ac.dot(turned) / determinant;
  return u >= -kRounding && v >= -kRounding && u + v <= 1 + kRounding && t > 0 && t < 1;
}

/// Measured points that are nearest to what could be seen.
std::vector<Eigen::Vector3d> near_seen(std::span<const Eigen::Vector3d> points_m,
                                       const VisibleSamples& samples) {
  if (samples.unseen_m.empty() || samples.seen_m.empty()) return {points_m.begin(), points_m.end()};
  const DistanceTree seen(samples.seen_m), unseen(samples.unseen_m);
  std::vector<std::uint8_t> counts(points_m.size());
  tbb::parallel_for(std::size_t{0}, points_m.size(), [&](std::size_t i) {
    counts[i] = seen.distance_m(points_m[i]) <= unseen.distance_m(points_m[i]) ? 1 : 0;
  });
  std::vector<Eigen::Vector3d> result;
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    if (counts[i] != 0) result.push_back(points_m[i]);
  }
  return result;
}

}  // namespace

bool DistanceTree::blocks(const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m) const {
  const Eigen::Vector3d way = to_m - from_m;
  std::vector<std::uint32_t> todo = {0};
  while (!todo.empty()) {
    const Node& node = nodes_[todo.back()];
    todo.pop_back();
    if (!meets_box(from_m, way, node.low, node.high)) continue;
    if (node.count == 0) {
      todo.push_back(node.first);
      todo.push_back(node.first + 1);
      continue;
    }
    for (std::uint32_t t = node.first; t < node.first + node.count; ++t) {
      const auto& triangle = triangles_[t];
      if (crosses(from_m, way, vertices_[triangle[0]], vertices_[triangle[1]],
                  vertices_[triangle[2]]))
        return true;
    }
  }
  return false;
}

VisibleSamples visible_samples(const Mesh& scene, std::span<const Eigen::Vector3d> samples_m,
                               std::span<const SurfaceView> views, int least_views, double skin_m) {
  if (least_views < 1) {
    throw std::invalid_argument("visible_samples: least_views = " + std::to_string(least_views) +
                                " is below 1");
  }
  if (!(skin_m >= 0) || !std::isfinite(skin_m))
    throw std::invalid_argument("visible_samples: skin_m = " + std::to_string(skin_m) +
                                " is not a length");
  const DistanceTree tree(scene);
  std::vector<Lens> lenses;
  for (const SurfaceView& view : views) lenses.emplace_back(view.camera);
  const auto sees = [&](std::size_t v, const Eigen::Vector3d& sample_m) {
    const Camera& camera = views[v].camera;
    const auto pixel = lenses[v].project(views[v].camera_from_world * sample_m);
    if (!pixel || !(pixel->x() >= -0.5 && pixel->x() <= camera.width_px - 0.5) ||
        !(pixel->y() >= -0.5 && pixel->y() <= camera.height_px - 0.5)) {
      return false;
    }
    const Eigen::Vector3d eye_m = centre_in_world_m(views[v].camera_from_world);
    const Eigen::Vector3d way = sample_m - eye_m;
    return way.norm() <= skin_m || !tree.blocks(eye_m, sample_m - way * (skin_m / way.norm()));
  };
  std::vector<std::uint8_t> is_seen(samples_m.size());
  tbb::parallel_for(std::size_t{0}, samples_m.size(), [&](std::size_t i) {
    int count = 0;
    for (std::size_t v = 0; v < views.size() && count < least_views; ++v)
      count += sees(v, samples_m[i]) ? 1 : 0;
    is_seen[i] = count >= least_views ? 1 : 0;
  });
  VisibleSamples result;
  for (std::size_t i = 0; i < samples_m.size(); ++i)
    (is_seen[i] != 0 ? result.seen_m : result.unseen_m).push_back(samples_m[i]);
  return result;
}

CloudScore score_visible_cloud(std::span<const Eigen::Vector3d> cloud_m, const Mesh& surface,
                               const VisibleSamples& samples,
                               std::span<const double> tolerances_m) {
  return score_cloud(near_seen(cloud_m, samples), surface, samples.seen_m, tolerances_m);
}

CloudScore score_visible_mesh(const Mesh& measured,
                              std::span<const Eigen::Vector3d> measured_samples_m,
                              const Mesh& surface, const VisibleSamples& samples,
                              std::span<const double> tolerances_m) {
  return score_mesh(measured, near_seen(measured_samples_m, samples), surface, samples.seen_m,
                    tolerances_m);
}

double chamfer_m(const CloudScore& score) {
  return 0.5 * (score.accuracy_mean_m + score.completeness_mean_m);
}

}  // namespace cousin
