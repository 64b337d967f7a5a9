#include "benchmarks/suites/shapes/shape_meshes.h"

#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include "sim/geometry/cube_sphere.h"
#include "sim/types/rng.h"

namespace cousin {
namespace {

constexpr int kGrid = 40;  ///< cells along a face of the cube: 9,602 vertices

/// Where a point of the unit sphere goes, metres.
using ShapeMap = Eigen::Vector3d (*)(const Eigen::Vector3d& u);

/// A kidney: 12.4 x 7.8 x 6.2 mm, hollow on one side.
Eigen::Vector3d bean(const Eigen::Vector3d& u) {
  const double bend = 0.22 * (u.x() * u.x() - 0.33);
  return {0.0062 * u.x(), 0.0039 * (u.y() + bend), 0.0031 * u.z() * (1 + 0.08 * u.x())};
}

/// Nearly a sphere of 7.6 mm, with two soft flats where neighbours pressed on it.
Eigen::Vector3d pea(const Eigen::Vector3d& u) {
  const auto flat = [&u](const Eigen::Vector3d& from) {
    return 0.05 * std::exp(6 * (u.dot(from.normalized()) - 1));
  };
  const double radius = 1 - flat({1, 0.3, 0.1}) - flat({-0.4, 0.2, 1});
  return 0.0038 * radius * u;
}

/// A lens of 6.4 x 2.6 mm with a rounded rim.
Eigen::Vector3d lentil(const Eigen::Vector3d& u) {
  const double across = std::hypot(u.x(), u.y());
  const double thin = 0.55 + 0.45 * std::sqrt(std::max(0.0, 1 - across * across));
  return {0.0032 * u.x(), 0.0031 * u.y(), 0.0013 * u.z() * thin};
}

/// Thick along one edge, thin along the other: 10 x 7.6 x 4.6 mm.
Eigen::Vector3d wedge(const Eigen::Vector3d& u) {
  // A superellipsoid: its sides are flatter and its edges tighter than an ellipsoid's.
  constexpr double kPower = 3;
  const double norm =
      std::pow(std::pow(std::abs(u.x()), kPower) + std::pow(std::abs(u.y()), kPower) +
                   std::pow(std::abs(u.z()), kPower),
               1 / kPower);
  const Eigen::Vector3d p = u / norm;
  return {0.005 * p.x(), 0.0038 * p.y(), 0.0023 * p.z() * (1 - 0.55 * p.y())};
}

/// As a scanner leaves a pebble: lumps of several sizes, and 10 um of noise.
Eigen::Vector3d blob(const Eigen::Vector3d& u) {
  double radius = 1;
  Rng rng = Rng(5).fork("blob");
  for (int wave = 0; wave < 12; ++wave) {
    Eigen::Vector3d vector;
    for (int k = 0; k < 3; ++k) vector[k] = normal(rng);
    const double frequency = 1 + 0.5 * wave;
    radius += 0.06 / frequency * std::sin(frequency * vector.dot(u) + uniform(rng, 0, 6.28));
  }
  return radius * Eigen::Vector3d(0.0050 * u.x(), 0.0041 * u.y(), 0.0035 * u.z());
}
constexpr double kScanNoise_m = 1e-5;

struct NamedShape {
  std::string_view name;
  ShapeMap map;
  double noise_m = 0;
};
constexpr std::array<NamedShape, 5> kShapes = {{{"bean", bean},
                                                {"pea", pea},
                                                {"lentil", lentil},
                                                {"wedge", wedge},
                                                {"blob", blob, kScanNoise_m}}};
constexpr std::array<std::string_view, kShapes.size()> kNames = [] {
  std::array<std::string_view, kShapes.size()> names;
  for (std::size_t i = 0; i < names.size(); ++i) names[i] = kShapes[i].name;
  return names;
}();

}  // namespace

std::span<const std::string_view> shape_names() { return kNames; }

Mesh shape_mesh(std::string_view name) {
  for (const NamedShape& shape : kShapes) {
    if (shape.name != name) continue;
    Mesh mesh = cube_sphere(kGrid);
    Rng rng = Rng(6).fork("noise");
    for (Eigen::Vector3d& vertex : mesh.vertices_m) {
      const Eigen::Vector3d u = vertex;
      vertex = shape.map(u) + shape.noise_m * normal(rng) * u;
    }
    return mesh;
  }
  std::string list;
  for (const std::string_view known : kNames)
    list += (list.empty() ? "" : ", ") + std::string(known);
  throw std::invalid_argument("shape \"" + std::string(name) + "\" is not one of " + list);
}

}  // namespace cousin
