#include "sim/render/path_scene.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <stdexcept>

#include "sim/render/sample_points.h"

namespace cousin {
namespace {

using Eigen::Vector3f;

Vector3f albedo_at(const PathTracer::Impl& impl, std::uint32_t geometry, std::uint32_t triangle,
                   float u, float v, const Vector3f& position_m, bool is_back) {
  const PathInstance& instance = impl.instances[geometry];
  const PathMaterial& m = *instance.material;
  const RayGeometry& g = impl.rays->geometries[geometry];
  Vector3f albedo = is_back ? m.back_albedo : m.albedo;
  if (!instance.model->vertex_albedo.empty()) {
    const auto& t = g.triangles[triangle];
    const auto& a = instance.model->vertex_albedo;
    albedo = albedo.cwiseProduct(interpolate(a[t[0]], a[t[1]], a[t[2]], u, v));
  }
  if (!m.noise && !m.print) return albedo;
  const Vector3f p = instance.object_from_world * position_m + instance.object_origin_m;
  if (m.noise) {
    const Vector3f other(m.noise->other_albedo.r, m.noise->other_albedo.g, m.noise->other_albedo.b);
    albedo += noise_at(*m.noise, p) * (other - albedo);
  }
  if (m.print && g.planes[triangle].has_print &&
      is_black(*m.print, static_cast<double>(p.x()), static_cast<double>(p.y()))) {
    albedo = m.ink_albedo;
  }
  return albedo;
}

}  // namespace

PathHit PathTracer::Impl::hit(std::uint32_t geometry, std::uint32_t triangle, float u, float v,
                              const Vector3f& direction) const {
  const PathInstance& instance = instances[geometry];
  const RayGeometry& g = rays->geometries[geometry];
  const TrianglePlane& plane = g.planes[triangle];
  const auto& t = g.triangles[triangle];
  PathHit hit;
  hit.position_m = interpolate(g.vertices_m[t[0]], g.vertices_m[t[1]], g.vertices_m[t[2]], u, v);
  const Vector3f normal(static_cast<float>(plane.normal[0]), static_cast<float>(plane.normal[1]),
                        static_cast<float>(plane.normal[2]));
  const bool is_back = normal.dot(direction) > 0;
  hit.face_normal = is_back ? Vector3f(-normal) : normal;
  hit.offset_m = plane.offset_m;

  Vector3f shading = hit.face_normal;
  if (!instance.model->vertex_normals.empty()) {
    const auto& n = instance.model->vertex_normals;
    const Vector3f smooth =
        instance.object_from_world.transpose() * interpolate(n[t[0]], n[t[1]], n[t[2]], u, v);
    const float length = smooth.norm();
    if (length > 1e-6F) shading = smooth / (smooth.dot(hit.face_normal) < 0 ? -length : length);
    // At the outline a shading normal may turn away from the ray: it is turned back to the edge of
    // what can be seen.
    const float facing = -shading.dot(direction);
    if (facing < 1e-3F) shading = (shading - (1e-3F - facing) * direction).normalized();
  }
  hit.frame = frame_about(shading);
  hit.bsdf.material = instance.material;
  hit.bsdf.out = hit.frame.transpose() * -direction;
  hit.bsdf.out.z() = std::max(hit.bsdf.out.z(), 1e-4F);
  const SurfaceKind kind = instance.material->kind;
  hit.bsdf.is_inside = is_back && kind == SurfaceKind::glass;
  hit.is_dark =
      is_back && !instance.is_open && kind != SurfaceKind::glass && kind != SurfaceKind::leaf;
  hit.bsdf.albedo = albedo_at(*this, geometry, triangle, u, v, hit.position_m, is_back);
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
  for (const Material& material : scene.materials) impl.materials.emplace_back(material);
  impl.models.reserve(scene.models.size());
  for (const ObjectModel& model : scene.models) {
    PathModel& m = impl.models.emplace_back();
    for (const Rgbf& c : model.vertex_albedo) m.vertex_albedo.emplace_back(c.r, c.g, c.b);
    m.vertex_normals = model.vertex_normals;
  }
  for (std::size_t i = 0; i < scene.instances.size(); ++i) {
    const Instance& instance = scene.instances[i];
    const Pose object_from_world = inverse(world_from_object(instance, impl.rays->time_s));
    PathInstance& p = impl.instances.emplace_back();
    p.material = &impl.materials[static_cast<std::size_t>(instance.material)];
    p.model = &impl.models[static_cast<std::size_t>(instance.model)];
    p.object_from_world = object_from_world.rotation.toRotationMatrix().cast<float>();
    p.object_origin_m = (object_from_world * impl.rays->centre_m).cast<float>();
    p.is_open = impl.rays->geometries[i].is_open;
  }
}

PathTracer::~PathTracer() = default;
PathTracer::PathTracer(PathTracer&&) noexcept = default;

}  // namespace cousin
