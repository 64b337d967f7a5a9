#include "tests/perception/silhouette/convex_bodies.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "perception/silhouette/icosphere.h"

namespace cousin {

Mesh make_body(const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& point) {
  Mesh mesh = icosphere(6);
  double lowest = 1;
  for (Eigen::Vector3d& vertex : mesh.vertices_m) {
    vertex = point(vertex);
    lowest = std::min(lowest, vertex.z());
  }
  for (Eigen::Vector3d& vertex : mesh.vertices_m) vertex.z() -= lowest;
  return mesh;
}

Mesh make_ellipsoid(const Eigen::Vector3d& semi_axes_m) {
  return make_body(
      [&](const Eigen::Vector3d& u) { return Eigen::Vector3d(semi_axes_m.cwiseProduct(u)); });
}

Mesh make_wedge(const Eigen::Vector3d& semi_axes_m, double power, double taper, double tilt_rad) {
  return make_body([&](const Eigen::Vector3d& u) {
    double sum = 0;
    for (int axis = 0; axis < 3; ++axis) sum += std::pow(std::abs(u[axis]), power);
    const Eigen::Vector3d unit = u * std::pow(sum, -1 / power);
    const double scale = 1 - taper * unit.x();
    const Eigen::Vector3d shaped(unit.x(), unit.y() * scale, unit.z() * (0.5 + 0.5 * scale));
    const Eigen::AngleAxisd tilt(tilt_rad, Eigen::Vector3d::UnitY());
    return Eigen::Vector3d(tilt * semi_axes_m.cwiseProduct(shaped));
  });
}

Poses make_poses(int views) {
  constexpr double kElevations[] = {0.26, 0.61, 1.05}, kDistances_m[] = {0.45, 0.40, 0.35};
  Poses poses;
  Rng rng(71);
  for (int i = 0; i < views; ++i) {
    const double azimuth = 2 * std::numbers::pi * (i / 3 + (i % 3) / 3.0) / (views / 3.0);
    const double elevation = kElevations[i % 3] + 0.05 * uniform(rng, -1, 1);
    const double distance_m = kDistances_m[i % 3] * (1 + 0.1 * uniform(rng, -1, 1));
    const Eigen::Vector3d eye(std::cos(azimuth) * std::cos(elevation),
                              std::sin(azimuth) * std::cos(elevation), std::sin(elevation));
    const Eigen::Vector3d target(0.02 * uniform(rng, -1, 1), 0.02 * uniform(rng, -1, 1), 0);
    FramePose pose;
    pose.frame = i;
    pose.status = PoseStatus::ok;
    pose.camera_from_world = look_at(distance_m * eye, target);
    pose.camera = {LensModel::opencv5,
                   1280,
                   720,
                   1080,
                   1080,
                   641.3,
                   357.9,
                   {0.05, -0.08, 0.0004, -0.0003, 0.02}};
    poses.push_back(pose);
  }
  return poses;
}

namespace {

/// Counter-clockwise in (x, y) by Andrew's monotone chain.
std::vector<Eigen::Vector2d> convex_polygon(std::vector<Eigen::Vector2d> points) {
  const auto less = [](const auto& a, const auto& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  };
  std::sort(points.begin(), points.end(), less);
  const auto half = [](const auto& ordered) {
    std::vector<Eigen::Vector2d> chain;
    for (const Eigen::Vector2d& point : ordered) {
      while (chain.size() >= 2) {
        const Eigen::Vector2d a = chain.back() - chain[chain.size() - 2], b = point - chain.back();
        if (a.x() * b.y() - a.y() * b.x() > 0) break;
        chain.pop_back();
      }
      chain.push_back(point);
    }
    chain.pop_back();
    return chain;
  };
  std::vector<Eigen::Vector2d> polygon = half(points);
  std::reverse(points.begin(), points.end());
  for (const Eigen::Vector2d& point : half(points)) polygon.push_back(point);
  return polygon;
}

}  // namespace

Silhouettes make_outlines(const Mesh& body, const Poses& poses, double sigma_px, Rng rng) {
  Silhouettes silhouettes;
  for (const FramePose& pose : poses) {
    Rng draw = rng.fork(static_cast<std::uint64_t>(pose.frame));
    std::vector<Eigen::Vector2d> pixels;
    for (const Eigen::Vector3d& vertex : body.vertices_m) {
      pixels.push_back(*project(pose.camera, pose.camera_from_world * vertex));
    }
    const std::vector<Eigen::Vector2d> polygon = convex_polygon(std::move(pixels));
    Silhouette silhouette{pose.frame, 0, {}};
    double next_px = 0.5, done_px = 0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Eigen::Vector2d edge = polygon[(i + 1) % polygon.size()] - polygon[i];
      const double length_px = edge.norm();
      const Eigen::Vector2d outward = Eigen::Vector2d(edge.y(), -edge.x()) / length_px;
      for (; next_px < done_px + length_px; next_px += 1) {
        const Eigen::Vector2d point = polygon[i] + edge * ((next_px - done_px) / length_px) +
                                      sigma_px * normal(draw) * outward;
        silhouette.outline.push_back(
            {point.cast<float>(), outward.cast<float>(), static_cast<float>(sigma_px)});
      }
      done_px += length_px;
    }
    silhouettes.push_back(std::move(silhouette));
  }
  return silhouettes;
}

Clusters make_cloud(const Mesh& body, double sigma_m, Rng rng) {
  Clusters clusters;
  clusters.count = 1;
  for (std::size_t i = 0; i < body.triangles.size(); i += 16) {
    const auto& [a, b, c] = body.triangles[i];
    const Eigen::Vector3d& origin = body.vertices_m[a];
    const Eigen::Vector3d normal_up =
        (body.vertices_m[b] - origin).cross(body.vertices_m[c] - origin).normalized();
    if (normal_up.z() < 0.2) continue;
    const Eigen::Vector3d point = origin + sigma_m * normal(rng) * normal_up;
    clusters.cloud.push_back(
        {point.cast<float>(), normal_up.cast<float>(), {}, static_cast<float>(sigma_m)});
    clusters.instance.push_back(0);
  }
  return clusters;
}

double volume_m3(const Mesh& mesh) {
  double sum = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    sum += mesh.vertices_m[a].dot(mesh.vertices_m[b].cross(mesh.vertices_m[c])) / 6;
  }
  return sum;
}

double area_m2(const Mesh& mesh) {
  double sum = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3d& origin = mesh.vertices_m[a];
    sum += (mesh.vertices_m[b] - origin).cross(mesh.vertices_m[c] - origin).norm() / 2;
  }
  return sum;
}

double width_m(const Mesh& mesh, const Eigen::Vector3d& direction) {
  double low = 1e9, high = -1e9;
  for (const Eigen::Vector3d& vertex : mesh.vertices_m) {
    low = std::min(low, vertex.dot(direction));
    high = std::max(high, vertex.dot(direction));
  }
  return high - low;
}

}  // namespace cousin
