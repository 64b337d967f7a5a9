#include "sim/render/path_scene.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <stdexcept>

#include "sim/render/sample_points.h"
#include "sim/render/value_noise.h"

namespace cousin {
namespace {

using Eigen::Vector3f;

struct Placement {
  Eigen::Matrix3f world_from_object;
  Vector3f origin_m;
};

Placement placement_at(const PathTracer::Impl& impl, const SurfacePoint& point, float time) {
  const PathInstance& instance = impl.instances[point.geometry];
  if (!instance.moves) return {instance.world_from_object, instance.origin_m};
  const Pose pose = object_pose(impl.rays->geometries[point.geometry], time);
  return {pose.rotation.toRotationMatrix().cast<float>(), pose.translation_m.cast<float>()};
}

const PathMaterial& material_at(const PathInstance& instance, const SurfacePoint& point) {
  return instance.part_materials.empty() ? *instance.material
                                         : *instance.part_materials[point.part];
}

Vector3f albedo_at(const PathInstance& instance, const PathMaterial& m, const SurfacePoint& point,
                   const Placement& placement) {
  Vector3f albedo = point.is_back ? m.back_albedo : m.albedo;
  if (!instance.model->vertex_albedo.empty()) {
    const auto& a = instance.model->vertex_albedo;
    const auto& t = point.vertices;
    albedo = albedo.cwiseProduct(interpolate(a[t[0]], a[t[1]], a[t[2]], point.u, point.v));
  }
  if (!m.noise && !m.print) return albedo;
  const Vector3f p =
      placement.world_from_object.transpose() * (point.position_m - placement.origin_m);
  if (m.noise) {
    const Vector3f other(m.noise->other_albedo.r, m.noise->other_albedo.g, m.noise->other_albedo.b);
    const float share = value_noise(p / static_cast<float>(m.noise->scale_m), m.noise->octaves);
    albedo += share * (other - albedo);
  }
  if (m.print && point.has_print &&
      is_black(*m.print, static_cast<double>(p.x()), static_cast<double>(p.y()))) {
    albedo = m.ink_albedo;
  }
  return albedo;
}

Vector3f shading_normal(const PathInstance& instance, const SurfacePoint& point,
                        const Placement& placement, const Vector3f& direction) {
  const auto& n = instance.model->vertex_normals;
  if (n.empty()) return point.face_normal;
  const auto& t = point.vertices;
  const Vector3f smooth =
      placement.world_from_object * interpolate(n[t[0]], n[t[1]], n[t[2]], point.u, point.v);
  const float length = smooth.norm();
  if (!(length > 1e-6F)) return point.face_normal;
  const Vector3f shading = smooth / (smooth.dot(point.face_normal) < 0 ? -length : length);
  // At the outline a shading normal may turn away from the ray: it is turned back to the edge of
  // what can be seen.
  const float facing = -shading.dot(direction);
  if (facing >= 1e-3F) return shading;
  return (shading - (1e-3F - facing) * direction).normalized();
}

}  // namespace

PathHit PathTracer::Impl::hit(unsigned int inst_id, unsigned int geom_id, unsigned int prim_id,
                              float u, float v, const Vector3f& direction, float time) const {
  const SurfacePoint point = surface_point(*rays, inst_id, geom_id, prim_id, u, v, direction, time);
  const PathInstance& instance = instances[point.geometry];
  const Placement placement = placement_at(*this, point, time);
  PathHit hit;
  hit.position_m = point.position_m;
  hit.face_normal = point.face_normal;
  hit.offset_m = point.offset_m;
  hit.frame = frame_about(shading_normal(instance, point, placement, direction));
  const PathMaterial& material = material_at(instance, point);
  hit.bsdf.material = &material;
  hit.bsdf.out = hit.frame.transpose() * -direction;
  hit.bsdf.out.z() = std::max(hit.bsdf.out.z(), 1e-4F);
  const SurfaceKind kind = material.kind;
  const bool is_glass = kind == SurfaceKind::glass || kind == SurfaceKind::clear;
  hit.bsdf.is_inside = point.is_back && is_glass;
  hit.is_dark = point.is_back && !instance.is_open && !is_glass && kind != SurfaceKind::leaf;
  hit.bsdf.albedo = albedo_at(instance, material, point, placement);
  return hit;
}

PathTracer::PathTracer(const RayScene& rays, const Scene& scene) : impl_(std::make_unique<Impl>()) {
  Impl& impl = *impl_;
  impl.rays = &rays.impl();
  if (scene.instances.size() != impl.rays->geometries.size()) {
    throw std::invalid_argument("path tracer: scene \"" + scene.name + "\" is not of these rays");
  }
  impl.lights = make_lights(scene, impl.rays->centre_m);
  impl.materials.reserve(scene.materials.size());
  for (const Material& material : scene.materials) {
    impl.materials.emplace_back(material);
    impl.has_water |= material.kind == SurfaceKind::clear;
  }
  impl.models.reserve(scene.models.size());
  for (const ObjectModel& model : scene.models) {
    PathModel& m = impl.models.emplace_back();
    for (const Rgbf& c : model.vertex_albedo) m.vertex_albedo.emplace_back(c.r, c.g, c.b);
    m.vertex_normals = model.vertex_normals;
  }
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    const RayGeometry& geometry = impl.rays->geometries[i];
    const Pose pose = object_pose(geometry, 0);
    PathInstance& p = impl.instances.emplace_back();
    p.material = &impl.materials[static_cast<std::size_t>(instance.material)];
    for (const int part : instance.part_materials)
      p.part_materials.push_back(&impl.materials[static_cast<std::size_t>(part)]);
    p.model = &impl.models[static_cast<std::size_t>(instance.model)];
    p.is_open = impl.rays->mesh_of(geometry).is_open;
    p.moves = geometry.steps.size() > 1;
    p.world_from_object = pose.rotation.toRotationMatrix().cast<float>();
    p.origin_m = pose.translation_m.cast<float>();
    const auto& corners = geometry.box_corners_in_object_m;
    p.size_m = static_cast<float>((corners[7] - corners[0]).norm());
    const auto is_flesh = [](const PathMaterial* m) { return m->mean_free_path_m.maxCoeff() > 0; };
    const bool has_flesh = is_flesh(p.material) ||
                           std::any_of(p.part_materials.begin(), p.part_materials.end(), is_flesh);
    if (p.is_open && has_flesh) {
      throw std::invalid_argument("path tracer: instance \"" + instance.name +
                                  "\" has a mean_free_path_m and is not closed");
    }
  }
}

PathTracer::~PathTracer() = default;
PathTracer::PathTracer(PathTracer&&) noexcept = default;

}  // namespace cousin
