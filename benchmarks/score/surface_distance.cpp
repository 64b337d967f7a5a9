#include "benchmarks/score/surface_distance.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include "benchmarks/score/order_statistics.h"

namespace cousin {
namespace {

constexpr std::uint32_t kLeafTriangles = 4;
constexpr double kTie = 1 + 1e-12;  ///< squared distances nearer than this are the same

double segment_distance2(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                         const Eigen::Vector3d& b) {
  const Eigen::Vector3d along = b - a;
  const double length2 = along.squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - a).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (p - a - t * along).squaredNorm();
}

double triangle_distance2(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                          const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const double edges = std::min(
      {segment_distance2(p, a, b), segment_distance2(p, b, c), segment_distance2(p, c, a)});
  const Eigen::Vector3d normal = (b - a).cross(c - a);
  const double area2 = normal.squaredNorm();
  if (!(area2 > 0)) return edges;
  // Above the triangle if on the inner side of all three edges.
  const bool inside = (b - a).cross(p - a).dot(normal) >= 0 &&
                      (c - b).cross(p - b).dot(normal) >= 0 &&
                      (a - c).cross(p - c).dot(normal) >= 0;
  if (!inside) return edges;
  const double height = (p - a).dot(normal);
  return std::min(edges, height * height / area2);
}

struct WeightedSide {
  double height = 0;  ///< over the triangle's plane
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
};
/// A point's height over a triangle's plane and the unit normal there, both times the angle that
/// the triangle takes up about the point of it that is nearest: summed over all nearest triangles
/// the height has the sign of the side [Baerentzen and Aanaes, "Signed distance computation using
/// the angle weighted pseudonormal", TVCG 2005].
WeightedSide weighted_side(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                           const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const Eigen::Vector3d normal = (b - a).cross(c - a);
  const double size = normal.norm();
  if (!(size > 0)) return {};
  const double height = normal.dot(p - a) / size;
  const std::array<Eigen::Vector3d, 3> corner = {a, b, c};
  double nearest2 = std::numeric_limits<double>::infinity();
  double angle = 2 * std::numbers::pi;
  bool inside = true;
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector3d& from = corner[i];
    const Eigen::Vector3d& to = corner[(i + 1) % 3];
    const Eigen::Vector3d& third = corner[(i + 2) % 3];
    inside = inside && (to - from).cross(p - from).dot(normal) > 0;
    const double t = (p - from).dot(to - from) / (to - from).squaredNorm();
    const double distance2 = segment_distance2(p, from, to);
    if (distance2 >= nearest2) continue;
    nearest2 = distance2;
    const auto angle_between = [](const Eigen::Vector3d& u, const Eigen::Vector3d& v) {
      return std::atan2(u.cross(v).norm(), u.dot(v));
    };
    angle = t <= 0   ? angle_between(to - from, third - from)
            : t >= 1 ? angle_between(from - to, third - to)
                     : std::numbers::pi;
  }
  const double weight = inside ? 2 * std::numbers::pi : angle;
  return {height * weight, normal * (weight / size)};
}

}  // namespace

double point_triangle_distance_m(const Eigen::Vector3d& point, const Eigen::Vector3d& a,
                                 const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  return std::sqrt(triangle_distance2(point, a, b, c));
}

DistanceTree::DistanceTree(const Mesh& mesh)
    : vertices_(mesh.vertices_m), triangles_(mesh.triangles) {
  for (const auto& triangle : triangles_) {
    for (const std::uint32_t index : triangle) {
      if (index >= vertices_.size()) {
        throw std::invalid_argument("DistanceTree: vertex " + std::to_string(index) +
                                    " of a mesh with " + std::to_string(vertices_.size()));
      }
    }
  }
  build();
}

DistanceTree::DistanceTree(std::span<const Eigen::Vector3d> points_m)
    : vertices_(points_m.begin(), points_m.end()) {
  for (std::uint32_t i = 0; i < vertices_.size(); ++i) triangles_.push_back({i, i, i});
  build();
}

void DistanceTree::build() {
  if (triangles_.empty())
    throw std::invalid_argument("DistanceTree: there is nothing to measure to");
  for (const Eigen::Vector3d& vertex : vertices_) {
    if (!vertex.allFinite()) throw std::invalid_argument("DistanceTree: a vertex is not finite");
  }
  nodes_.reserve(triangles_.size());
  const auto add_node = [&](std::uint32_t first, std::uint32_t count) {
    Node node;
    node.first = first;
    node.count = count;
    nodes_.push_back(node);
  };
  add_node(0, static_cast<std::uint32_t>(triangles_.size()));
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    Node node = nodes_[i];
    node.low.setConstant(std::numeric_limits<double>::infinity());
    node.high = -node.low;
    for (std::uint32_t t = node.first; t < node.first + node.count; ++t) {
      for (const std::uint32_t v : triangles_[t]) {
        node.low = node.low.cwiseMin(vertices_[v]);
        node.high = node.high.cwiseMax(vertices_[v]);
      }
    }
    if (node.count > kLeafTriangles) {
      // Split at the median centre along the longest side; ties by the triangle's indices keep it
      // deterministic.
      Eigen::Index axis = 0;
      (node.high - node.low).maxCoeff(&axis);
      const auto key = [&](const std::array<std::uint32_t, 3>& t) {
        return std::pair(vertices_[t[0]][axis] + vertices_[t[1]][axis] + vertices_[t[2]][axis], t);
      };
      const auto begin = triangles_.begin() + node.first;
      const std::uint32_t half = node.count / 2;
      std::nth_element(begin, begin + half, begin + node.count,
                       [&](const auto& a, const auto& b) { return key(a) < key(b); });
      const auto children = static_cast<std::uint32_t>(nodes_.size());
      add_node(node.first, half);
      add_node(node.first + half, node.count - half);
      node.first = children;
      node.count = 0;
    }
    nodes_[i] = node;
  }
}

