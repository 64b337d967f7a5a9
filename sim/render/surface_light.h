#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "sim/render/coat.h"
#include "sim/render/radiance_pass.h"
#include "sim/render/ray_scene_impl.h"
#include "sim/render/scene_lights.h"

namespace cousin {

/// Cache points of one triangle: a triangular lattice of `order` cells along each edge. Point (i,
/// j), i + j <= order, lies at barycentric (i, j) / order and has index first + j (2 order + 3 - j)
/// / 2 + i. Order 0: the triangle shares its vertices' points.
struct CacheLattice {
  std::uint32_t first = 0;
  std::uint32_t order = 0;
};

/// A geometry with what light needs of it. Private to sim/render.
struct LitSurface {
  const RayMesh* mesh = nullptr;
  bool is_specimen = false;
  Coat coat{1, 1};
  Eigen::Vector3f albedo, ink_albedo;
  std::vector<Eigen::Vector3f> vertex_albedo;   ///< times `albedo`; or empty
  std::vector<Eigen::Vector3f> vertex_normals;  ///< in the world; or empty = flat
  std::optional<SeedBoard> print;
  Eigen::Matrix3f object_from_world;  ///< rotation, then translation, for the print
  Eigen::Vector3f object_origin_m;
  std::vector<CacheLattice> lattices;  ///< one a triangle
  std::uint32_t first_point = 0;       ///< of the vertices
  std::uint32_t back_points = 0;  ///< the back's point of point i is i + back_points; 0 = no back
};

/// A point where a ray met a surface.
struct SurfaceHit {
  const LitSurface* surface = nullptr;
  const TrianglePlane* plane = nullptr;
  std::uint32_t triangle = 0;
  float u = 0, v = 0;  ///< barycentric weights of the second and third vertex
  Eigen::Vector3f position_m;
  Eigen::Vector3f face_normal;  ///< unit, towards where the ray came from
  bool is_back = false;         ///< met on the clockwise side
};

struct IrradianceCache::Impl {
  const RayScene::Impl* rays = nullptr;
  SceneLights lights;
  std::vector<LitSurface> surfaces;  ///< index = geomID
  /// Integral over the hemisphere of radiance * cosine * Coat::entering, without suns, for each
  /// point.
  std::vector<Eigen::Vector3f> irradiance;
};

SurfaceHit surface_hit(const IrradianceCache::Impl& cache, std::uint32_t geometry,
                       std::uint32_t triangle, float u, float v, const Eigen::Vector3f& direction);

/// Where a ray that leaves the hit along `direction` starts, clear of rounding.
inline Eigen::Vector3f leave(const SurfaceHit& hit, const Eigen::Vector3f& direction) {
  return offset_origin(hit.position_m, hit.face_normal, hit.plane->offset_m, direction);
}

/// Unit normal for shading, on the side of the face normal.
Eigen::Vector3f shading_normal(const SurfaceHit& hit);

struct SurfaceAlbedo {
  Eigen::Vector3f albedo;
  bool is_ink = false;
};
SurfaceAlbedo albedo_at(const SurfaceHit& hit);

/// Cached irradiance at a hit; zero on the back of a closed surface.
Eigen::Vector3f cached_irradiance(const IrradianceCache::Impl& cache, const SurfaceHit& hit);

/// Radiance that leaves a hit against `direction`, by lamps and sky, and the factor that turns a
/// sun's irradiance * cosine * entering into radiance. The coat's reflection is taken as diffuse
/// here: energy is kept, its direction is not. For surfaces seen by reflection and for the cache's
/// own bounces.
struct SecondaryLight {
  Eigen::Vector3f radiance;
  Eigen::Vector3f per_irradiance;
  Eigen::Vector3f normal;
};
SecondaryLight secondary_light(const IrradianceCache::Impl& cache, const SurfaceHit& hit,
                               const Eigen::Vector3f& direction);

/// Adds the suns to radiance[i] of lanes with mask -1: one ray to a point of each sun's disk a
/// lane.
struct SecondaryPacket {
  LaneMask mask;
  SurfaceHit hit[kLanes];
  SecondaryLight light[kLanes];
  std::uint64_t hash[kLanes];
};
void add_suns(const IrradianceCache::Impl& cache, SecondaryPacket& packet);

}  // namespace cousin
