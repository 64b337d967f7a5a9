#include "scenes/strawberries/bed_outline.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace cousin {

using Eigen::Vector2d;
using Eigen::Vector3d;

BedOutline bed_outline(const TrussShape& shape, double cell_m) {
  const double w = 2 * shape.bed_half_width_m, h = shape.bed_height_m, r = shape.bed_round_m;
  const double slope = shape.bed_slope_rad;
  BedOutline line;
  const auto put = [&](const Vector2d& point, const Vector2d& normal, int face) {
    line.points_m.push_back(point);
    line.normals.push_back(normal);
    line.face.push_back(face);
  };
  const auto straight = [&](const Vector2d& a, const Vector2d& b, const Vector2d& normal,
                            int face) {
    const int n = std::max(1, static_cast<int>((b - a).norm() / cell_m));
    for (int i = 0; i < n; ++i) put(a + (b - a) * i / n, normal, face);
  };
  const double span = 0.5 * std::numbers::pi - slope;
  const auto arc = [&](const Vector2d& centre, double from) {
    const int n = std::max(6, static_cast<int>(span * r / cell_m));
    for (int i = 0; i < n; ++i) {
      const double angle = from + span * i / n;
      const Vector2d out(std::cos(angle), std::sin(angle));
      put(centre + r * out, out, 1);
    }
  };
  const Vector2d near(-r, -r), far(-w + r, -r);
  const Vector2d out(std::cos(slope), std::sin(slope)), out_far(-out.x(), out.y());
  const Vector2d from = near + r * out, to = far + r * out_far;
  const double spread_m = (h + from.y()) * std::tan(slope);
  straight({from.x() + spread_m, -h}, from, out, 0);
  arc(near, slope);
  straight({-r, 0}, {-w + r, 0}, {0, 1}, 2);
  arc(far, 0.5 * std::numbers::pi);
  straight(to, {to.x() - spread_m, -h}, out_far, 0);
  put({to.x() - spread_m, -h}, out_far, 0);
  return line;
}

std::vector<BendingObstacle> bed_obstacles(const TrussShape& shape) {
  constexpr double kHalfLength_m = 0.6;
  const double r = shape.bed_round_m, slope = shape.bed_slope_rad;
  BendingObstacle top;
  top.half_m = {shape.bed_half_width_m, kHalfLength_m, 0.5 * shape.bed_height_m};
  top.world_from_box.translation_m = {-shape.bed_half_width_m, 0, -0.5 * shape.bed_height_m};
  top.round_m = r;
  std::vector<BendingObstacle> boxes = {top};
  if (slope == 0) return boxes;
  // A side's box has the shoulder's axis for that of its own round edge, and ends in the ground.
  const double length_m = shape.bed_height_m / std::cos(slope) + 2 * r;
  for (const int side : {1, -1}) {
    BendingObstacle box = top;
    box.half_m.x() = std::max(r, 0.4 * shape.bed_half_width_m);
    box.half_m.z() = 0.5 * length_m;
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(-side * slope, Vector3d::UnitY()));
    const Vector3d shoulder_m(side > 0 ? -r : -2 * shape.bed_half_width_m + r, 0, -r);
    const Vector3d in_box_m(side * (box.half_m.x() - r), 0, box.half_m.z() - r);
    box.world_from_box = {turn, shoulder_m - turn * in_box_m};
    boxes.push_back(box);
  }
  return boxes;
}

double depth_m(const std::vector<BendingObstacle>& obstacles, const Vector3d& in_world_m) {
  double deepest = -std::numeric_limits<double>::infinity();
  for (const BendingObstacle& box : obstacles)
    deepest = std::max(deepest, depth_m(box, in_world_m));
  return deepest;
}

}  // namespace cousin
