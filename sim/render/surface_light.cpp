#include "sim/render/surface_light.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "sim/render/idle_lanes.h"
#include "sim/render/sample_points.h"
#include "sim/types/pi.h"

namespace cousin {
namespace {}  // namespace

SurfaceHit surface_hit(const IrradianceCache::Impl& cache, std::uint32_t geometry,
                       std::uint32_t triangle, float u, float v, const Eigen::Vector3f& direction) {
  SurfaceHit hit;
  hit.surface = &cache.surfaces[geometry];
  const RayMesh& g = *hit.surface->mesh;
  hit.plane = &g.planes[triangle];
  hit.triangle = triangle;
  hit.u = u;
  hit.v = v;
  const auto& t = g.triangles[triangle];
  hit.position_m = interpolate<Eigen::Vector3d>(g.vertices_m[t[0]].cast<double>(),
                                                g.vertices_m[t[1]].cast<double>(),
                                                g.vertices_m[t[2]].cast<double>(),
                                                static_cast<double>(u), static_cast<double>(v))
                       .cast<float>();
  const Eigen::Vector3f normal(static_cast<float>(hit.plane->normal[0]),
                               static_cast<float>(hit.plane->normal[1]),
                               static_cast<float>(hit.plane->normal[2]));
  hit.is_back = normal.dot(direction) > 0;
  hit.face_normal = hit.is_back ? Eigen::Vector3f(-normal) : normal;
  return hit;
}

Eigen::Vector3f shading_normal(const SurfaceHit& hit) {
  const auto& normals = hit.surface->vertex_normals;
  if (normals.empty()) return hit.face_normal;
  const auto& t = hit.surface->mesh->triangles[hit.triangle];
  const Eigen::Vector3f n =
      interpolate(normals[t[0]], normals[t[1]], normals[t[2]], hit.u, hit.v).normalized();
  return n.dot(hit.face_normal) >= 0 ? n : Eigen::Vector3f(-n);
}

SurfaceAlbedo albedo_at(const SurfaceHit& hit) {
  const LitSurface& s = *hit.surface;
  SurfaceAlbedo result{s.albedo, false};
  if (!s.vertex_albedo.empty()) {
    const auto& t = s.mesh->triangles[hit.triangle];
    result.albedo = interpolate(s.vertex_albedo[t[0]], s.vertex_albedo[t[1]], s.vertex_albedo[t[2]],
                                hit.u, hit.v);
  }
  if (hit.plane->has_print) {
    const Eigen::Vector3f p = s.object_from_world * hit.position_m + s.object_origin_m;
    result.is_ink = is_black(*s.print, static_cast<double>(p.x()), static_cast<double>(p.y()));
    if (result.is_ink) result.albedo = s.ink_albedo;
  }
  return result;
}

Eigen::Vector3f cached_irradiance(const IrradianceCache::Impl& cache, const SurfaceHit& hit) {
  const LitSurface& s = *hit.surface;
  if (hit.is_back && s.back_points == 0) return Eigen::Vector3f::Zero();
  const Eigen::Vector3f* points = cache.irradiance.data() + (hit.is_back ? s.back_points : 0);
  const CacheLattice lattice = s.lattices[hit.triangle];
  if (lattice.order == 0) {
    const auto& t = s.mesh->triangles[hit.triangle];
    points += s.first_point;
    return interpolate(points[t[0]], points[t[1]], points[t[2]], hit.u, hit.v);
  }
  const int n = static_cast<int>(lattice.order);
  points += lattice.first;
  const float x = hit.u * static_cast<float>(n), y = hit.v * static_cast<float>(n);
  const int i = std::clamp(static_cast<int>(x), 0, n - 1);
  const int j = std::clamp(static_cast<int>(y), 0, n - 1 - i);
  const float fx = x - static_cast<float>(i), fy = y - static_cast<float>(j);
  const Eigen::Vector3f* row = points + j * (2 * n + 3 - j) / 2 + i;
  const Eigen::Vector3f* above = row + (n + 1 - j);
  if (fx + fy <= 1 || i + j == n - 1) return interpolate(row[0], row[1], above[0], fx, fy);
  return interpolate(above[1], above[0], row[1], 1 - fx, 1 - fy);
}

SecondaryLight secondary_light(const IrradianceCache::Impl& cache, const SurfaceHit& hit,
                               const Eigen::Vector3f& direction) {
  SecondaryLight light;
  light.normal = shading_normal(hit);
  const float reflected = hit.surface->coat.reflected(-light.normal.dot(direction));
  const Eigen::Vector3f albedo = albedo_at(hit).albedo;
  light.per_irradiance =
      kInversePiF * ((1 - reflected) * albedo + Eigen::Vector3f::Constant(reflected));
  light.radiance = light.per_irradiance.cwiseProduct(cached_irradiance(cache, hit));
  return light;
}

void add_suns(const IrradianceCache::Impl& cache, SecondaryPacket& packet) {
  RTCIntersectContext context = make_context(RTC_INTERSECT_CONTEXT_FLAG_COHERENT);
  for (std::size_t k = 0; k < cache.lights.suns.size(); ++k) {
    const auto& sun = cache.lights.suns[k];
    ShadowPacket shadow;
    LaneMask mask;
    float cosine[kLanes];
    for (int i = 0; i < kLanes; ++i) {
      mask.lane[i] = 0;
      if (!packet.mask.lane[i]) continue;
      const SurfaceHit& hit = packet.hit[i];
      if (hit.is_back && hit.surface->back_points == 0) continue;
      const Eigen::Vector3f d = draw_sun(sun, unit_pair(hash64(packet.hash[i] + k)));
      cosine[i] = packet.light[i].normal.dot(d);
      if (cosine[i] <= 0 || hit.face_normal.dot(d) <= 0) continue;
      const Eigen::Vector3f o = leave(hit, d);
      set_ray(shadow, i, o.x(), o.y(), o.z(), d.x(), d.y(), d.z());
      mask.lane[i] = -1;
    }
    idle_lanes(mask, shadow);
    find_occluded(mask, cache.rays->scene, context, shadow);
    for (int i = 0; i < kLanes; ++i) {
      if (!mask.lane[i] || shadow.tfar[i] < 0) continue;
      const float entering = packet.hit[i].surface->coat.entering(cosine[i]);
      packet.light[i].radiance +=
          cosine[i] * entering * packet.light[i].per_irradiance.cwiseProduct(sun.irradiance);
    }
  }
}

}  // namespace cousin
