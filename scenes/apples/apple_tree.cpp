#include "scenes/apples/apple_tree.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "sim/geometry/gradient_noise.h"
#include "sim/types/pi.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

Vector3d around(const Vector3d& axis, double angle_rad) {
  const Vector3d any = std::abs(axis.z()) < 0.9 ? Vector3d::UnitZ() : Vector3d::UnitX();
  const Vector3d u = axis.cross(any).normalized(), v = axis.cross(u);
  return std::cos(angle_rad) * u + std::sin(angle_rad) * v;
}

Vector3d any_turn(Rng& rng, double sigma) {
  return sigma * Vector3d(normal(rng), normal(rng), normal(rng));
}

/// A wavering line that bends towards `towards` by about `turn_rad` over its length.
struct LineGrowth {
  Vector3d start_m, heading;
  double length_m = 0, radius_m = 0, tip_radius_m = 0;
  int pieces = 8;
  Vector3d towards = Vector3d::UnitZ();
  double turn_rad = 0, wiggle_rad = 0;
};

CentreLine grow_line(const LineGrowth& g, Rng& rng) {
  CentreLine line;
  Vector3d at = g.start_m, heading = g.heading.normalized();
  for (int i = 0; i <= g.pieces; ++i) {
    const double share = static_cast<double>(i) / g.pieces;
    line.points_m.push_back(at);
    line.radii_m.push_back(g.radius_m + share * (g.tip_radius_m - g.radius_m));
    at += g.length_m / g.pieces * heading;
    heading += g.turn_rad / g.pieces * g.towards + any_turn(rng, g.wiggle_rad);
    heading.normalize();
  }
  return line;
}

class Grower {
 public:
  Grower(const OrchardConfig& config, int leaf_variants, Rng rng)
      : c_(config), variants_(leaf_variants), rng_(rng) {}

  AppleTree grow() {
    Rng size = rng_.fork("size");
    size_ = truncated_normal(size, 1, c_.tree.spread, 2);
    height_m_ = std::min(size_ * c_.tree.height_m, c_.tree.height_most_m);
    grow_trunk(rng_.fork("trunk"));
    for (int i = 0; i < c_.branch.count; ++i)
      grow_branch(i, rng_.fork("branch").fork(static_cast<std::uint64_t>(i)));
    return std::move(tree_);
  }

 private:
  void grow_trunk(Rng rng) {
    const auto& t = c_.tree;
    const std::uint64_t key = rng();
    WoodAxis trunk;
    constexpr int kPieces = 40;
    for (int i = 0; i <= kPieces; ++i) {
      const double share = static_cast<double>(i) / kPieces, z = share * height_m_;
      const double x = noise3({z / t.wander_scale_m, 0.3, 0.7}, key),
                   y = noise3({0.2, z / t.wander_scale_m, 0.1}, key + 1);
      const double bend = t.wander_m * std::min(1.0, 4 * share);
      trunk.line.points_m.emplace_back(bend * x, bend * y, z);
      // Flares where it leaves the ground, above the graft.
      const double flare = 1 + t.flare * std::exp(-z / t.flare_m) +
                           t.graft * std::exp(-std::pow((z - t.graft_at_m) / t.graft_m, 2));
      trunk.line.radii_m.push_back(
          flare * (t.trunk_radius_m +
                   std::pow(share, t.taper) * (t.trunk_tip_radius_m - t.trunk_radius_m)));
    }
    tree_.wood.push_back(std::move(trunk));
    add_alternate_leaves(0, std::max(0.9, c_.branch.last_share), rng.fork("leaves"));
  }

