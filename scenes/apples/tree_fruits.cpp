#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

#include "scenes/apples/placed_fruit.h"

namespace cousin {
namespace {

using Eigen::Vector3d;
constexpr double kGravity_m_s2 = 9.81;

double distance_m(const Vector3d& p, const Vector3d& a, const Vector3d& b) {
  const Vector3d ab = b - a;
  const double t = std::clamp((p - a).dot(ab) / ab.squaredNorm(), 0.0, 1.0);
  return (a + t * ab - p).norm();
}

/// Gap between a ball and a piece of wood.
double gap_m(const WoodAxis& axis, const Vector3d& centre_m, double radius_m) {
  double least = 1e9;
  const CentreLine& line = axis.line;
  for (std::size_t i = 1; i < line.points_m.size(); ++i) {
    least = std::min(least, distance_m(centre_m, line.points_m[i - 1], line.points_m[i]) -
                                radius_m - std::max(line.radii_m[i - 1], line.radii_m[i]));
  }
  return least;
}

/// Hangs clusters on spurs in a random order.
class Bearer {
 public:
  Bearer(AppleTree& tree, const OrchardConfig& config, const std::vector<FruitModel>& models,
         double heavier, Rng rng)
      : tree_(tree), c_(config), models_(models), heavier_(heavier), rng_(rng) {
    for (const FruitModel& model : models) balls_.push_back(ball_of(model));
  }

  /// As many as there is room for, at most `count`.
  void bear(int count) {
    std::vector<int> spurs;
    for (std::size_t i = 0; i < tree_.wood.size(); ++i) {
      if (tree_.wood[i].kind == WoodKind::spur) spurs.push_back(static_cast<int>(i));
    }
    Rng order = rng_.fork("order");
    for (std::size_t i = spurs.size(); i > 1; --i)
      std::swap(spurs[i - 1], spurs[uniform_index(order, i)]);
    for (const int spur : spurs) {
      const int left = count - static_cast<int>(tree_.fruits.size());
      if (left <= 0) return;
      Rng own = rng_.fork("spur").fork(static_cast<std::uint64_t>(spur));
      const int branch = tree_.wood[static_cast<std::size_t>(spur)].parent;
      for (int size = std::min({left, cluster_size(own), room_on(branch)}); size > 0; --size) {
        if (!hang_cluster(spur, size, own.fork(static_cast<std::uint64_t>(size)))) continue;
        borne_[branch] += size;
        break;
      }
    }
  }

 private:
  int cluster_size(Rng& rng) const {
    const auto& share = c_.fruit.cluster_share;
    double draw = uniform(rng) * (share[0] + share[1] + share[2]);
    if ((draw -= share[0]) < 0) return 1;
    return draw - share[1] < 0 ? 2 : 3;
  }

  /// Fruits that a branch may still be given: as growers thin, by its section.
  int room_on(int branch) {
    const double radius_m = tree_.wood[static_cast<std::size_t>(branch)].line.radii_m.front();
    const double most = c_.fruit.per_m2 * std::numbers::pi * radius_m * radius_m;
    return std::max(1, static_cast<int>(most)) - borne_[branch];
  }

  bool hang_cluster(int spur, int size, Rng rng) {
    const CentreLine& line = tree_.wood[static_cast<std::size_t>(spur)].line;
    const Vector3d tip = line.points_m.back();
    const double first = uniform(rng, 0, 2 * std::numbers::pi);
    std::vector<FruitPlace> cluster;
    for (int k = 0; k < size; ++k) {
      FruitPlace fruit;
      fruit.axis = spur;
      fruit.variant = static_cast<int>(uniform_index(rng, models_.size()));
      const auto v = static_cast<std::size_t>(fruit.variant);
      fruit.mass_kg = heavier_ * models_[v].mass_kg;
      check_stalk(fruit, static_cast<int>(tree_.fruits.size()) + k);
      const double azimuth =
          first + 2 * std::numbers::pi * k / size + c_.fruit.cluster_spread_rad * normal(rng);
      const Vector3d out(std::cos(azimuth), std::sin(azimuth), 0);
      const FruitBall& ball = balls_[v];
      // So far out that a ring of such fruits touches.
      const std::array<double, 3> ring = {c_.fruit.single_off, 1.0, 1.155};
      const double off_m = ring[static_cast<std::size_t>(size - 1)] * ball.mean_radius_m +
                           (size > 1 ? 0.5 * c_.fruit.gap_m : 0);
      const double bourse_m = size > 1 ? c_.spur.bourse_m : 0;
      const double tilt =
          std::asin(std::clamp((off_m - bourse_m) / ball.cut_point_m.norm(), 0.0, std::sin(1.35)));
      const Vector3d up = std::cos(tilt) * Vector3d::UnitZ() - std::sin(tilt) * out;
      fruit.tree_from_fruit.rotation = sunny_side_out(up, tip, rng);
      fruit.tree_from_fruit.translation_m =
          tip + bourse_m * out - fruit.tree_from_fruit.rotation * ball.cut_point_m;
      if (!is_free(fruit, cluster)) return false;
      cluster.push_back(fruit);
    }
    tree_.fruits.insert(tree_.fruits.end(), cluster.begin(), cluster.end());
    return true;
  }

