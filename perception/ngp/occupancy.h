#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace cousin::ngp {

/// The cubes that are modelled: the inner one of side_m about centre_in_world_m, and cubes of twice
/// the side each about it. Inner coordinates: (x - centre) / side, so the inner cube is -1/2..1/2.
struct NgpVolume {
  Eigen::Vector3d centre_in_world_m = Eigen::Vector3d::Zero();
  double side_m = 0;
  int cascades = 1;
  double reach() const {
    return 0.5 * static_cast<double>(1U << static_cast<unsigned>(cascades - 1));
  }
};

/// Which cells of each cube hold something, so that rays skip the rest.
struct Occupancy {
  int resolution = 64;               ///< cells along a side of each cube
  std::vector<float> thickness;      ///< optical, of one shortest step; -1 = no view sees it
  std::vector<std::uint8_t> filled;  ///< 0 or 1
  std::size_t cells_of_cube() const {
    const auto r = static_cast<std::size_t>(resolution);
    return r * r * r;
  }
};

struct MarchConfig {
  double shortest = 0.0034;  ///< step, inner coordinates
  double cone = 0;           ///< steps grow with the distance times this
  double near = 0.05;        ///< where rays begin
  int most = 1024;           ///< samples of a ray
};

struct RaySample {
  Eigen::Vector3f at;  ///< inner coordinates
  float distance = 0;  ///< from the camera, inner coordinates
  float length = 0;
};

/// Samples of a ray in filled cells, in order. @param jitter  0..1, share of the first step.
void march(const NgpVolume& volume, const Occupancy& occupancy, const MarchConfig& config,
           const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, float jitter,
           std::vector<RaySample>& samples);

/// Smallest cube that holds a point of inner coordinates, or cascades where none does.
int cube_of(const NgpVolume& volume, const Eigen::Vector3f& at);
/// Middle of a cell, inner coordinates.
Eigen::Vector3f cell_middle(const Occupancy& occupancy, std::size_t cell);
/// Side of a cell, inner coordinates.
float cell_side(const Occupancy& occupancy, std::size_t cell);

}  // namespace cousin::ngp
