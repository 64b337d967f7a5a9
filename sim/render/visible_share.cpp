#include "sim/render/visible_share.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>

#include "sim/render/ray_scene.h"
#include "sim/render/truth_pass.h"

namespace cousin {

/// About a target.
struct TargetBall {
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  double radius_m = 0;
};

namespace {

TargetBall ball_of(const Mesh& mesh) {
  if (mesh.vertices_m.empty()) return {};
  Eigen::Vector3d low = mesh.vertices_m.front(), high = low;
  for (const Eigen::Vector3d& p : mesh.vertices_m) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  TargetBall ball{0.5 * (low + high), 0};
  for (const Eigen::Vector3d& p : mesh.vertices_m)
    ball.radius_m = std::max(ball.radius_m, (p - ball.centre_m).norm());
  return ball;
}

/// A scene of some of another's instances, shapes alone.
Scene part_of(const Scene& scene, const std::vector<std::size_t>& places) {
  Scene part;
  part.name = scene.name;
  Material material;
  material.name = "any";
  part.materials.push_back(material);
  std::map<int, int> models;
  for (const std::size_t place : places) {
    Instance instance = scene.instances[place];
    const auto [known, is_new] = models.emplace(instance.model, static_cast<int>(models.size()));
    if (is_new) {
      const ObjectModel& model = scene.models[static_cast<std::size_t>(instance.model)];
      ObjectModel shape;
      shape.name = model.name;
      shape.mesh = model.mesh;
      part.models.push_back(std::move(shape));
    }
    instance.model = known->second;
    instance.material = 0;
    instance.part_materials.clear();
    instance.motion.clear();
    instance.is_specimen = false;
    instance.part_of = -1;
    instance.keypoint_carriers.clear();
    part.instances.push_back(std::move(instance));
  }
  return part;
}

constexpr TruthNeeds kNeeds = {.depth = true, .instance = true};

}  // namespace

struct VisibleShare::Impl {
  const Scene& scene;
  std::size_t target;
  std::vector<std::size_t> movable;
  TargetBall ball;  ///< of the target, in the world
  Scene alone_scene, still_scene, movable_scene;
  RayScene alone, still;

  Impl(const Scene& whole, std::size_t target_place, double reach_m,
       std::vector<std::size_t> movable_places)
      : scene(whole),
        target(target_place),
        movable(std::move(movable_places)),
        ball(placed_ball(whole, target_place)),
        alone_scene(part_of(whole, {target_place})),
        still_scene(part_of(whole, still_places(reach_m))),
        movable_scene(part_of(whole, movable)),
        alone(alone_scene),
        still(still_scene) {}

  static TargetBall placed_ball(const Scene& scene, std::size_t place) {
    const Instance& instance = scene.instances.at(place);
    TargetBall ball = ball_of(scene.models[static_cast<std::size_t>(instance.model)].mesh);
    ball.centre_m = instance.world_from_object * ball.centre_m;
    return ball;
  }

  std::vector<std::size_t> still_places(double reach_m) const {
    std::vector<TargetBall> balls;
    for (const ObjectModel& model : scene.models) balls.push_back(ball_of(model.mesh));
    std::vector<std::size_t> places;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
      if (std::find(movable.begin(), movable.end(), i) != movable.end()) continue;
      const Instance& instance = scene.instances[i];
      const TargetBall& own = balls[static_cast<std::size_t>(instance.model)];
      const double apart = (instance.world_from_object * own.centre_m - ball.centre_m).norm();
      if (apart - own.radius_m <= reach_m) places.push_back(i);
    }
    return places;
  }
};

VisibleShare::VisibleShare(const Scene& scene, std::size_t target, double reach_m,
                           std::vector<std::size_t> movable)
    : impl_(std::make_unique<Impl>(scene, target, reach_m, std::move(movable))) {}
VisibleShare::~VisibleShare() = default;
VisibleShare::VisibleShare(VisibleShare&&) noexcept = default;

Eigen::Vector3d VisibleShare::centre_in_world_m() const { return impl_->ball.centre_m; }
double VisibleShare::radius_m() const { return impl_->ball.radius_m; }

double VisibleShare::seen(const TrueView& view) const { return seen(view, {}); }

