#include "sim/render/ray_scene.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <unordered_map>

#include "sim/render/ray_scene_impl.h"

namespace cousin {
namespace {

struct Bounds {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector3d high = -low;
  void add(const Eigen::Vector3d& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  bool empty() const { return !(low.x() <= high.x()); }
};

/// Middle of the specimens, or of everything where there are none.
Eigen::Vector3d scene_centre(const Scene& scene, double time_s) {
  Bounds specimens, all;
  for (const Instance& instance : scene.instances) {
    const Pose pose = world_from_object(instance, time_s);
    for (const auto& v : scene.models[static_cast<std::size_t>(instance.model)].mesh.vertices_m) {
      const Eigen::Vector3d p = pose * v;
      all.add(p);
      if (instance.is_specimen) specimens.add(p);
    }
  }
  const Bounds& bounds = specimens.empty() ? all : specimens;
  if (bounds.empty()) return Eigen::Vector3d::Zero();
  return 0.5 * (bounds.low + bounds.high);
}

/// Whether some directed edge lacks its opposite.
bool has_boundary(const Mesh& mesh) {
  std::unordered_map<std::uint64_t, int> balance;
  balance.reserve(mesh.triangles.size() * 2);
  for (const auto& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      const std::uint64_t a = t[static_cast<std::size_t>(k)];
      const std::uint64_t b = t[static_cast<std::size_t>((k + 1) % 3)];
      balance[a < b ? (a << 32 | b) : (b << 32 | a)] += a < b ? 1 : -1;
    }
  }
  return std::any_of(balance.begin(), balance.end(),
                     [](const auto& edge) { return edge.second != 0; });
}

/// The printed face: all three corners on z = 0 of the object, facing +z.
bool on_printed_face(const Mesh& mesh, const std::array<std::uint32_t, 3>& t, double size_m) {
  for (const std::uint32_t v : t) {
    if (std::abs(mesh.vertices_m[v].z()) > 1e-9 * size_m) return false;
  }
  const Eigen::Vector3d a = mesh.vertices_m[t[0]];
  return (mesh.vertices_m[t[1]] - a).cross(mesh.vertices_m[t[2]] - a).z() > 0;
}

TrianglePlane make_plane(const std::array<Eigen::Vector3d, 3>& p,
                         const std::array<Eigen::Vector3f, 3>& f) {
  TrianglePlane plane{};
  const Eigen::Vector3d cross = (p[1] - p[0]).cross(p[2] - p[0]);
  const double length = cross.norm();
  const Eigen::Vector3d normal =
      length > 0 ? Eigen::Vector3d(cross / length) : Eigen::Vector3d::Zero();
  // The middle of the triangle: the rounding of the normal then acts over the shortest arm.
  const double distance = normal.dot((p[0] + p[1] + p[2]) / 3);
  float largest = 0;
  for (int k = 0; k < 3; ++k) {
    plane.normal[k] = normal[k];
    plane.low[k] = std::min({f[0][k], f[1][k], f[2][k]});
    plane.high[k] = std::max({f[0][k], f[1][k], f[2][k]});
    largest = std::max({largest, std::abs(plane.low[k]), std::abs(plane.high[k])});
  }
  plane.distance = distance;
  plane.offset_m = kOffsetUlps * largest;
  return plane;
}

RayGeometry make_geometry(const Scene& scene, std::size_t index, double time_s,
                          const Eigen::Vector3d& centre_m) {
  const Instance& instance = scene.instances[index];
  const ObjectModel& model = scene.models[static_cast<std::size_t>(instance.model)];
  const Material& material = scene.materials[static_cast<std::size_t>(instance.material)];
  const Pose pose = world_from_object(instance, time_s);
  RayGeometry geometry;
  geometry.instance_index = static_cast<int>(index);
  geometry.id = instance.id;
  geometry.is_specimen = instance.is_specimen;
  geometry.is_open = has_boundary(model.mesh);
  geometry.triangles = model.mesh.triangles;

  Bounds box;
  std::vector<Eigen::Vector3d> vertices(model.mesh.vertices_m.size());
  geometry.vertices_m.resize(vertices.size() + 1, Eigen::Vector3f::Zero());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    box.add(model.mesh.vertices_m[i]);
    vertices[i] = pose * model.mesh.vertices_m[i] - centre_m;
    geometry.vertices_m[i] = vertices[i].cast<float>();
  }
  if (vertices.empty()) box.add(Eigen::Vector3d::Zero());
  for (int k = 0; k < 8; ++k) {
    const Eigen::Vector3d corner((k & 1) ? box.high.x() : box.low.x(),
                                 (k & 2) ? box.high.y() : box.low.y(),
                                 (k & 4) ? box.high.z() : box.low.z());
    geometry.box_corners_m[static_cast<std::size_t>(k)] = pose * corner;
  }

