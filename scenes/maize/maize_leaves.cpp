#include "scenes/maize/maize_leaves.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "sim/geometry/gradient_noise.h"
#include "sim/plant/color.h"
#include "sim/plant/growth.h"

namespace cousin {

using Eigen::Vector3d;

LeafMaker::LeafMaker(MaizeDraft& draft, const LineWalk& axis)
    : d_(draft), c_(draft.config), axis_(axis) {
  for (int rank = 1; rank <= c_.plant.leaves; ++rank) {
    if (rank <= d_.stage) top_collar_m_ = std::max(top_collar_m_, collar_m(rank));
  }
}

void LeafMaker::add(int rank, int parent) {
  const std::string number = std::to_string(rank);
  const int sheath = add_organ(d_.plant, OrganKind::sheath, "sheath " + number, parent, rank).id;
  grow_sheath(d_.plant.organs.back());
  add_organ(d_.plant, OrganKind::ligule, "ligule " + number, sheath, rank);
  grow_ligule(d_.plant.organs.back());
  add_organ(d_.plant, OrganKind::blade, "leaf " + number, sheath, rank);
  grow_blade(d_.plant.organs.back());
}

bool LeafMaker::has_collar(int rank) const { return rank <= d_.stage && !has_fallen(rank); }

double LeafMaker::sheath_share(int rank) const {
  return grown_share(d_.stage, rank - c_.sheath.begin_before, rank);
}

double LeafMaker::sheath_m(int rank) const {
  return d_.own.vigour * sheath_share(rank) *
         c_.sheath.length_m[static_cast<std::size_t>(rank - 1)];
}

double LeafMaker::node_m(int rank) const {
  return d_.stalk.nodes_m[static_cast<std::size_t>(rank - 1)];
}

double LeafMaker::collar_m(int rank) const { return node_m(rank) + sheath_m(rank); }

double LeafMaker::dryness(int rank) const {
  if (rank > c_.blade.last_to_fall) return 0;
  return logistic(d_.stage, rank + c_.blade.dry_after, c_.blade.dry_stages);
}

double LeafMaker::blade_share(int rank) const {
  return grown_share(d_.stage, rank - c_.blade.tips_ahead - c_.blade.begin_ahead, rank);
}

double LeafMaker::blade_m(int rank) const {
  const auto r = static_cast<std::size_t>(rank - 1);
  return std::max(4e-3,
                  d_.own.vigour * d_.own.leaves[r].size * blade_share(rank) * c_.blade.length_m[r]);
}

double LeafMaker::out_share(int rank) const {
  return grown_share(d_.stage, rank - c_.whorl.leave_before, rank + c_.whorl.left_after);
}

double LeafMaker::base_m(int rank) const {
  return std::max(collar_m(rank), top_collar_m_ * (rank > d_.stage) - c_.whorl.foot_below_m);
}

double LeafMaker::steepness(double in) const {
  return 1 - c_.whorl.steeper + c_.whorl.steeper * in;
}

/// Inner leaves open above the outer ones, where these have given way.
LeafMaker::Opening LeafMaker::opening(int rank) const {
  Opening below;
  for (int k = std::min(rank, last_collar()); k <= rank; ++k) {
    const double in = 1 - out_share(k), length_m = blade_m(k), rise = steepness(in);
    const double over_m = std::min(c_.blade.clasp_m, c_.blade.clasp_share * length_m) +
                          c_.whorl.rolled_share * in * length_m;
    Opening own{base_m(k) + rise * c_.whorl.closed_share * in * over_m, base_m(k) + rise * over_m};
    const double way_m = own.end_m - own.start_m;
    own.start_m = std::max(own.start_m, below.end_m);
    own.end_m = std::max(own.end_m, own.start_m + way_m);
    below = own;
  }
  return below;
}

double LeafMaker::funnel_at(double up_m) const {
  return 1 + c_.blade.funnel * smoothstep(0, c_.blade.funnel_m, up_m - top_collar_m_);
}

int LeafMaker::leaves_inside(int rank) const {
  int count = 0;
  for (int other = rank + 1; other <= c_.plant.leaves; ++other)
    count += blade_share(other) >= c_.blade.least_share ? 1 : 0;
  return count;
}

bool LeafMaker::has_fallen(int rank) const {
  return rank <= c_.blade.last_to_fall && d_.stage > rank + c_.blade.fall_after;
}

/// What the sheath of `rank` wraps at a place along the axis: stalk, or the whorl above it, and
/// younger sheaths; and itself.

double LeafMaker::wrapped_m(int rank, double along_m) const {
  double radius = axis_.at_m(along_m).radius_m;
  if (along_m > axis_.length_m()) {
    const double above = (along_m - axis_.length_m()) / c_.whorl.narrows_m;
    radius = std::max(radius, d_.stalk.youth * c_.whorl.radius_share * c_.stalk.radius_m) *
             (1 - c_.whorl.narrows * std::min(1.0, above));
  }
  double swelling = 0;
  for (int other = rank; other <= c_.plant.leaves; ++other) {
    swelling =
        std::max(swelling, std::exp(-std::pow((along_m - node_m(other)) / c_.stalk.swelling_m, 2)));
    if (along_m >= node_m(other) && along_m <= collar_m(other) + 1e-9)
      radius += c_.sheath.thickness_m;
  }
  return radius * (1 + c_.stalk.swelling * swelling);
}

CentreLine LeafMaker::along_axis(int rank, double from_m, double to_m, int steps,
                                 double wider_m) const {
  CentreLine line;
  for (int i = 0; i <= steps; ++i) {
    const double along_m = from_m + (to_m - from_m) * i / steps;
    line.points_m.push_back(axis_.at_m(along_m).point_m);
    line.radii_m.push_back(wrapped_m(rank, along_m) + wider_m);
  }
  return line;
}

void LeafMaker::grow_sheath(Organ& organ) const {
  organ.look = kStalkLook;
  organ.age_days = d_.stage - organ.rank;
  const double length_m = sheath_m(organ.rank);
  if (length_m < 2e-3) return;
  const double base_m = node_m(organ.rank);
  organ.line = along_axis(organ.rank, base_m, base_m + length_m, 12, 0);
  organ.surface = tube_surface(organ.line, c_.surface.sides);
  const double low = std::clamp(1.3 - organ.rank / 5.0, 0.0, 1.0), dry = dryness(organ.rank);
  Vector3d colour =
      (1 - low) * color_vector(c_.sheath.albedo) + low * color_vector(c_.sheath.albedo_low);
  colour = (1 - dry) * colour + dry * color_vector(c_.blade.albedo_dry);
  for (const Eigen::Vector2d& place : organ.surface.place) {
    const double streak =
        1 + 0.25 * noise3(Vector3d(3 * place.x(), 40 * place.y(), organ.rank), d_.own.colour_key);
    organ.albedo.push_back(to_rgb(
        (streak * colour).cwiseQuotient(maize_base(c_, kStalkLook)).cwiseMin(1.0).cwiseMax(0.02)));
  }
}

void LeafMaker::grow_ligule(Organ& organ) const {
  organ.look = kStalkLook;
  organ.age_days = d_.stage - organ.rank;
  if (!has_collar(organ.rank)) return;
  const double top_m = collar_m(organ.rank);
  // A membrane that stands in the mouth of the sheath, between blade and stalk.
  organ.line = along_axis(organ.rank, top_m, top_m + c_.sheath.ligule_m, 3, 4e-4);
  finish_tube(c_, organ, c_.surface.sides, c_.sheath.ligule_albedo);
  d_.plant.keypoints.push_back({"collar " + std::to_string(organ.rank), axis_.at_m(top_m).point_m});
}

BladeShape LeafMaker::shape_of(int rank, double out, double length_share) const {
  const auto r = static_cast<std::size_t>(rank - 1);
  const auto& b = c_.blade;
  const MaizeIndividual::Leaf& own = d_.own.leaves[r];
  const double widest_m = *std::max_element(b.width_m.begin(), b.width_m.end());
  BladeShape shape;
  shape.width_m = d_.own.vigour * own.size * b.width_m[r] *
                  (b.young_width + (1 - b.young_width) * length_share);
  shape.envelope_base = b.outline[0];
  shape.envelope_peak = b.outline[1];
  shape.envelope_rise = b.outline[2];
  shape.envelope_fall = b.outline[3];
  shape.envelope_tip = b.outline[4];
  shape.fold_rad = b.fold_rad;
  shape.camber = -b.camber * out;
  shape.wave_m = b.wave_m * out * shape.width_m / widest_m;
  shape.wave_count = b.wave_count * std::max(b.young_waves, length_share);
  shape.wave_phase_rad = own.phase_rad;
  shape.twist_rad = out * own.twist_rad;
  return shape;
}

void LeafMaker::grow_blade(Organ& organ) const {
  const int rank = organ.rank;
  const auto r = static_cast<std::size_t>(rank - 1);
  const auto& b = c_.blade;
  const auto& w = c_.whorl;
  const MaizeIndividual::Leaf& own = d_.own.leaves[r];
  organ.look = kBladeLook;
  organ.age_days = d_.stage - rank + b.tips_ahead;
  const double share = blade_share(rank);
  if (share < b.least_share || has_fallen(rank)) return;
  // Out of the whorl, and leaned out to its final angle.
  const double out = out_share(rank), dry = dryness(rank);
  const double foot_m = base_m(rank);
  const LinePoint base = axis_.at_m(foot_m);
  const Vector3d side =
      (Vector3d(std::cos(own.azimuth_rad), std::sin(own.azimuth_rad), 0) -
       base.axes.col(0) *
           base.axes.col(0).dot(Vector3d(std::cos(own.azimuth_rad), std::sin(own.azimuth_rad), 0)))
          .normalized();
  const double up = (rank - 1.0) / (c_.plant.leaves - 1);
  const double angle = (w.angle_share + (1 - w.angle_share) * out) * own.angle *
                           (b.angle_low_rad + up * (b.angle_high_rad - b.angle_low_rad)) +
                       b.dry_angle_rad * dry;
  AxisGrowth growth;
  growth.start_m = base.point_m + (w.off_share + (b.off_share - w.off_share) * out) *
                                      wrapped_m(rank, foot_m) * side;
  growth.heading = (std::cos(angle) * base.axes.col(0) + std::sin(angle) * side).normalized();
  growth.length_m = blade_m(rank);
  growth.radius_base_m = b.midrib_radius_m * std::sqrt(b.length_m[r] / b.midrib_length_m);
  growth.radius_tip_m = b.midrib_tip_m;
  growth.segments = 40;
  // Long leaves hang over; what still stands in the whorl is stiff.
  const double droop = b.droop_rad * own.droop *
                           std::min(b.droop_most, growth.length_m / b.droop_length_m) *
                           (w.droop_share + (1 - w.droop_share) * out) +
                       b.dry_droop_rad * dry;
  growth.tropisms.push_back({-Vector3d::UnitZ(), droop, b.droop_begin});
  organ.line = grow_axis(growth);
  const BladeShape shape = shape_of(rank, out, share);
  const Vector3d upper = std::sin(angle) * base.axes.col(0) - std::cos(angle) * side;
  const int rows = std::clamp(static_cast<int>(growth.length_m / c_.surface.detail_m), 10, 120);
  // A roll is a polygon: it has corners enough to lie inside the next.
  const int columns = (rank > last_collar() ? 2 : 1) * c_.surface.columns;
  organ.surface = blade_surface(LineWalk(organ.line, upper), shape, rows, columns);
  const Vector3d across = LineWalk(organ.line, upper).at_m(0).axes.col(1);
  // Leaves of the whorl are rolled about each other, inside the mouth of the last sheath.
  const int last = last_collar();
  const double mouth_m = wrapped_m(std::min(rank, last), foot_m) + 6e-4;
  const double apart_m = w.leaves_share * mouth_m / std::max(1, leaves_inside(last));
  const double radius_m =
      rank <= last ? mouth_m : w.core_share * mouth_m + apart_m * leaves_inside(rank);
  constexpr double kMargin = 0.06;  // of the way to the next leaf, a radian
  clasp(organ, {foot_m, radius_m, kMargin * apart_m, side, across, out});
  colour_blade(organ, out, dry);
  d_.plant.keypoints.push_back({"tip " + std::to_string(rank), organ.line.points_m.back()});
}

/// A blade does not begin flat: it goes on from its sheath, and its margins, as auricles, reach
/// about the stalk. The base's rows are arcs about the axis, as long as they are wide when flat,
/// and unroll over the clasp's length. A blade in the whorl is rolled about the younger ones and
/// opens from its tip down: the clasp is as long as it then is.
void LeafMaker::clasp(Organ& organ, const Clasp& clasp) const {
  const double length_m = line_length_m(organ), in = 1 - clasp.out;
  const Opening opens = opening(organ.rank);
  const LineWalk midrib(organ.line, clasp.across.cross(clasp.side));
  auto& vertices = organ.surface.mesh.vertices_m;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const double along_m = organ.surface.place[i].x() * length_m;
    const double up_m = clasp.base_m + steepness(in) * along_m;
    const double share = 1 - smoothstep(opens.start_m, opens.end_m, up_m);
    if (!(share > 0)) continue;
    const Vector3d flat_m = midrib.at_m(along_m).point_m, off_m = vertices[i] - flat_m;
    // The midrib leaves the cylinder, and never for its inside.
    const Vector3d axis_m = axis_.at_m(up_m).point_m;
    const double funnel = funnel_at(up_m), inner_m = funnel * clasp.radius_m;
    Vector3d rib_m = (1 - share) * flat_m + share * (axis_m + inner_m * clasp.side);
    rib_m += std::max(0.0, inner_m - clasp.side.dot(rib_m - axis_m)) * clasp.side;
    const double most_rad = c_.blade.clasp_rad +
                            c_.whorl.more_rad * in;  // margins that have left the whorl do not meet
    const double left = organ.surface.place[i].y() < 0 ? -1 : 1;
    const double full_rad = left * std::min(most_rad, off_m.norm() / inner_m);
    // An arc that has moved off the axis is so much wider that it still goes about the others.
    const double off_axis_m = clasp.side.dot(rib_m - axis_m) - inner_m;
    const double wider = std::max(1 / share, 1 + 0.6 * off_axis_m / inner_m);
    const double turn = full_rad / wider;
    const double radius_m = wider * (inner_m + in * funnel * clasp.roll_m * full_rad);
    const Vector3d arc_m =
        radius_m * (std::sin(turn) * clasp.across - (1 - std::cos(turn)) * clasp.side);
    constexpr double kNearlyFlat = 0.3;  // from here on fold and waves come
    const double rolled = smoothstep(0, kNearlyFlat, share);
    vertices[i] = rib_m + (1 - rolled) * off_m + rolled * arc_m;
  }
}