double VisibleShare::seen(const TrueView& view, const std::vector<MovedInstance>& moved) const {
  const int id = impl_->scene.instances[impl_->target].id;
  const TruthImages alone = render_truth(impl_->alone, impl_->alone_scene, view, kNeeds);
  const TruthImages still = render_truth(impl_->still, impl_->still_scene, view, kNeeds);
  TruthImages before;
  if (!impl_->movable.empty()) {
    Scene scene = impl_->movable_scene;
    for (const MovedInstance& one : moved) {
      const auto at = std::find(impl_->movable.begin(), impl_->movable.end(), one.place);
      if (at == impl_->movable.end()) {
        throw std::invalid_argument("visible share: instance at place " +
                                    std::to_string(one.place) + " is not movable");
      }
      scene.instances[static_cast<std::size_t>(at - impl_->movable.begin())].world_from_object =
          one.world_from_object;
    }
    const RayScene rays(scene);
    before = render_truth(rays, scene, view, kNeeds);
  }
  std::int64_t full = 0, visible = 0;
  for (int y = 0; y < view.camera.height_px; ++y) {
    for (int x = 0; x < view.camera.width_px; ++x) {
      if (alone.instance(x, y) != id) continue;
      ++full;
      if (still.instance(x, y) != id) continue;
      const bool is_hidden = !impl_->movable.empty() && before.instance(x, y) >= 0 &&
                             before.depth_m(x, y) < still.depth_m(x, y);
      visible += is_hidden ? 0 : 1;
    }
  }
  if (full == 0) return std::numeric_limits<double>::quiet_NaN();
  return static_cast<double>(visible) / static_cast<double>(full);
}

TrueView view_about(const Camera& camera, const Pose& camera_from_world,
                    const Eigen::Vector3d& centre_in_world_m, double radius_m, int side_px) {
  const Eigen::Vector3d centre = camera_from_world * centre_in_world_m;
  const auto refuse = [&](const char* what) {
    throw std::invalid_argument("view about a ball of radius " + std::to_string(radius_m) +
                                " m at " + std::to_string(centre.norm()) + " m: " + what);
  };
  if (centre.norm() <= radius_m) refuse("the camera is inside it");
  // Extent of the cone that touches the ball, axis by axis.
  const auto range = [&](int axis, double focal_px, double middle_px) {
    const double angle = std::atan2(centre[axis], centre.z());
    const double flat = std::hypot(centre[axis], centre.z());
    const double half = flat > radius_m ? std::asin(std::min(1.0, radius_m / flat)) : 1.5;
    const auto pixel = [&](double a) {
      return middle_px + focal_px * std::tan(std::clamp(a, -1.5, 1.5));
    };
    return Eigen::Vector2d(pixel(angle - half), pixel(angle + half));
  };
  Eigen::Vector2d x = range(0, camera.fx_px, camera.cx_px);
  Eigen::Vector2d y = range(1, camera.fy_px, camera.cy_px);
  TrueView view;
  Camera& own = view.camera;
  view.camera_from_world = camera_from_world;
  const bool is_whole = x[0] >= -0.5 && y[0] >= -0.5 && x[1] <= camera.width_px - 0.5 &&
                        y[1] <= camera.height_px - 0.5;
  if (is_whole) {
    // Straight at it, so that the principal point lies in the picture.
    const Pose turned{Eigen::Quaterniond::FromTwoVectors(centre, Eigen::Vector3d::UnitZ()),
                      Eigen::Vector3d::Zero()};
    view.camera_from_world = turned * camera_from_world;
    const double tangent = std::tan(std::asin(radius_m / centre.norm()));
    own.width_px = own.height_px = side_px;
    own.fx_px = own.fy_px = 0.5 * side_px / tangent;
    own.cx_px = own.cy_px = 0.5 * (side_px - 1);
  } else {
    x = {std::max(x[0], -0.5), std::min(x[1], camera.width_px - 0.5)};
    y = {std::max(y[0], -0.5), std::min(y[1], camera.height_px - 0.5)};
    if (!(x[1] > x[0] && y[1] > y[0] && centre.z() > -radius_m))
      refuse("it lies outside the image");
    const double scale = side_px / std::max(x[1] - x[0], y[1] - y[0]);
    own.width_px = std::max(1, static_cast<int>(std::ceil(scale * (x[1] - x[0]))));
    own.height_px = std::max(1, static_cast<int>(std::ceil(scale * (y[1] - y[0]))));
    own.fx_px = scale * camera.fx_px;
    own.fy_px = scale * camera.fy_px;
    own.cx_px = scale * (camera.cx_px - x[0]) - 0.5;
    own.cy_px = scale * (camera.cy_px - y[0]) - 0.5;
  }
  view.camera_from_world_end = view.camera_from_world;
  return view;
}

}  // namespace cousin
