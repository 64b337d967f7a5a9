#include "scenes/apples/placed_fruit.h"

#include <Eigen/Geometry>

namespace cousin {
namespace {

using Eigen::Vector3d;

Vector3d keypoint_m(const FruitModel& fruit, const std::string& name) {
  for (const Keypoint& k : fruit.flesh.model.keypoints) {
    if (k.name == name) return k.in_object_m;
  }
  throw std::logic_error("an apple has no keypoint " + name);
}

}  // namespace

FruitBall ball_of(const FruitModel& fruit) {
  FruitBall ball;
  for (const Vector3d& p : fruit.hull.vertices_m) ball.radius_m = std::max(ball.radius_m, p.norm());
  ball.mean_radius_m = 0.5 * trait(fruit, "diameter");
  ball.cut_point_m = keypoint_m(fruit, "cut_point");
  return ball;
}

FruitBodies::FruitBodies(const std::vector<FruitModel>& models) : models_(models) {
  for (const FruitModel& model : models) {
    bodies_.emplace_back(model.hull);
    radii_m_.push_back(ball_of(model).radius_m);
  }
}

PlacedFruit FruitBodies::place(const FruitPlace& fruit) const {
  const auto v = static_cast<std::size_t>(fruit.variant);
  return {&bodies_[v], &models_[v].hull, inverse(fruit.tree_from_fruit), fruit.tree_from_fruit,
          radii_m_[v]};
}

}  // namespace cousin