  const double size_m = (box.high - box.low).norm();
  geometry.planes.resize(geometry.triangles.size());
  for (std::size_t i = 0; i < geometry.triangles.size(); ++i) {
    const auto& t = geometry.triangles[i];
    geometry.planes[i] = make_plane(
        {vertices[t[0]], vertices[t[1]], vertices[t[2]]},
        {geometry.vertices_m[t[0]], geometry.vertices_m[t[1]], geometry.vertices_m[t[2]]});
    geometry.planes[i].part = model.triangle_part.empty() ? 0 : model.triangle_part[i];
    geometry.planes[i].has_print = material.print && on_printed_face(model.mesh, t, size_m) ? 1 : 0;
  }
  return geometry;
}

RTCGeometry embree_geometry(RTCDevice device, const RayGeometry& geometry) {
  RTCGeometry g = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                             geometry.vertices_m.data(), 0, sizeof(Eigen::Vector3f),
                             geometry.vertices_m.size() - 1);
  rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                             geometry.triangles.data(), 0, 3 * sizeof(std::uint32_t),
                             geometry.triangles.size());
  rtcCommitGeometry(g);
  return g;
}

/// Built by one thread: Embree's parallel builder may order equal triangles by the number of
/// threads, and the triangle that wins a shared edge would then depend on it.
void commit_alone(RTCScene scene) {
  tbb::task_arena arena(1);
  arena.execute([&] { rtcCommitScene(scene); });
}

void check(RTCDevice device) {
  const RTCError error = rtcGetDeviceError(device);
  if (error != RTC_ERROR_NONE) {
    throw std::runtime_error("Embree failed with error " + std::to_string(static_cast<int>(error)));
  }
}

RTCScene new_robust_scene(RTCDevice device) {
  RTCScene scene = rtcNewScene(device);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
  return scene;
}

}  // namespace

RayScene::Impl::~Impl() {
  for (RayGeometry& geometry : geometries) {
    if (geometry.alone) rtcReleaseScene(geometry.alone);
  }
  if (scene) rtcReleaseScene(scene);
  if (device) rtcReleaseDevice(device);
}

RayScene::RayScene(const Scene& scene, double time_s) : impl_(std::make_unique<Impl>()) {
  validate(scene);
  Impl& impl = *impl_;
  impl.device = rtcNewDevice(nullptr);
  if (!impl.device) throw std::runtime_error("Embree: no device");
  impl.time_s = time_s;
  impl.centre_m = scene_centre(scene, time_s);
  impl.geometries.resize(scene.instances.size());
  tbb::parallel_for(std::size_t{0}, scene.instances.size(), [&](std::size_t i) {
    impl.geometries[i] = make_geometry(scene, i, time_s, impl.centre_m);
  });

  impl.scene = new_robust_scene(impl.device);
  for (std::size_t i = 0; i < impl.geometries.size(); ++i) {
    RayGeometry& geometry = impl.geometries[i];
    if (geometry.triangles.empty()) continue;
    RTCGeometry g = embree_geometry(impl.device, geometry);
    rtcAttachGeometryByID(impl.scene, g, static_cast<unsigned int>(i));
    if (geometry.is_specimen) {
      geometry.alone = new_robust_scene(impl.device);
      rtcAttachGeometryByID(geometry.alone, g, 0);
    }
    rtcReleaseGeometry(g);
  }
  // The whole scene and each specimen are built side by side, each by one thread.
  tbb::parallel_for(std::size_t{0}, impl.geometries.size() + 1, [&](std::size_t i) {
    if (i == 0) {
      commit_alone(impl.scene);
    } else if (impl.geometries[i - 1].alone) {
      commit_alone(impl.geometries[i - 1].alone);
    }
  });
  check(impl.device);
}

RayScene::~RayScene() = default;
RayScene::RayScene(RayScene&&) noexcept = default;
RayScene& RayScene::operator=(RayScene&&) noexcept = default;

}  // namespace cousin
