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

LeafRoom::LeafRoom(const AppleTree& tree, const std::vector<FruitModel>& fruits) : bodies_(fruits) {
  for (const FruitPlace& fruit : tree.fruits) placed_.push_back(bodies_.place(fruit));
}

bool LeafRoom::is_free(const PlantModel& leaf, const Pose& tree_from_leaf) const {
  constexpr std::size_t kEvery = 5;
  constexpr double kReach_m = 0.17;  // no leaf is longer with its petiole
  constexpr double kClear_m = 5e-4;
  const auto& vertices = leaf.model.mesh.vertices_m;
  for (const PlacedFruit& fruit : placed_) {
    const Vector3d apart = fruit.tree_from_fruit.translation_m - tree_from_leaf.translation_m;
    if (apart.norm() > fruit.radius_m + kReach_m) continue;
    const Pose fruit_from_leaf = fruit.fruit_from_tree * tree_from_leaf;
    for (std::size_t i = 0; i < vertices.size(); i += kEvery) {
      const Vector3d p = fruit_from_leaf * vertices[i];
      if (p.squaredNorm() < fruit.radius_m * fruit.radius_m &&
          fruit.body->depth_m(p, -2 * kClear_m) > -kClear_m)
        return false;
    }
  }
  return true;
}

}  // namespace cousin