double DistanceTree::box_distance2(const Node& node, const Eigen::Vector3d& point) const {
  return (node.low - point).cwiseMax(point - node.high).cwiseMax(0.0).squaredNorm();
}

DistanceTree::Nearest DistanceTree::nearest(const Eigen::Vector3d& point_m) const {
  struct Entry {
    std::uint32_t node;
    double distance2;
  };
  std::array<Entry, 128>
      stack;  // depth of a median split of 2^32 triangles is 32, two entries a level
  std::size_t size = 0;
  stack[size++] = {0, box_distance2(nodes_[0], point_m)};
  Nearest best{std::numeric_limits<double>::infinity()};
  while (size > 0) {
    const Entry entry = stack[--size];
    if (entry.distance2 > best.distance2 * kTie) continue;
    const Node& node = nodes_[entry.node];
    if (node.count > 0) {
      for (std::uint32_t t = node.first; t < node.first + node.count; ++t) {
        const auto& [a, b, c] = triangles_[t];
        const double distance2 =
            a == b ? (point_m - vertices_[a]).squaredNorm()
                   : triangle_distance2(point_m, vertices_[a], vertices_[b], vertices_[c]);
        if (distance2 > best.distance2 * kTie) continue;
        WeightedSide side;
        if (a != b) side = weighted_side(point_m, vertices_[a], vertices_[b], vertices_[c]);
        // Triangles that share the nearest edge or corner are all at its distance.
        if (distance2 * kTie >= best.distance2) {
          side.height += best.facing;
          side.normal += best.normal;
        }
        best = {std::min(distance2, best.distance2), side.height, side.normal};
      }
      continue;
    }
    const Entry left{node.first, box_distance2(nodes_[node.first], point_m)};
    const Entry right{node.first + 1, box_distance2(nodes_[node.first + 1], point_m)};
    const bool left_first = left.distance2 <= right.distance2;
    stack[size++] = left_first ? right : left;
    stack[size++] = left_first ? left : right;
  }
  return best;
}

double DistanceTree::distance_m(const Eigen::Vector3d& point_m) const {
  return std::sqrt(nearest(point_m).distance2);
}

double DistanceTree::signed_distance_m(const Eigen::Vector3d& point_m) const {
  const Nearest found = nearest(point_m);
  return std::copysign(std::sqrt(found.distance2), found.facing);
}

Eigen::Vector3d DistanceTree::normal_at(const Eigen::Vector3d& point_m) const {
  const Eigen::Vector3d normal = nearest(point_m).normal;
  const double length = normal.norm();
  return length > 0 ? Eigen::Vector3d(normal / length) : Eigen::Vector3d::Zero();
}

std::vector<Eigen::Vector3d> sample_surface(const Mesh& mesh, int count, Rng rng) {
  std::vector<double> cumulative;
  double area = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    area += (mesh.vertices_m.at(b) - mesh.vertices_m.at(a))
                .cross(mesh.vertices_m.at(c) - mesh.vertices_m.at(a))
                .norm();
    cumulative.push_back(area);
  }
  if (!(area > 0) || !std::isfinite(area))
    throw std::invalid_argument("sample_surface: the mesh has no area");
  std::vector<Eigen::Vector3d> samples;
  samples.reserve(static_cast<std::size_t>(std::max(count, 0)));
  for (int i = 0; i < count; ++i) {
    const double along = area * (i + uniform(rng)) / count;
    const auto found = std::upper_bound(cumulative.begin(), cumulative.end() - 1, along);
    const auto& [a, b, c] = mesh.triangles[static_cast<std::size_t>(found - cumulative.begin())];
    // Square root: uniform over the triangle.
    const double s = std::sqrt(uniform(rng));
    const double t = uniform(rng);
    samples.push_back((1 - s) * mesh.vertices_m[a] + s * (1 - t) * mesh.vertices_m[b] +
                      s * t * mesh.vertices_m[c]);
  }
  return samples;
}

