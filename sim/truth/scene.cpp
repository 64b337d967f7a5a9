#include "sim/truth/scene.h"

#include <algorithm>
#include <cmath>

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

double seen_area_m2(const std::vector<const LeafAreaView*>& views) {
  if (views.empty() || views.front()->is_seen.empty()) return 0;
  const std::size_t points = views.front()->is_seen.size();
  std::size_t seen = 0;
  for (std::size_t i = 0; i < points; ++i) {
    seen += std::any_of(views.begin(), views.end(),
                        [i](const LeafAreaView* view) { return view->is_seen.at(i); });
  }
  return views.front()->whole_m2 * static_cast<double>(seen) / static_cast<double>(points);
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

}  // namespace cousin
