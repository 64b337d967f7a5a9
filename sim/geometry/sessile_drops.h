#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "sim/types/mesh.h"
#include "sim/types/rng.h"

namespace cousin {

/// Drops that sit on a surface. Free but for the angle: dew and spray differ.
struct SessileDropsConfig {
  int count = 20;                ///< asked for, at most 10000
  double radius_min_m = 0.0005;  ///< of the circle where a drop meets the surface, drawn evenly
  double radius_max_m = 0.0015;
  double contact_angle_rad = 1.4;  ///< inside the water, in [0.05, 2.8]; 0.2 = a film, 1.4 = wax
  double steepest_rad = 1.2;       ///< between up and the surface's normal; pi = also below
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();  ///< in the mesh's frame, of any length
  double sink_m = 0.0002;  ///< how deep the drop's hidden foot reaches below the surface
  int segments = 48;       ///< around a drop, 6..512; half as many from its rim to its top
};
/// @throws std::invalid_argument naming field, value and limit.
void validate(const SessileDropsConfig& config);

/// Drops in the frame of the mesh they sit on. Each is closed and a part of its own: a spherical
/// cap with the contact angle, whose rim follows the surface, and a foot below the surface, which
/// an opaque body hides, so that no air is left between.
struct SessileDrops {
  Mesh mesh;
  std::vector<Eigen::Vector3f> vertex_normals;  ///< of the spheres, for shading
  std::vector<std::uint16_t> triangle_part;
  std::vector<std::string> part_names;  ///< "drop 0", ...: as many as found a place
};

/// Places are drawn by area from triangles that face up enough; a drop that would touch another, or
/// whose rim leaves the surface or turns from it by more than half a right angle, is drawn again,
/// up to 50 times. A mesh without room gets fewer drops than asked for, or none. Foot and cap may
/// meet the surface anew where a body is thinner than a drop's foot is deep.
/// @param rng  drop i draws from rng.fork(i).
/// @throws std::invalid_argument for an invalid configuration or a mesh with an index out of range
/// or a vertex that is not finite.
SessileDrops sessile_drops(const Mesh& mesh, const SessileDropsConfig& config, const Rng& rng);

}  // namespace cousin
