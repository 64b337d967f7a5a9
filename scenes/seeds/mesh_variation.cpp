#include "scenes/seeds/mesh_variation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace cousin {
namespace {

constexpr int kWaves = 3;
/// Amplitude of a wave over variation times radius: with the shortest wave of two radii all slopes
/// together stay below pi / 2 of the variation, and the least factor is exp(-2 variation).
constexpr double kWaveShare = 1.0 / 6;
constexpr double kMostSigmas = 2;  ///< of a factor: no axis becomes a mirror

/// A wave that moves points along one direction.
struct Wave {
  Eigen::Vector3d direction;  ///< of the movement, with its amplitude, in the mesh's unit
  Eigen::Vector3d vector;     ///< of the wave, radians a unit
  double phase = 0;
};

Eigen::Vector3d random_direction(Rng& rng) {
  Eigen::Vector3d direction;
  do {
    for (int k = 0; k < 3; ++k) direction[k] = normal(rng);
  } while (direction.norm() < 1e-3);
  return direction.normalized();
}

}  // namespace

Mesh varied_mesh(const Mesh& mesh, double variation, Rng rng) {
  if (variation == 0 || mesh.vertices_m.empty()) return mesh;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& vertex : mesh.vertices_m) middle += vertex;
  middle /= static_cast<double>(mesh.vertices_m.size());
  double radius = 0;
  for (const Eigen::Vector3d& vertex : mesh.vertices_m) radius += (vertex - middle).norm();
  radius /= static_cast<double>(mesh.vertices_m.size());

  Eigen::Vector3d factors;
  for (int k = 0; k < 3; ++k)
    factors[k] = std::exp(variation * std::clamp(normal(rng), -kMostSigmas, kMostSigmas));
  std::array<Wave, kWaves> waves;
  for (Wave& wave : waves) {
    const double length = radius * uniform(rng, 2, 4);
    wave.vector = 2 * std::numbers::pi / length * random_direction(rng);
    wave.direction = kWaveShare * variation * radius * random_direction(rng);
    wave.phase = uniform(rng, 0, 2 * std::numbers::pi);
  }
  Mesh varied = mesh;
  for (Eigen::Vector3d& vertex : varied.vertices_m) {
    const Eigen::Vector3d from_middle = vertex - middle;
    Eigen::Vector3d moved = from_middle.cwiseProduct(factors);
    for (const Wave& wave : waves)
      moved += std::sin(wave.vector.dot(from_middle) + wave.phase) * wave.direction;
    vertex = middle + moved;
  }
  return varied;
}

}  // namespace cousin
