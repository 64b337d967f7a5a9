#include <Eigen/Geometry>
#include <algorithm>

#include "sim/render/ray_motion.h"
#include "sim/render/ray_scene_impl.h"

namespace cousin {

float ray_time(const RayScene::Impl& impl, double time_s) {
  const double length_s = impl.span_s.end_s - impl.span_s.begin_s;
  if (!(length_s > 0)) return 0;
  return static_cast<float>(std::clamp((time_s - impl.span_s.begin_s) / length_s, 0.0, 1.0));
}

Pose object_pose(const RayGeometry& geometry, float time) {
  return pose_between(geometry.steps, static_cast<double>(time));
}

Pose mesh_pose(const RayScene::Impl& impl, const RayGeometry& geometry, float time) {
  Pose pose = object_pose(geometry, time);
  pose.translation_m += pose.rotation * impl.mesh_of(geometry).centre_in_object_m;
  return pose;
}

SurfacePoint surface_point(const RayScene::Impl& impl, unsigned int inst_id, unsigned int geom_id,
                           unsigned int prim_id, float u, float v, const Eigen::Vector3f& direction,
                           float time) {
  SurfacePoint point;
  point.geometry = geometry_index(inst_id, geom_id);
  const RayGeometry& geometry = impl.geometries[point.geometry];
  const RayMesh& mesh = impl.mesh_of(geometry);
  const TrianglePlane plane = triangle_plane(mesh, prim_id);
  point.triangle = prim_id;
  point.vertices = mesh.triangles[prim_id];
  point.u = u;
  point.v = v;
  point.part = plane.part;
  point.has_print = plane.has_print && geometry.has_print;
  const auto& t = point.vertices;
  Eigen::Vector3d position_m = interpolate<Eigen::Vector3d>(
      mesh.vertices_m[t[0]].cast<double>(), mesh.vertices_m[t[1]].cast<double>(),
      mesh.vertices_m[t[2]].cast<double>(), static_cast<double>(u), static_cast<double>(v));
  Eigen::Vector3f normal(static_cast<float>(plane.normal[0]), static_cast<float>(plane.normal[1]),
                         static_cast<float>(plane.normal[2]));
  point.offset_m = plane.offset_m;
  if (geometry.is_instanced) {
    const Pose pose = mesh_pose(impl, geometry, time);
    const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix();
    position_m = rotation * position_m + pose.translation_m;
    normal = rotation.cast<float>() * normal;
    point.offset_m += kInstanceUlps * static_cast<float>(position_m.cwiseAbs().maxCoeff() +
                                                         pose.translation_m.cwiseAbs().maxCoeff());
  }
  point.position_m = position_m.cast<float>();
  point.is_back = normal.dot(direction) > 0;
  point.face_normal = point.is_back ? Eigen::Vector3f(-normal) : normal;
  return point;
}

}  // namespace cousin
