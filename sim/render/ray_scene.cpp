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

#include "sim/render/ray_mesh.h"
#include "sim/render/ray_motion.h"
#include "sim/render/ray_scene_impl.h"
#include "sim/truth/specimens.h"

namespace cousin {
namespace {

/// More triangles than this keep no planes, and Embree's trees are compact.
constexpr std::size_t kManyTriangles = std::size_t{1} << 20;

struct Bounds {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector3d high = -low;
  void add(const Eigen::Vector3d& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  bool empty() const { return !(low.x() <= high.x()); }
};

/// What a scene's instances make of its models.
struct ModelUse {
  int instances = 0;
  bool has_print = false;
  double print_bend_m = 0;
  bool is_shared = false;  ///< kept once, in its own axes
  std::array<Eigen::Vector3d, 8> corners_m;
};

std::size_t used_triangles(const Scene& scene, const std::vector<ModelUse>& uses) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < uses.size(); ++i)
    count += uses[i].instances > 0 ? scene.models[i].mesh.triangles.size() : 0;
  return count;
}

std::vector<ModelUse> model_uses(const Scene& scene) {
  std::vector<ModelUse> uses(scene.models.size());
  for (const Instance& instance : scene.instances) {
    ModelUse& use = uses[static_cast<std::size_t>(instance.model)];
    ++use.instances;
    const Material& material = scene.materials[static_cast<std::size_t>(instance.material)];
    use.has_print |= material.print.has_value();
    if (material.print) use.print_bend_m = std::max(use.print_bend_m, material.print_bend_m);
  }
  tbb::parallel_for(std::size_t{0}, uses.size(),
                    [&](std::size_t i) { uses[i].corners_m = box_corners(scene.models[i].mesh); });
  // Among many triangles a specimen is kept once too: its tree alone serves the whole scene.
  const bool is_many = used_triangles(scene, uses) > kManyTriangles;
  for (const Instance& instance : scene.instances) {
    ModelUse& use = uses[static_cast<std::size_t>(instance.model)];
    use.is_shared |= use.instances > 1 || (is_many && is_of_specimen(instance));
  }
  return uses;
}

/// Middle of the specimens, or of everything where there are none. Of shared models the corners of
/// their boxes count.
Eigen::Vector3d scene_centre(const Scene& scene, const std::vector<ModelUse>& uses, double time_s) {
  Bounds specimens, all;
  for (const Instance& instance : scene.instances) {
    const Pose pose = world_from_object(instance, time_s);
    const auto add = [&](const Eigen::Vector3d& v) {
      const Eigen::Vector3d p = pose * v;
      all.add(p);
      if (is_of_specimen(instance)) specimens.add(p);
    };
    const auto model = static_cast<std::size_t>(instance.model);
    const auto& vertices = scene.models[model].mesh.vertices_m;
    if (uses[model].is_shared && !vertices.empty()) {
      std::for_each(uses[model].corners_m.begin(), uses[model].corners_m.end(), add);
    } else {
      std::for_each(vertices.begin(), vertices.end(), add);
    }
  }
  const Bounds& bounds = specimens.empty() ? all : specimens;
  if (bounds.empty()) return Eigen::Vector3d::Zero();
  return 0.5 * (bounds.low + bounds.high);
}

RayGeometry make_geometry(const Scene& scene, std::size_t index, const ModelUse& use,
                          const TimeSpan& span_s, const Eigen::Vector3d& centre_m) {
  const Instance& instance = scene.instances[index];
  RayGeometry geometry;
  geometry.instance_index = static_cast<int>(index);
  geometry.id = whole_id(instance);
  geometry.is_specimen = is_of_specimen(instance);
  geometry.has_print =
      scene.materials[static_cast<std::size_t>(instance.material)].print.has_value();
  geometry.box_corners_in_object_m = use.corners_m;
  double reach_m = 0;
  for (const Eigen::Vector3d& corner : use.corners_m) reach_m = std::max(reach_m, corner.norm());
  geometry.steps = motion_steps(instance, span_s, reach_m);
  for (Pose& pose : geometry.steps) pose.translation_m -= centre_m;
  geometry.is_instanced = use.is_shared || geometry.steps.size() > 1;
  return geometry;
}

/// One mesh for each model in use; `geometries` get their places. @returns the first geometry of
/// each: the only one where the mesh is laid out in the world.
std::vector<std::size_t> number_meshes(const Scene& scene, std::vector<RayGeometry>& geometries) {
  std::vector<std::size_t> first;
  constexpr std::uint32_t kNone = 0xFFFFFFFFU;
  std::vector<std::uint32_t> of_model(scene.models.size(), kNone);
  for (std::size_t i = 0; i < geometries.size(); ++i) {
    const auto model = static_cast<std::size_t>(scene.instances[i].model);
    if (of_model[model] == kNone) {
      of_model[model] = static_cast<std::uint32_t>(first.size());
      first.push_back(i);
    }
    geometries[i].mesh = of_model[model];
  }
  return first;
}

RTCGeometry triangle_geometry(RTCDevice device, const RayMesh& mesh) {
  RTCGeometry g = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                             mesh.vertices_m.data(), 0, sizeof(Eigen::Vector3f),
                             mesh.vertices_m.size() - 1);
  rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.triangles.data(),
                             0, 3 * sizeof(std::uint32_t), mesh.triangles.size());
  rtcCommitGeometry(g);
  return g;
}

