#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "scenes/maize/maize_grower.h"
#include "sim/types/pi.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

Vector3d around(const Eigen::Matrix3d& axes, double azimuth) {
  return std::cos(azimuth) * axes.col(1) + std::sin(azimuth) * axes.col(2);
}

/// Radii of a spikelet-bearing branch: pairs of spikelets every few millimetres.
void add_spikelets(CentreLine& line, double radius_m, const MaizeConfig::Flower& c) {
  for (std::size_t i = 0; i < line.radii_m.size(); ++i) {
    const double s = static_cast<double>(i) / static_cast<double>(line.radii_m.size() - 1);
    const double bump = i % 2 == 0 ? 1.0 : c.spikelet_gap;
    line.radii_m[i] =
        std::max(4e-4, radius_m * bump * std::min(1.0, 6 * s) * (1 - c.spikelet_taper * s));
  }
}

/// Silks from the tip of an ear that has grown by `share`.
void add_silks(MaizeDraft& draft, int ear_id, const Vector3d& tip_m, const Vector3d& heading,
               double share) {
  const auto& c = draft.config.flower;
  const Eigen::Matrix3d axes =
      frames_along(std::vector<Vector3d>{Vector3d::Zero(), heading}, Vector3d::UnitX()).front();
  for (int k = 0; k < c.silks; ++k) {
    Organ& silk =
        add_organ(draft.plant, OrganKind::flower, "silk " + std::to_string(k + 1), ear_id, k + 1);
    silk.look = kFlowerLook;
    if (share < 0.6) continue;
    AxisGrowth growth;
    growth.start_m = tip_m - 0.005 * heading;
    const double angle = c.silk_angle_rad + c.silk_spread_rad * std::abs(std::sin(7.0 * k));
    growth.heading =
        (std::cos(angle) * heading + std::sin(angle) * around(axes, c.silk_divergence_rad * k))
            .normalized();
    growth.length_m = c.silk_m + c.silk_more_m * std::abs(std::sin(4.3 * k));
    growth.radius_base_m = c.silk_radius_m[0];
    growth.radius_tip_m = c.silk_radius_m[1];
    growth.segments = 12;
    growth.tropisms.push_back({-Vector3d::UnitZ(), c.silk_droop_rad, 0.1});
    silk.line = grow_axis(growth);
    finish_tube(draft.config, silk, 4, c.silk_albedo);
  }
}

}  // namespace

void add_prop_roots(MaizeDraft& draft, const LineWalk& axis) {
  const auto& c = draft.config.root;
  const double share = grown_share(draft.stage, c.begin_stage, c.full_stage);
  for (int whorl = 0; whorl < c.whorls; ++whorl) {
    for (int k = 0; k < c.count; ++k) {
      Organ& root = add_organ(
          draft.plant, OrganKind::root,
          "prop root " + std::to_string(whorl + 1) + "." + std::to_string(k + 1), 0, whorl + 1);
      root.look = kStalkLook;
      const double here = std::clamp(share * c.whorls - whorl, 0.0, 1.0);
      if (here <= 0.02) continue;
      const double up_m = c.height_m * (whorl + 1) / c.whorls;
      const LinePoint base = axis.at_m(draft.stalk.surface_m + up_m);
      const double azimuth = 2 * kPi * (k + 0.5 * whorl) / c.count + draft.own.azimuth_rad;
      const Vector3d out = around(base.axes, azimuth);
      AxisGrowth growth;
      growth.start_m = base.point_m + 0.7 * base.radius_m * out;
      const double angle = c.angle_rad * (1 + c.angle_spread * std::sin(3.1 * k + whorl));
      growth.heading = (std::sin(angle) * out - std::cos(angle) * base.axes.col(0)).normalized();
      growth.length_m = here * (up_m / std::cos(angle) + c.soil_m);
      growth.radius_base_m = c.radius_m;
      growth.radius_tip_m = c.taper * c.radius_m;
      growth.segments = 8;
      growth.tropisms.push_back({-Vector3d::UnitZ(), c.bend_rad, 0});
      root.line = grow_axis(growth);
      finish_tube(draft.config, root, 8, c.albedo);
    }
  }
}

