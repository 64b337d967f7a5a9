#include "sim/render/view_match.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <unordered_map>

#include "sim/render/point_in_view.h"
#include "sim/render/ray_scene_impl.h"

namespace cousin {
namespace {

void check(const Scene& scene, const RayView& here, const Image<float>& depth_m,
           const Image<std::int32_t>& instance, const RayView& there) {
  const Camera& camera = here.view.camera;
  const auto fits = [&](const auto& image) {
    return image.width() == camera.width_px && image.height() == camera.height_px;
  };
  if (!fits(depth_m) || !fits(instance)) {
    throw std::invalid_argument("view match: depth or instance image is not of the view's size");
  }
  validate(there.view.camera);
  for (const RayScene* rays : {&here.rays, &there.rays}) {
    if (scene.instances.size() != rays->impl().geometries.size()) {
      throw std::invalid_argument("view match: the scene \"" + scene.name +
                                  "\" is not the one of the rays");
    }
  }
}

/// Matches of one row.
class RowMatcher {
 public:
  RowMatcher(const Scene& scene, const RayView& here, const PreparedRays& prepared,
             const RayView& there)
      : scene_(scene), here_(here), prepared_(prepared), there_(there) {
    for (std::size_t i = 0; i < scene.instances.size(); ++i) index_[scene.instances[i].id] = i;
  }

  void operator()(int y, const Image<float>& depth_m, const Image<std::int32_t>& instance,
                  ViewMatch& match) const {
    const PreparedRays::Row& row = prepared_.rows[static_cast<std::size_t>(y)];
    const double time_s = time_at_row(here_.view, y);
    const Eigen::Vector3d origin_m = row.origin_m + here_.rays.impl().centre_m;
    for (int x = 0; x < prepared_.width; ++x) {
      const auto found = index_.find(instance(x, y));
      if (found == index_.end() || std::isnan(depth_m(x, y))) continue;
      const Instance& object = scene_.instances[found->second];
      const std::size_t ray =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(prepared_.stride) +
          static_cast<std::size_t>(x);
      const Eigen::Vector3d d(
          static_cast<double>(prepared_.x[ray]) + static_cast<double>(prepared_.x_rest[ray]),
          static_cast<double>(prepared_.y[ray]) + static_cast<double>(prepared_.y_rest[ray]),
          static_cast<double>(prepared_.z[ray]) + static_cast<double>(prepared_.z_rest[ray]));
      const double along = row.camera_from_world.row(2).dot(d);
      const Eigen::Vector3d in_world_m = origin_m + static_cast<double>(depth_m(x, y)) / along * d;
      const Eigen::Vector3d in_object_m = inverse(world_from_object(object, time_s)) * in_world_m;
      const auto seen = image_of(there_.view, object, in_object_m);
      match.state(x, y) = PointState::outside;
      if (!seen) continue;
      match.flow_px(x, y) = (seen->pixel_px - Eigen::Vector2d(x, y)).cast<float>();
      if (!is_inside(there_.view.camera, seen->pixel_px)) continue;
      match.state(x, y) = is_in_sight(there_.rays, *seen, found->second, 0) ? PointState::visible
                                                                            : PointState::occluded;
    }
  }

 private:
  const Scene& scene_;
  const RayView& here_;
  const PreparedRays& prepared_;
  const RayView& there_;
  std::unordered_map<int, std::size_t> index_;  ///< place in Scene::instances of an id
};

}  // namespace

ViewMatch match_views(const Scene& scene, const RayView& here, const Image<float>& depth_m,
                      const Image<std::int32_t>& instance, const RayView& there) {
  check(scene, here, depth_m, instance, there);
  const PreparedRays prepared = prepare_rays(here.rays, here.view);
  const int width = prepared.width, height = prepared.height;
  ViewMatch match;
  match.flow_px = Image<Eigen::Vector2f>(
      width, height, Eigen::Vector2f::Constant(std::numeric_limits<float>::quiet_NaN()));
  match.state = Image<PointState>(width, height, PointState::none);
  const RowMatcher matcher(scene, here, prepared, there);
  tbb::parallel_for(0, height, [&](int y) { matcher(y, depth_m, instance, match); });
  return match;
}

}  // namespace cousin