/// An object's pose for its mesh, whose axes are shifted: the object's origin moves on straight
/// lines between steps, the mesh's on arcs.
RTCQuaternionDecomposition decomposition(const Pose& pose, const Eigen::Vector3d& shift_m) {
  RTCQuaternionDecomposition d;
  rtcInitQuaternionDecomposition(&d);
  const Eigen::Quaternionf q = pose.rotation.cast<float>();
  const Eigen::Vector3f t = pose.translation_m.cast<float>();
  rtcQuaternionDecompositionSetQuaternion(&d, q.w(), q.x(), q.y(), q.z());
  const Eigen::Vector3f s = shift_m.cast<float>();
  rtcQuaternionDecompositionSetTranslation(&d, t.x(), t.y(), t.z());
  rtcQuaternionDecompositionSetShift(&d, s.x(), s.y(), s.z());
  return d;
}

RTCGeometry instance_geometry(RTCDevice device, const RayScene::Impl& impl,
                              const RayGeometry& geometry) {
  RTCGeometry g = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(g, impl.mesh_of(geometry).alone);
  const std::size_t steps = geometry.steps.size();
  rtcSetGeometryTimeStepCount(g, static_cast<unsigned int>(steps));
  if (steps == 1) {
    const Pose pose = mesh_pose(impl, geometry, 0);
    Eigen::Matrix<float, 3, 4> matrix;  // column by column, as Embree takes it
    matrix << pose.rotation.toRotationMatrix().cast<float>(), pose.translation_m.cast<float>();
    rtcSetGeometryTransform(g, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, matrix.data());
  }
  for (std::size_t i = 0; steps > 1 && i < steps; ++i) {
    const RTCQuaternionDecomposition d =
        decomposition(geometry.steps[i], impl.mesh_of(geometry).centre_in_object_m);
    rtcSetGeometryTransformQuaternion(g, static_cast<unsigned int>(i), &d);
  }
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

RTCScene new_robust_scene(RTCDevice device, bool is_compact) {
  RTCScene scene = rtcNewScene(device);
  // Paths skip their own sheet by a filter of their context.
  const RTCSceneFlags flags = RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;
  rtcSetSceneFlags(scene, is_compact ? flags | RTC_SCENE_FLAG_COMPACT : flags);
  // High quality splits triangles between nodes, and may so keep them twice.
  rtcSetSceneBuildQuality(scene, is_compact ? RTC_BUILD_QUALITY_MEDIUM : RTC_BUILD_QUALITY_HIGH);
  return scene;
}

/// Embree's scenes: of each mesh that is wanted alone, and of everything.
void build_scenes(RayScene::Impl& impl, bool is_compact) {
  std::vector<bool> is_wanted(impl.meshes.size(), false);
  for (const RayGeometry& g : impl.geometries) {
    const bool has_triangles = !impl.mesh_of(g).triangles.empty();
    if (has_triangles && (g.is_instanced || g.is_specimen)) is_wanted[g.mesh] = true;
  }
  std::vector<RTCGeometry> triangles(impl.meshes.size(), nullptr);
  std::vector<bool> is_shared(impl.meshes.size(), false);
  for (const RayGeometry& g : impl.geometries) is_shared[g.mesh] = g.is_instanced;
  for (std::size_t i = 0; i < impl.meshes.size(); ++i) {
    if (impl.meshes[i].triangles.empty()) continue;
    triangles[i] = triangle_geometry(impl.device, impl.meshes[i]);
    if (!is_wanted[i]) continue;
    impl.meshes[i].alone = new_robust_scene(impl.device, is_compact);
    rtcAttachGeometryByID(impl.meshes[i].alone, triangles[i], 0);
  }
  // What the whole scene places comes first; the rest is built side by side, each by one thread.
  tbb::parallel_for(std::size_t{0}, impl.meshes.size(), [&](std::size_t i) {
    if (impl.meshes[i].alone && is_shared[i]) commit_alone(impl.meshes[i].alone);
  });
  impl.scene = new_robust_scene(impl.device, is_compact);
  for (std::size_t i = 0; i < impl.geometries.size(); ++i) {
    const RayGeometry& g = impl.geometries[i];
    if (!triangles[g.mesh]) continue;
    RTCGeometry attached =
        g.is_instanced ? instance_geometry(impl.device, impl, g) : triangles[g.mesh];
    rtcAttachGeometryByID(impl.scene, attached, static_cast<unsigned int>(i));
    if (g.is_instanced) rtcReleaseGeometry(attached);
  }
  for (RTCGeometry g : triangles) {
    if (g) rtcReleaseGeometry(g);
  }
  tbb::parallel_for(std::size_t{0}, impl.meshes.size() + 1, [&](std::size_t i) {
    if (i == 0) {
      commit_alone(impl.scene);
    } else if (impl.meshes[i - 1].alone && !is_shared[i - 1]) {
      commit_alone(impl.meshes[i - 1].alone);
    }
  });
}

}  // namespace

