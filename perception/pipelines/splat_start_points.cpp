#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "perception/pipelines/seeds_splats.h"

namespace cousin {
namespace {

constexpr float kRaised_m = 0.0005F;  ///< above the board: more than its own noise

bool is_closed(const Surface& surface) {
  return surface.status == SurfaceStatus::ok && !surface.mesh.triangles.empty();
}

/// A triangle's normal, of twice its area's length.
Eigen::Vector3d scaled_normal(const Mesh& mesh, std::size_t triangle) {
  const auto& [a, b, c] = mesh.triangles[triangle];
  return (mesh.vertices_m[b] - mesh.vertices_m[a]).cross(mesh.vertices_m[c] - mesh.vertices_m[a]);
}

double area_m2(const Mesh& mesh) {
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    sum += 0.5 * scaled_normal(mesh, t).norm();
  return sum;
}

/// Points at even steps of area along the triangles' order, each anywhere in its triangle.
void add_points_of(const Mesh& mesh, int count, const Rgb8& color, Rng rng,
                   std::vector<StartPoint>& points) {
  const double step_m2 = area_m2(mesh) / count;
  double passed_m2 = 0, next_m2 = 0.5 * step_m2;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Eigen::Vector3d normal = scaled_normal(mesh, t);
    passed_m2 += 0.5 * normal.norm();
    for (; next_m2 < passed_m2; next_m2 += step_m2) {
      const double u = std::sqrt(uniform(rng)), v = uniform(rng);
      const auto& [a, b, c] = mesh.triangles[t];
      points.push_back({(1 - u) * mesh.vertices_m[a] + u * (1 - v) * mesh.vertices_m[b] +
                            u * v * mesh.vertices_m[c],
                        color, normal.normalized()});
    }
  }
}

/// Mean colour of a cluster's points.
Rgb8 color_of(const Clusters& clusters, int instance) {
  std::array<double, 3> sum{};
  double count = 0;
  for (std::size_t i = 0; i < clusters.instance.size(); ++i) {
    if (clusters.instance[i] != instance) continue;
    const Rgb8 c = clusters.cloud[i].color;
    sum[0] += c.r;
    sum[1] += c.g;
    sum[2] += c.b;
    ++count;
  }
  const auto code = [&](double v) {
    return static_cast<std::uint8_t>(std::lround(v / std::max(1.0, count)));
  };
  return {code(sum[0]), code(sum[1]), code(sum[2])};
}

/// Points of the cloud that lie on the board, and higher ones of no cluster or of one without a
/// closed surface.
std::vector<const CloudPoint*> others_of(const Clusters& clusters, const Cloud& cloud,
                                         const Surfaces& surfaces) {
  std::vector<const CloudPoint*> others;
  for (const CloudPoint& point : cloud) {
    if (point.position_m.z() <= kRaised_m) others.push_back(&point);
  }
  for (std::size_t i = 0; i < clusters.instance.size(); ++i) {
    const int instance = clusters.instance[i];
    const bool covered = std::any_of(surfaces.begin(), surfaces.end(), [&](const Surface& s) {
      return s.instance == instance && is_closed(s);
    });
    if (!covered && clusters.cloud[i].position_m.z() > kRaised_m)
      others.push_back(&clusters.cloud[i]);
  }
  return others;
}

}  // namespace

std::vector<StartPoint> start_on_surfaces(const Clusters& clusters, const Cloud& cloud,
                                          const Surfaces& surfaces, const SeedsSplatConfig& config,
                                          const Rng& rng) {
  double all_m2 = 0;
  for (const Surface& surface : surfaces) all_m2 += is_closed(surface) ? area_m2(surface.mesh) : 0;
  std::vector<StartPoint> points;
  for (const Surface& surface : surfaces) {
    if (!is_closed(surface)) continue;
    const double share = area_m2(surface.mesh) / all_m2;
    const auto count =
        static_cast<int>(std::lround(share * config.raised_share * config.start_points));
    if (count > 0) {
      add_points_of(surface.mesh, count, color_of(clusters, surface.instance),
                    rng.fork(static_cast<std::uint64_t>(surface.instance)), points);
    }
  }
  const std::vector<const CloudPoint*> others = others_of(clusters, cloud, surfaces);
  const auto limit = static_cast<std::size_t>(config.start_points);
  points.resize(std::min(points.size(), limit));
  const std::size_t count = std::min(others.size(), limit - points.size());
  for (std::size_t i = 0; i < count; ++i) {
    const CloudPoint& point = *others[i * others.size() / count];
    Eigen::Vector3d at_m = point.position_m.cast<double>(), normal = point.normal.cast<double>();
    if (point.position_m.z() <= kRaised_m) {  // the board's face is known
      at_m.z() = 0;
      normal = Eigen::Vector3d::UnitZ();
    }
    points.push_back({at_m, point.color, normal});
  }
  return points;
}

}  // namespace cousin
