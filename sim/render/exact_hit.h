#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>

#include "sim/render/ray_scene_impl.h"
#include "sim/render/truth_pass.h"

namespace cousin {

/// Private to sim/render: hits of camera rays in double precision, a row of one origin at a time.

/// The axes that a hit triangle's plane is in, as one row's rays see them.
struct RowFrame {
  std::uint32_t geometry = RTC_INVALID_GEOMETRY_ID;
  const RayMesh* mesh = nullptr;
  bool is_world = true;  ///< else the mesh's own axes:
  Eigen::Matrix3d mesh_from_world = Eigen::Matrix3d::Identity();
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();  ///< camera centre
  double reach_m = 0;  ///< sum of coordinates that the float ray was made of, for its rounding
};

inline RowFrame row_frame(const RayScene::Impl& impl, std::uint32_t geometry,
                          const PreparedRays::Row& row) {
  const RayGeometry& g = impl.geometries[geometry];
  RowFrame frame;
  frame.geometry = geometry;
  frame.mesh = &impl.mesh_of(g);
  frame.is_world = !g.is_instanced;
  frame.origin_m = row.origin_m;
  frame.reach_m = row.origin_m.lpNorm<1>();
  if (frame.is_world) return frame;
  const Pose pose = mesh_pose(impl, g, row.time);
  frame.mesh_from_world = pose.rotation.conjugate().toRotationMatrix();
  frame.origin_m = frame.mesh_from_world * (row.origin_m - pose.translation_m);
  frame.reach_m += pose.translation_m.lpNorm<1>() + frame.origin_m.lpNorm<1>();
  return frame;
}

/// The plane of a hit triangle as one row's rays meet it; neighbouring pixels often share it.
struct RowPlane {
  TrianglePlane plane;
  std::uint32_t geometry = RTC_INVALID_GEOMETRY_ID;
  std::uint32_t triangle = 0;
  double gap_m = 0;  ///< from the camera centre to the plane, along the normal
  Eigen::Vector3f normal_in_camera = Eigen::Vector3f::Zero();
};

inline RowPlane row_plane(const RowFrame& frame, std::uint32_t triangle,
                          const PreparedRays::Row& row) {
  const TrianglePlane plane = triangle_plane(*frame.mesh, triangle);
  const Eigen::Vector3d normal(plane.normal[0], plane.normal[1], plane.normal[2]);
  const Eigen::Vector3d in_world =
      frame.is_world ? normal : Eigen::Vector3d(frame.mesh_from_world.transpose() * normal);
  return {plane, frame.geometry, triangle, plane.distance - normal.dot(frame.origin_m),
          (row.camera_from_world * in_world).cast<float>()};
}

/// The hit in double: where the ray meets the triangle's plane.
struct ExactHit {
  bool accepted = false;
  double t_m = 0;
  double facing = 0;  ///< normal . direction
};

/// @param o, d  camera centre and direction in the plane's axes.
inline ExactHit exact_hit(const RowPlane& row_plane, const Eigen::Vector3d& o, double reach_m,
                          const Eigen::Vector3d& d) {
  const TrianglePlane& plane = row_plane.plane;
  const double facing = plane.normal[0] * d.x() + plane.normal[1] * d.y() + plane.normal[2] * d.z();
  const double inverse = 1 / facing;
  const double t = row_plane.gap_m * inverse;
  // In-plane slip of the float ray against the double one: a few ulps of the distances over the
  // cosine.
  const double slip = 8 * 0x1p-23 * (t + reach_m) * std::abs(inverse);
  const double px = o.x() + t * d.x(), py = o.y() + t * d.y(), pz = o.z() + t * d.z();
  const bool inside = (t > 0) & (px >= plane.low[0] - slip) & (px <= plane.high[0] + slip) &
                      (py >= plane.low[1] - slip) & (py <= plane.high[1] + slip) &
                      (pz >= plane.low[2] - slip) & (pz <= plane.high[2] + slip);
  return {inside, t, facing};
}

}  // namespace cousin
