#include "sim/truth/scene.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <string>

#include "sim/truth/truth_images.h"

namespace cousin {

Pose world_from_object(const Instance& instance, double time_s) {
  const auto& motion = instance.motion;
  if (motion.empty()) return instance.world_from_object;
  if (time_s <= motion.front().time_s) return motion.front().world_from_object;
  if (time_s >= motion.back().time_s) return motion.back().world_from_object;
  const auto after = std::upper_bound(motion.begin(), motion.end(), time_s,
                                      [](double t, const TimedPose& p) { return t < p.time_s; });
  const auto before = after - 1;
  const double fraction = (time_s - before->time_s) / (after->time_s - before->time_s);
  return interpolate(before->world_from_object, after->world_from_object, fraction);
}

Mesh mesh_in_world(const Scene& scene, const Instance& instance, double time_s) {
  Mesh mesh = scene.models.at(static_cast<std::size_t>(instance.model)).mesh;
  const Pose pose = world_from_object(instance, time_s);
  for (Eigen::Vector3d& vertex : mesh.vertices_m) vertex = pose * vertex;
  return mesh;
}

Pose pose_at_row(const TrueView& view, double y) {
  // A global shutter with an exposure: all rows see the middle of the way.
  if (view.exposure_s > 0 && !(view.readout_s > 0)) return pose_in_exposure(view, y, 0.5);
  const double last = view.camera.height_px - 1;
  if (last <= 0) return view.camera_from_world;
  return interpolate(view.camera_from_world, view.camera_from_world_end, y / last);
}

Pose pose_in_exposure(const TrueView& view, double y, double share) {
  const double last = view.camera.height_px - 1;
  const double offset = share - 0.5;
  double fraction = last > 0 ? y / last : 0;
  if (view.readout_s > 0) {
    fraction += offset * view.exposure_s / view.readout_s;
  } else if (view.exposure_s > 0) {
    fraction = share;
  }
  return interpolate(view.camera_from_world, view.camera_from_world_end, fraction);
}

double time_in_exposure_s(const TrueView& view, double y, double share) {
  const double last = view.camera.height_px - 1;
  return view.time_s + (last > 0 ? y / last : 0) * view.readout_s + (share - 0.5) * view.exposure_s;
}

double time_at_row(const TrueView& view, double y) {
  const double last = view.camera.height_px - 1;
  return last > 0 ? view.time_s + view.readout_s * y / last : view.time_s;
}

void validate(const Scene& scene) {
  for (const ObjectModel& model : scene.models) {
    const auto fail = [&](const char* what) {
      throw std::invalid_argument("scene \"" + scene.name + "\", model \"" + model.name +
                                  "\": " + what);
    };
    const std::size_t vertices = model.mesh.vertices_m.size();
    const std::size_t triangles = model.mesh.triangles.size();
    for (std::size_t i = 0; i < vertices; ++i) {
      if (!model.mesh.vertices_m[i].allFinite())
        fail(("vertex " + std::to_string(i) + " is not finite").c_str());
    }
    for (const auto& triangle : model.mesh.triangles) {
      for (const std::uint32_t index : triangle) {
        if (index >= vertices) fail("a triangle's index is beyond the vertices");
      }
    }
    if (!model.vertex_albedo.empty() && model.vertex_albedo.size() != vertices) {
      fail("vertex_albedo has another size than the vertices");
    }
    if (!model.vertex_normals.empty() && model.vertex_normals.size() != vertices) {
      fail("vertex_normals has another size than the vertices");
    }
    if (!model.triangle_part.empty() && model.triangle_part.size() != triangles) {
      fail("triangle_part has another size than the triangles");
    }
  }
  std::set<int> ids;
  for (const Instance& instance : scene.instances) {
    const auto fail = [&](const char* what) {
      throw std::invalid_argument("scene \"" + scene.name + "\", instance \"" + instance.name +
                                  "\": " + what);
    };
    if (instance.id < 0 || !ids.insert(instance.id).second)
      fail("its id is negative or not unique");
    if (instance.model < 0 || instance.model >= static_cast<int>(scene.models.size()))
      fail("no such model");
    if (instance.material < 0 || instance.material >= static_cast<int>(scene.materials.size())) {
      fail("no such material");
    }
    const auto check_pose = [&](const Pose& pose, const char* not_finite, const char* not_unit) {
      if (!pose.translation_m.allFinite() || !pose.rotation.coeffs().allFinite()) fail(not_finite);
      if (!(std::abs(pose.rotation.norm() - 1) <= 1e-6)) fail(not_unit);
    };
    check_pose(instance.world_from_object, "its pose is not finite",
               "its pose's rotation is not of unit norm within 1e-6");
    for (std::size_t i = 0; i < instance.motion.size(); ++i) {
      const TimedPose& step = instance.motion[i];
      check_pose(step.world_from_object, "a pose of its motion is not finite",
                 "a rotation of its motion is not of unit norm within 1e-6");
      if (!std::isfinite(step.time_s) || (i > 0 && !(step.time_s > instance.motion[i - 1].time_s)))
        fail("its motion is not sorted by finite times");
    }
  }
}

}  // namespace cousin