void LeafMaker::colour_blade(Organ& organ, double out, double dry) const {
  const auto& b = c_.blade;
  const Vector3d base = maize_base(c_, kBladeLook);
  const double length_m = line_length_m(organ);
  for (const Eigen::Vector2d& place : organ.surface.place) {
    const double s = place.x(), t = std::abs(place.y());
    const double collar = 1 - smoothstep(0.4, 1.0, s * length_m / c_.blade.collar_m);
    const double rib = 1 - smoothstep(0.6, 1.4, t / (b.midrib_share * (1.15 - s) + 1e-3));
    // Young and rolled: paler towards the base.
    const double young = (1 - out) * (0.45 + 0.55 * (1 - s));
    Vector3d colour = (1 - young) * color_vector(b.albedo) + young * color_vector(b.albedo_young);
    // Dries from the tip and the margins.
    const double dead = std::clamp(
        dry * 1.5 +
            0.5 * noise3(Vector3d(4 * s, 2 * place.y(), organ.rank), d_.own.colour_key) * dry,
        0.0, 1.0);
    const double streak =
        1 + 0.22 * noise3(Vector3d(2 * s, 12 * place.y(), 3.0 * organ.rank), d_.own.colour_key + 1);
    colour = (1 - rib) * streak * colour + rib * color_vector(b.albedo_midrib);
    colour = (1 - collar) * colour + collar * color_vector(c_.sheath.ligule_albedo);
    colour = (1 - dead) * colour + dead * color_vector(b.albedo_dry);
    organ.albedo.push_back(to_rgb(colour.cwiseQuotient(base).cwiseMin(1.0).cwiseMax(0.02)));
  }
}

}  // namespace cousin