namespace {

std::vector<double> distances(std::span<const Eigen::Vector3d> points, const DistanceTree& tree) {
  std::vector<double> result(points.size());
  tbb::parallel_for(std::size_t{0}, points.size(),
                    [&](std::size_t i) { result[i] = tree.distance_m(points[i]); });
  return result;
}

double share_within(const std::vector<double>& values, double limit) {
  if (values.empty()) return 0;
  const auto count =
      std::count_if(values.begin(), values.end(), [&](double v) { return v <= limit; });
  return static_cast<double>(count) / static_cast<double>(values.size());
}

std::vector<double> signed_distances(std::span<const Eigen::Vector3d> points,
                                     const DistanceTree& tree) {
  std::vector<double> result(points.size());
  tbb::parallel_for(std::size_t{0}, points.size(),
                    [&](std::size_t i) { result[i] = tree.signed_distance_m(points[i]); });
  return result;
}

/// @param signed_to_surface  of the measured points
/// @param to_measured        of the samples; empty where nothing was measured
CloudScore score_of(const std::vector<double>& signed_to_surface,
                    const std::vector<double>& to_measured, std::size_t samples,
                    std::span<const double> tolerances_m) {
  std::vector<double> to_surface = signed_to_surface;
  for (double& distance_m : to_surface) distance_m = std::abs(distance_m);
  CloudScore score;
  score.measured_points = static_cast<std::int64_t>(signed_to_surface.size());
  score.surface_samples = static_cast<std::int64_t>(samples);
  score.bias_m = mean(signed_to_surface);
  score.accuracy_mean_m = mean(to_surface);
  score.accuracy_rms_m = rms(to_surface);
  score.accuracy_median_m = quantile(to_surface, 0.5);
  score.accuracy_p95_m = quantile(to_surface, 0.95);
  score.completeness_mean_m = mean(to_measured);
  score.completeness_p95_m = quantile(to_measured, 0.95);
  for (const double tolerance_m : tolerances_m) {
    CloudScore::AtTolerance at{tolerance_m, share_within(to_surface, tolerance_m),
                               share_within(to_measured, tolerance_m), 0};
    if (at.precision + at.recall > 0)
      at.f1 = 2 * at.precision * at.recall / (at.precision + at.recall);
    score.at.push_back(at);
  }
  return score;
}

void check_samples(std::span<const Eigen::Vector3d> samples, const char* where) {
  if (samples.empty()) {
    throw std::invalid_argument(std::string(where) + ": no samples of the true surface");
  }
}

}  // namespace

CloudScore score_cloud(std::span<const Eigen::Vector3d> cloud_m, const Mesh& surface,
                       std::span<const Eigen::Vector3d> surface_samples_m,
                       std::span<const double> tolerances_m) {
  check_samples(surface_samples_m, "score_cloud");
  const DistanceTree surface_tree(surface);
  if (cloud_m.empty()) return score_of({}, {}, surface_samples_m.size(), tolerances_m);
  return score_of(signed_distances(cloud_m, surface_tree),
                  distances(surface_samples_m, DistanceTree(cloud_m)), surface_samples_m.size(),
                  tolerances_m);
}

CloudScore score_mesh(const Mesh& measured, std::span<const Eigen::Vector3d> measured_samples_m,
                      const Mesh& surface, std::span<const Eigen::Vector3d> surface_samples_m,
                      std::span<const double> tolerances_m) {
  check_samples(surface_samples_m, "score_mesh");
  const DistanceTree surface_tree(surface);
  if (measured_samples_m.empty()) return score_of({}, {}, surface_samples_m.size(), tolerances_m);
  return score_of(signed_distances(measured_samples_m, surface_tree),
                  distances(surface_samples_m, DistanceTree(measured)), surface_samples_m.size(),
                  tolerances_m);
}

NormalScore score_normals(std::span<const Eigen::Vector3d> points_m,
                          std::span<const Eigen::Vector3d> normals, const Mesh& surface) {
  if (points_m.size() != normals.size())
    throw std::invalid_argument("score_normals: " + std::to_string(normals.size()) +
                                " normals for " + std::to_string(points_m.size()) + " points");
  const DistanceTree tree(surface);
  std::vector<double> angles_rad(points_m.size(), std::numeric_limits<double>::quiet_NaN());
  tbb::parallel_for(std::size_t{0}, points_m.size(), [&](std::size_t i) {
    if (!points_m[i].allFinite() || !normals[i].allFinite())
      throw std::invalid_argument("score_normals: a point or normal is not finite");
    if (!(normals[i].squaredNorm() > 0)) return;
    const Eigen::Vector3d true_normal = tree.normal_at(points_m[i]);
    if (true_normal.isZero()) return;
    angles_rad[i] = std::atan2(normals[i].cross(true_normal).norm(), normals[i].dot(true_normal));
  });
  std::erase_if(angles_rad, [](double angle) { return !std::isfinite(angle); });
  return {static_cast<std::int64_t>(angles_rad.size()), static_cast<std::int64_t>(points_m.size()),
          quantile(angles_rad, 0.5), quantile(angles_rad, 0.95)};
}

}  // namespace cousin