  /// The fruit's +x, where its blush is, points away from the trunk.
  Eigen::Quaterniond sunny_side_out(const Vector3d& up, const Vector3d& at_m, Rng& rng) const {
    const double turn =
        std::atan2(at_m.y(), at_m.x()) + c_.fruit.turn_spread_rad * truncated_normal(rng, 0, 1, 2);
    Vector3d x(std::cos(turn), std::sin(turn), 0);
    x = (x - x.dot(up) * up).normalized();
    Eigen::Matrix3d axes;
    axes << x, up.cross(x), up;
    return Eigen::Quaterniond(axes).normalized();
  }

  void check_stalk(const FruitPlace& fruit, int number) const {
    const double pull_n = fruit.mass_kg * kGravity_m_s2;
    if (pull_n <= c_.fruit.stalk_holds_n) return;
    throw std::invalid_argument("apples: apple " + std::to_string(number) + " of " +
                                std::to_string(fruit.mass_kg) + " kg pulls with " +
                                std::to_string(pull_n) +
                                " N; its stalk holds orchard.fruit.stalk_holds_n = " +
                                std::to_string(c_.fruit.stalk_holds_n));
  }

  bool is_free(const FruitPlace& fruit, const std::vector<FruitPlace>& cluster) const {
    const Vector3d& at = fruit.tree_from_fruit.translation_m;
    const FruitBall& ball = balls_[static_cast<std::size_t>(fruit.variant)];
    if (at.z() < c_.fruit.lowest_m) return false;
    for (const FruitPlace& other : tree_.fruits) {
      const FruitBall& b = balls_[static_cast<std::size_t>(other.variant)];
      if ((at - other.tree_from_fruit.translation_m).norm() <
          ball.radius_m + b.radius_m + c_.fruit.gap_m)
        return false;
    }
    for (const FruitPlace& other : cluster) {
      const FruitBall& b = balls_[static_cast<std::size_t>(other.variant)];
      // Flat fruits beside each other: balls of their largest radius would be too large.
      if ((at - other.tree_from_fruit.translation_m).norm() < ball.mean_radius_m + b.mean_radius_m)
        return false;
    }
    return std::none_of(tree_.wood.begin(), tree_.wood.end(), [&](const WoodAxis& axis) {
      const Vector3d& a = axis.line.points_m.front();
      if ((a - at).norm() > ball.radius_m + length_m(axis.line) + 0.1) return false;
      if (&axis == &tree_.wood[static_cast<std::size_t>(fruit.axis)]) return false;
      return gap_m(axis, at, ball.radius_m) < c_.fruit.gap_m;
    });
  }

  AppleTree& tree_;
  const OrchardConfig& c_;
  const std::vector<FruitModel>& models_;
  double heavier_ = 1;
  Rng rng_;
  std::vector<FruitBall> balls_;
  std::map<int, int> borne_;  ///< fruits by branch
};

}  // namespace

void bear_fruits(AppleTree& tree, const OrchardConfig& config,
                 const std::vector<FruitModel>& models, int count, double heavier, Rng rng) {
  bear_at_most(tree, config, models, count, heavier, rng);
  if (static_cast<int>(tree.fruits.size()) == count) return;
  throw std::invalid_argument(
      "apples: fruits = " + std::to_string(count) + "; its spurs and branches have room for " +
      std::to_string(tree.fruits.size()) + " without overlaps and within orchard.fruit.per_m2");
}

void bear_at_most(AppleTree& tree, const OrchardConfig& config,
                  const std::vector<FruitModel>& models, int count, double heavier, Rng rng) {
  Bearer(tree, config, models, heavier, rng).bear(count);
}

}  // namespace cousin