  void grow_branch(int i, Rng rng) {
    const auto& b = c_.branch;
    const double t = b.count > 1 ? static_cast<double>(i) / (b.count - 1) : 0;
    const double spacing = (b.last_share * height_m_ - b.first_m) / std::max(1, b.count);
    const double z = b.first_m + t * (b.last_share * height_m_ - b.first_m) +
                     b.scatter * spacing * uniform(rng, -1, 1);
    const double azimuth =
        i * b.divergence_rad + truncated_normal(rng, 0, b.divergence_spread_rad, 2);
    const double upright =
        truncated_normal(rng, b.angle_rad - b.angle_less_rad * t, b.angle_spread_rad, 2);
    LineGrowth g;
    WoodAxis branch;
    branch.kind = WoodKind::branch;
    branch.parent = 0;
    branch.parent_share = std::clamp(z / height_m_, 0.0, 1.0);
    const LineWalk trunk(tree_.wood[0].line, Vector3d::UnitX());
    const LinePoint from = trunk.at_share(branch.parent_share);
    g.start_m = from.point_m;
    g.heading = {std::sin(upright) * std::cos(azimuth), std::sin(upright) * std::sin(azimuth),
                 std::cos(upright)};
    g.length_m = size_ *
                 (b.length_m + std::pow(t, b.length_power) * (b.length_top_m - b.length_m)) *
                 truncated_normal(rng, 1, b.cv_length, 2);
    g.radius_m = std::min(std::max(b.radius_share * g.length_m, b.radius_least_m),
                          b.radius_most * from.radius_m);
    g.tip_radius_m = std::min(b.radius_tip_m, g.radius_m);
    g.pieces = 16;
    g.towards = -Vector3d::UnitZ();
    g.turn_rad = b.droop_rad * (1 - b.droop_less * t);
    g.wiggle_rad = b.wiggle_rad;
    branch.line = grow_line(g, rng);
    tree_.wood.push_back(std::move(branch));
    const int place = static_cast<int>(tree_.wood.size()) - 1;
    add_spurs(place, rng.fork("spurs"));
    add_shoots(place, rng.fork("shoots"));
  }

  void add_spurs(int branch, Rng rng) {
    const auto& s = c_.spur;
    const LineWalk walk(tree_.wood[static_cast<std::size_t>(branch)].line, Vector3d::UnitZ());
    double along_m = s.first_share * walk.length_m() + s.first_m;
    double azimuth = uniform(rng, 0, 2 * kPi);
    while (along_m < s.last_share * walk.length_m()) {
      const LinePoint from = walk.at_m(along_m);
      WoodAxis spur;
      spur.kind = WoodKind::spur;
      spur.parent = branch;
      spur.parent_share = along_m / walk.length_m();
      LineGrowth g;
      const Vector3d out = around(from.axes.col(0), azimuth);
      g.start_m = from.point_m;
      g.heading = out + s.lean * from.axes.col(0);
      g.length_m = from.radius_m + uniform(rng, s.length_m[0], s.length_m[1]);
      g.radius_m = std::min(s.radius_m, from.radius_m);
      g.tip_radius_m = s.taper * g.radius_m;
      g.pieces = 5;
      g.turn_rad = s.turn_rad;
      g.wiggle_rad = s.wiggle_rad;
      spur.line = grow_line(g, rng);
      tree_.wood.push_back(std::move(spur));
      add_rosette(static_cast<int>(tree_.wood.size()) - 1, rng);
      along_m += s.spacing_m * uniform(rng, s.spacing_spread[0], s.spacing_spread[1]);
      azimuth += s.divergence_rad + s.divergence_spread_rad * normal(rng);
    }
  }

  void add_shoots(int branch, Rng rng) {
    const auto& s = c_.shoot;
    const LineWalk walk(tree_.wood[static_cast<std::size_t>(branch)].line, Vector3d::UnitZ());
    double along_m = s.spacing_m * uniform(rng, s.first_spread[0], s.first_spread[1]);
    const auto add = [&](double at_m, const Vector3d& heading) {
      const LinePoint from = walk.at_m(at_m);
      WoodAxis shoot;
      shoot.kind = WoodKind::shoot;
      shoot.parent = branch;
      shoot.parent_share = at_m / walk.length_m();
      LineGrowth g;
      g.start_m = from.point_m;
      g.heading = heading;
      g.length_m = uniform(rng, s.length_m[0], s.length_m[1]);
      g.radius_m = std::min(s.radius_m, from.radius_m);
      g.tip_radius_m = s.taper * g.radius_m;
      g.pieces = 9;
      g.turn_rad = s.turn_rad;
      g.wiggle_rad = s.wiggle_rad;
      shoot.line = grow_line(g, rng);
      tree_.wood.push_back(std::move(shoot));
      add_alternate_leaves(static_cast<int>(tree_.wood.size()) - 1, s.bare_share,
                           rng.fork(tree_.wood.size()));
    };
    while (along_m < s.last_share * walk.length_m()) {
      const LinePoint from = walk.at_m(along_m);
      const Vector3d side = from.axes.col(0).cross(Vector3d::UnitZ()).normalized();
      add(along_m, Vector3d(s.rise * Vector3d::UnitZ() + s.lean * from.axes.col(0) +
                            uniform(rng, -s.aside, s.aside) * side));
      along_m += s.spacing_m * uniform(rng, s.spacing_spread[0], s.spacing_spread[1]);
    }
    add(walk.length_m(), walk.at_share(1).axes.col(0));
  }

