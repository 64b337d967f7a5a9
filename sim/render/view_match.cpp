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
    has_organs_.resize(scene.instances.size());
    for (const Instance& instance : scene.instances) {
      if (instance.part_of >= 0) has_organs_[index_.at(instance.part_of)] = true;
    }
  }

  void operator()(int y, const Image<float>& depth_m, const Image<std::int32_t>& instance,
                  ViewMatch& match) const {
    const PreparedRays::Row& row = prepared_.rows[static_cast<std::size_t>(y)];
    const double time_s = time_at_row(here_.view, y);
    const Eigen::Vector3d origin_m = row.origin_m + here_.rays.impl().centre_m;
    for (int x = 0; x < prepared_.width; ++x) {
      const auto found = index_.find(instance(x, y));
      if (found == index_.end() || std::isnan(depth_m(x, y))) continue;
      const std::size_t ray =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(prepared_.stride) +
          static_cast<std::size_t>(x);
      const Eigen::Vector3d d(
          static_cast<double>(prepared_.x[ray]) + static_cast<double>(prepared_.x_rest[ray]),
          static_cast<double>(prepared_.y[ray]) + static_cast<double>(prepared_.y_rest[ray]),
          static_cast<double>(prepared_.z[ray]) + static_cast<double>(prepared_.z_rest[ray]));
      const double along = row.camera_from_world.row(2).dot(d);
      const Eigen::Vector3d in_world_m = origin_m + static_cast<double>(depth_m(x, y)) / along * d;
      const std::size_t place =
          has_organs_[found->second]
              ? place_at(row, d, static_cast<double>(depth_m(x, y)) / along, found->second)
              : found->second;
      const Instance& object = scene_.instances[place];
      const Eigen::Vector3d in_object_m = inverse(world_from_object(object, time_s)) * in_world_m;
      const auto seen = image_of(there_.view, object, in_object_m);
      match.state(x, y) = PointState::outside;
      if (!seen) continue;
      match.flow_px(x, y) = (seen->pixel_px - Eigen::Vector2d(x, y)).cast<float>();
      if (!is_inside(there_.view.camera, seen->pixel_px)) continue;
      match.state(x, y) =
          is_in_sight(there_.rays, *seen, place, 0) ? PointState::visible : PointState::occluded;
    }
  }

 private:
  /// Which of a specimen's instances a row's ray meets at a distance along it: images know the
  /// specimen alone.
  std::size_t place_at(const PreparedRays::Row& row, const Eigen::Vector3d& d, double distance_m,
                       std::size_t specimen) const {
    const RayScene::Impl& impl = here_.rays.impl();
    constexpr double kBefore = 1e-4;  // of the distance; more than rounding
    RTCIntersectContext context = make_context(RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT);
    RTCRayHit ray{};
    ray.ray.org_x = static_cast<float>(row.origin_m.x());
    ray.ray.org_y = static_cast<float>(row.origin_m.y());
    ray.ray.org_z = static_cast<float>(row.origin_m.z());
    ray.ray.dir_x = static_cast<float>(d.x());
    ray.ray.dir_y = static_cast<float>(d.y());
    ray.ray.dir_z = static_cast<float>(d.z());
    ray.ray.time = row.time;
    ray.ray.tnear = static_cast<float>(distance_m * (1 - kBefore));
    ray.ray.tfar = std::numeric_limits<float>::infinity();
    ray.ray.mask = 0xFFFFFFFFU;
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(impl.scene, &context, &ray);
    if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return specimen;
    const std::uint32_t hit = geometry_index(ray.hit.instID[0], ray.hit.geomID);
    return impl.geometries[hit].id == scene_.instances[specimen].id ? hit : specimen;
  }

  const Scene& scene_;
  const RayView& here_;
  const PreparedRays& prepared_;
  const RayView& there_;
  std::unordered_map<int, std::size_t> index_;  ///< place in Scene::instances of an id
  std::vector<bool> has_organs_;                ///< of each instance
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