RayScene::Impl::~Impl() {
  if (scene) rtcReleaseScene(scene);
  for (RayMesh& mesh : meshes) {
    if (mesh.alone) rtcReleaseScene(mesh.alone);
  }
  if (device) rtcReleaseDevice(device);
}

RayScene::RayScene(const Scene& scene, double time_s) : RayScene(scene, TimeSpan{time_s, time_s}) {}

RayScene::RayScene(const Scene& scene, const TimeSpan& span_s) : impl_(std::make_unique<Impl>()) {
  validate(scene);
  if (!std::isfinite(span_s.begin_s) || !std::isfinite(span_s.end_s) ||
      span_s.end_s < span_s.begin_s) {
    throw std::invalid_argument("rays: the span of time from " + std::to_string(span_s.begin_s) +
                                " to " + std::to_string(span_s.end_s) + " s is not one");
  }
  Impl& impl = *impl_;
  impl.device = rtcNewDevice(nullptr);
  if (!impl.device) throw std::runtime_error("Embree: no device");
  impl.span_s = span_s;
  const std::vector<ModelUse> uses = model_uses(scene);
  impl.centre_m = scene_centre(scene, uses, span_s.begin_s);
  impl.geometries.resize(scene.instances.size());
  tbb::parallel_for(std::size_t{0}, scene.instances.size(), [&](std::size_t i) {
    const auto model = static_cast<std::size_t>(scene.instances[i].model);
    impl.geometries[i] = make_geometry(scene, i, uses[model], span_s, impl.centre_m);
  });
  const std::vector<std::size_t> first = number_meshes(scene, impl.geometries);
  const bool is_many = used_triangles(scene, uses) > kManyTriangles;
  impl.meshes.resize(first.size());
  tbb::parallel_for(std::size_t{0}, impl.meshes.size(), [&](std::size_t i) {
    const RayGeometry& g = impl.geometries[first[i]];
    const auto model =
        static_cast<std::size_t>(scene.instances[static_cast<std::size_t>(g.instance_index)].model);
    MeshPlacement placement;
    placement.is_instanced = g.is_instanced;
    placement.world_from_object = world_from_object(
        scene.instances[static_cast<std::size_t>(g.instance_index)], span_s.begin_s);
    placement.centre_m = impl.centre_m;
    placement.has_print = uses[model].has_print;
    placement.print_bend_m = uses[model].print_bend_m;
    placement.keeps_planes = !is_many;
    impl.meshes[i] = make_ray_mesh(scene.models[model], placement);
  });
  build_scenes(impl, is_many);
  check(impl.device);
}

RayScene::~RayScene() = default;
RayScene::RayScene(RayScene&&) noexcept = default;
RayScene& RayScene::operator=(RayScene&&) noexcept = default;

}  // namespace cousin