void add_tassel(MaizeDraft& draft) {
  const auto& c = draft.config.flower;
  const double share = grown_share(draft.stage, draft.config.plant.leaves - c.begin_before,
                                   draft.config.plant.leaves + c.end_after);
  Plant& plant = draft.plant;
  const auto& points = draft.stalk.line.points_m;
  const Vector3d heading = (points.back() - points[points.size() - 2]).normalized();
  Organ& peduncle = add_organ(plant, OrganKind::stem, "peduncle", 0, draft.config.plant.leaves + 1);
  peduncle.look = kStalkLook;
  Vector3d top_m = points.back();
  if (share > 0.02) {
    AxisGrowth growth;
    growth.start_m = top_m;
    growth.heading = heading;
    growth.length_m = share * draft.own.vigour * c.peduncle_m;
    growth.radius_base_m = draft.stalk.line.radii_m.back();
    growth.radius_tip_m = c.peduncle_taper * growth.radius_base_m;
    growth.segments = 6;
    peduncle.line = grow_axis(growth);
    top_m = peduncle.line.points_m.back();
    finish_tube(draft.config, peduncle, 10, draft.config.stalk.albedo);
  }
  const int peduncle_id = peduncle.id;
  const Eigen::Matrix3d axes = frames_along(points, Vector3d::UnitX()).back();
  for (int k = 0; k <= c.branches; ++k) {
    const bool is_spike = k == 0;
    Organ& branch =
        add_organ(plant, OrganKind::flower,
                  is_spike ? "tassel spike" : "tassel branch " + std::to_string(k), peduncle_id, k);
    branch.look = kFlowerLook;
    if (share <= 0.02) continue;
    const double turn = c.branch_divergence_rad * k + draft.own.azimuth_rad;
    const double up = is_spike ? 0 : c.branch_up * (k - 1.0) / std::max(1, c.branches);
    const double angle =
        is_spike ? 0 : share * c.branch_angle_rad * (c.angle_low - c.angle_less * up);
    AxisGrowth growth;
    growth.start_m = top_m + share * up * c.branched_share * c.spike_m * heading;
    growth.heading =
        (std::cos(angle) * heading + std::sin(angle) * around(axes, turn)).normalized();
    growth.length_m = share * draft.own.vigour *
                      (is_spike ? c.spike_m
                                : c.branch_m * (1 - c.length_less * up) *
                                      (1 - c.branch_spread + c.branch_spread * std::sin(5.0 * k)));
    growth.segments = 24;
    growth.tropisms.push_back(
        {-Vector3d::UnitZ(), is_spike ? c.spike_droop_rad : c.branch_droop_rad, c.droop_begin});
    branch.line = grow_axis(growth);
    add_spikelets(branch.line, (is_spike ? c.spike_thick : 1.0) * c.spikelet_m, c);
    finish_tube(draft.config, branch, 8, c.albedo);
    if (is_spike) plant.keypoints.push_back({"tassel tip", branch.line.points_m.back()});
  }
}

void add_ear(MaizeDraft& draft, const LineWalk& axis) {
  const auto& c = draft.config.flower;
  const auto& o = c.ear_outline;
  const int rank = std::min(c.ear_rank, draft.config.plant.leaves);
  Plant& plant = draft.plant;
  Organ& ear = add_organ(plant, OrganKind::flower, "ear", 0, rank);
  ear.look = kStalkLook;
  const int ear_id = ear.id;
  const double share =
      rank < 1 ? 0
               : grown_share(draft.stage, draft.config.plant.leaves - c.ear_begin_before,
                             draft.config.plant.leaves + c.ear_end_after);
  Vector3d tip_m = Vector3d::Zero(), heading = Vector3d::UnitZ();
  if (share > 0.05) {
    const auto r = static_cast<std::size_t>(rank - 1);
    const LinePoint base = axis.at_m(draft.stalk.nodes_m[r] + c.ear_above_m);
    const double azimuth = draft.own.leaves[r].azimuth_rad;
    const Vector3d out(std::cos(azimuth), std::sin(azimuth), 0);
    AxisGrowth growth;
    growth.start_m = base.point_m + base.radius_m * out;
    growth.heading =
        (std::cos(c.ear_angle_rad) * base.axes.col(0) + std::sin(c.ear_angle_rad) * out)
            .normalized();
    growth.length_m = share * draft.own.vigour * c.ear_m;
    growth.segments = 20;
    ear.line = grow_axis(growth);
    for (std::size_t i = 0; i < ear.line.radii_m.size(); ++i) {
      const double s = static_cast<double>(i) / 20;
      ear.line.radii_m[i] =
          share * c.ear_radius_m *
          std::max(o[0], std::pow(std::sin(kPi * (o[1] + (1 - o[1]) * std::pow(s, o[2]))), o[3]));
    }
    finish_tube(draft.config, ear, 16, c.ear_albedo);
    tip_m = ear.line.points_m.back();
    heading = growth.heading;
  }
  add_silks(draft, ear_id, tip_m, heading, share);
}

}  // namespace cousin
