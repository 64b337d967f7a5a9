#include "sim/render/keypoint_truth.h"

#include <tbb/parallel_for.h>

#include <stdexcept>

#include "sim/render/point_in_view.h"
#include "sim/render/ray_scene_impl.h"
#include "sim/truth/specimens.h"

namespace cousin {

std::vector<KeypointView> view_keypoints(const RayScene& rays, const Scene& scene,
                                         const TrueView& view) {
  if (scene.instances.size() != rays.impl().geometries.size()) {
    throw std::invalid_argument("keypoint truth: the scene \"" + scene.name +
                                "\" is not the one of the rays");
  }
  struct Place {
    std::size_t carrier;  // into Scene::instances
    Eigen::Vector3d in_object_m;
  };
  std::vector<Place> places;
  std::vector<KeypointView> result;
  for (const Instance* instance : specimens_of(scene)) {
    const auto& keypoints = scene.models[static_cast<std::size_t>(instance->model)].keypoints;
    for (std::size_t k = 0; k < keypoints.size(); ++k) {
      places.push_back({carrier_of(scene, *instance, k), keypoints[k].in_object_m});
      KeypointView keypoint;
      keypoint.instance = instance->id;
      keypoint.keypoint = static_cast<int>(k);
      result.push_back(keypoint);
    }
  }
  tbb::parallel_for(std::size_t{0}, places.size(), [&](std::size_t i) {
    const std::size_t own = places[i].carrier;
    KeypointView& keypoint = result[i];
    const auto seen = image_of(view, scene.instances[own], places[i].in_object_m);
    keypoint.state = PointState::outside;
    if (!seen) return;
    keypoint.pixel_px = seen->pixel_px;
    keypoint.depth_m = seen->depth_m;
    if (!is_inside(view.camera, seen->pixel_px)) return;
    const double skin_m = 2 * distance_to_surface_m(rays, own, places[i].in_object_m);
    keypoint.state =
        is_in_sight(rays, *seen, own, skin_m) ? PointState::visible : PointState::occluded;
  });
  return result;
}

}  // namespace cousin
