#include "sim/render/path_skips.h"

#include "sim/render/ray_scene_impl.h"

namespace cousin {
namespace {

Eigen::Vector3f normal_of(const RayMesh& mesh, unsigned int triangle) {
  const TrianglePlane plane = triangle_plane(mesh, triangle);
  return Eigen::Vector3d(plane.normal[0], plane.normal[1], plane.normal[2]).cast<float>();
}

/// The triangle itself, or one that shares a corner with it and faces the same side: a ray that
/// crosses a sheet at an angle may meet its neighbour in place of itself.
bool is_of_sheet(const RayScene::Impl& rays, const Sheet& sheet, unsigned int instance,
                 unsigned int geometry, unsigned int triangle) {
  if (!sheet.exists() || instance != sheet.instance || geometry != sheet.geometry) return false;
  if (triangle == sheet.triangle) return true;
  const RayMesh& mesh = rays.mesh_of(rays.geometries[geometry_index(instance, geometry)]);
  for (const std::uint32_t a : mesh.triangles[sheet.triangle]) {
    for (const std::uint32_t b : mesh.triangles[triangle]) {
      if (a == b || mesh.vertices_m[a] == mesh.vertices_m[b])
        return normal_of(mesh, sheet.triangle).dot(normal_of(mesh, triangle)) > 0;
    }
  }
  return false;
}

void skip(const RTCFilterFunctionNArguments* args) {
  auto& context = *reinterpret_cast<SkipContext*>(args->context);
  for (unsigned int i = 0; i < args->N; ++i) {
    if (args->valid[i] != -1) continue;
    const unsigned int lane = RTCRayN_id(args->ray, args->N, i);
    const unsigned int instance = RTCHitN_instID(args->hit, args->N, i, 0);
    const unsigned int geometry = RTCHitN_geomID(args->hit, args->N, i);
    if (context.passes_water[lane] &&
        (*context.water)[geometry_index(instance, geometry)].material->kind == SurfaceKind::clear) {
      context.met_water[lane] = true;
      args->valid[i] = 0;
      continue;
    }
    const PathSkips* skips = context.lanes[lane];
    if (!skips || RTCRayN_tfar(args->ray, args->N, i) > skips->reach_m) continue;
    const unsigned int triangle = RTCHitN_primID(args->hit, args->N, i);
    if (is_of_sheet(*context.rays, skips->own, instance, geometry, triangle) ||
        is_of_sheet(*context.rays, skips->before, instance, geometry, triangle)) {
      args->valid[i] = 0;
    }
  }
}

}  // namespace

SkipContext make_skip_context(const RayScene::Impl& rays, RTCIntersectContextFlags flags) {
  SkipContext context;
  context.context = make_context(flags);
  context.rays = &rays;
  return context;
}

void use_skips(SkipContext& context, bool used) { context.context.filter = used ? skip : nullptr; }

}  // namespace cousin
