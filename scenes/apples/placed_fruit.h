#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include "scenes/apples/apple_tree.h"
#include "sim/physics/penetration.h"

namespace cousin {

/// Private to scenes/apples.

/// What placing needs of a fruit model.
struct FruitBall {
  double radius_m = 0;       ///< about the centroid, of all of the flesh
  double mean_radius_m = 0;  ///< across the axis
  Eigen::Vector3d cut_point_m;
};
FruitBall ball_of(const FruitModel& fruit);

/// A convex fruit in its place.
struct PlacedFruit {
  const ConvexBody* body = nullptr;
  const Mesh* hull = nullptr;
  Pose fruit_from_tree, tree_from_fruit;
  double radius_m = 0;
};

/// The convex bodies of a tree's fruit models.
class FruitBodies {
 public:
  explicit FruitBodies(const std::vector<FruitModel>& models);
  PlacedFruit place(const FruitPlace& fruit) const;

 private:
  const std::vector<FruitModel>& models_;
  std::vector<ConvexBody> bodies_;
  std::vector<double> radii_m_;
};

/// Whether leaves are clear of a tree's fruits.
class LeafRoom {
 public:
  LeafRoom(const AppleTree& tree, const std::vector<FruitModel>& fruits);
  /// No vertex of the leaf, of every fifth, is nearer than half a millimetre to a fruit.
  bool is_free(const PlantModel& leaf, const Pose& tree_from_leaf) const;

 private:
  FruitBodies bodies_;
  std::vector<PlacedFruit> placed_;
};

}  // namespace cousin
