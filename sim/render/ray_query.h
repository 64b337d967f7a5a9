#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "sim/render/ray_scene.h"
#include "sim/render/truth_pass.h"

namespace cousin {

/// Single rays, for studies of robustness; images are made by the passes.
struct RayAnswer {
  bool hit = false;
  int instance = -1;  ///< Instance::id
  std::uint32_t triangle = 0;
  bool is_back = false;  ///< met on the clockwise side
  double distance_m = 0;
  Eigen::Vector3d normal =
      Eigen::Vector3d::Zero();  ///< of the face, towards where the ray came from
  // Where the hit lies: barycentric weights of the second and third vertex, and the geometry.
  float u = 0, v = 0;
  std::uint32_t geometry = 0;
  float time = 0;  ///< the ray's, as a share of the RayScene's span
};

/// First surface along a ray from anywhere. @param direction  unit, in the world.
/// @param time_s  held at the ends of the RayScene's span.
RayAnswer cast_ray(const RayScene& rays, const Eigen::Vector3d& origin_in_world_m,
                   const Eigen::Vector3d& direction, double time_s = 0);

/// First surface along a ray that leaves a surface: it starts off the hit by the rounding there, on
/// the side that it leaves to and at its time, as shadow and bounce rays do.
RayAnswer cast_from(const RayScene& rays, const RayAnswer& hit, const Eigen::Vector3d& direction);

/// Casts all prepared rays with Embree's packets and nothing else: the yardstick of the truth pass.
/// @returns how many hit something.
std::int64_t cast_packets(const RayScene& rays, const PreparedRays& prepared);

}  // namespace cousin