  /// @param rise_rad  of the leaf over the plane across the axis.
  void add_leaf(int axis, double share, const LinePoint& from, double azimuth, double rise_rad,
                Rng& rng) {
    const Vector3d d = from.axes.col(0), r = around(d, azimuth);
    const Vector3d x = (std::cos(rise_rad) * r + std::sin(rise_rad) * d).normalized();
    // Blades turn their upper side to the light.
    Vector3d z = -std::sin(rise_rad) * r + std::cos(rise_rad) * d +
                 c_.leaf.to_light * Vector3d::UnitZ() + any_turn(rng, c_.leaf.turn_spread);
    z -= z.dot(x) * x;
    z = z.norm() > 0.05 ? Vector3d(z.normalized()) : around(x, 0);
    Eigen::Matrix3d axes;
    axes << x, z.cross(x), z;
    LeafPlace leaf;
    leaf.axis = axis;
    leaf.share = share;
    leaf.variant = static_cast<int>(uniform_index(rng, static_cast<std::uint64_t>(variants_)));
    leaf.tree_from_leaf = {Eigen::Quaterniond(axes).normalized(),
                           from.point_m + 0.9 * from.radius_m * r};
    tree_.leaves.push_back(leaf);
  }

  void add_rosette(int spur, Rng& rng) {
    if (c_.spur.leaves == 0) return;
    const LineWalk walk(tree_.wood[static_cast<std::size_t>(spur)].line, Vector3d::UnitZ());
    const int count = std::max(0, static_cast<int>(std::lround(truncated_normal(
                                      rng, c_.spur.leaves, c_.spur.leaves_spread, 2))));
    double azimuth = uniform(rng, 0, 2 * kPi);
    for (int i = 0; i < count; ++i) {
      const double share = 1 - c_.spur.leafy_share + c_.spur.leafy_share * (i + 0.5) / count;
      const double rise = truncated_normal(rng, c_.leaf.rise_rad, c_.leaf.rise_spread_rad, 2);
      add_leaf(spur, share, walk.at_share(share), azimuth, rise, rng);
      azimuth += c_.leaf.divergence_rad + c_.spur.leaf_divergence_spread_rad * normal(rng);
    }
  }

  void add_alternate_leaves(int axis, double first_share, Rng rng) {
    if (c_.spur.leaves == 0) return;
    const LineWalk walk(tree_.wood[static_cast<std::size_t>(axis)].line, Vector3d::UnitZ());
    double azimuth = uniform(rng, 0, 2 * kPi);
    double along_m = first_share * walk.length_m();
    while (along_m < walk.length_m()) {
      const double share = along_m / walk.length_m();
      add_leaf(axis, share, walk.at_share(share), azimuth,
               truncated_normal(rng, c_.shoot.leaf_rise_rad, c_.shoot.leaf_rise_spread_rad, 2),
               rng);
      azimuth += c_.leaf.divergence_rad + c_.shoot.leaf_divergence_spread_rad * normal(rng);
      along_m += c_.shoot.leaf_spacing_m *
                 uniform(rng, c_.shoot.leaf_spacing_spread[0], c_.shoot.leaf_spacing_spread[1]);
    }
  }

  const OrchardConfig& c_;
  int variants_ = 1;
  Rng rng_;
  AppleTree tree_;
  double size_ = 1, height_m_ = 3;
};

}  // namespace

AppleTree grow_apple_tree(const OrchardConfig& config, int leaf_variants, Rng rng) {
  return Grower(config, leaf_variants, rng).grow();
}

double height_m(const AppleTree& tree) {
  double highest = 0;
  for (const WoodAxis& axis : tree.wood) {
    if (axis.is_pruned) continue;
    for (const Vector3d& p : axis.line.points_m) highest = std::max(highest, p.z());
  }
  return highest;
}

}  // namespace cousin
