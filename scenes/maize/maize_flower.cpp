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
void add_spikelets(CentreLine& line, double radius_m) {
  for (std::size_t i = 0; i < line.radii_m.size(); ++i) {
    const double s = static_cast<double>(i) / static_cast<double>(line.radii_m.size() - 1);
    const double bump = i % 2 == 0 ? 1.0 : 0.55;
    line.radii_m[i] = std::max(4e-4, radius_m * bump * std::min(1.0, 6 * s) * (1 - 0.6 * s));
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
      const double angle = c.angle_rad * (1 + 0.15 * std::sin(3.1 * k + whorl));
      growth.heading = (std::sin(angle) * out - std::cos(angle) * base.axes.col(0)).normalized();
      growth.length_m = here * (up_m / std::cos(angle) + 0.02);
      growth.radius_base_m = c.radius_m;
      growth.radius_tip_m = 0.7 * c.radius_m;
      growth.segments = 8;
      growth.tropisms.push_back({-Vector3d::UnitZ(), 0.4, 0});
      root.line = grow_axis(growth);
      finish_tube(draft.config, root, 8, c.albedo);
    }
  }
}

void add_tassel(MaizeDraft& draft) {
  const auto& c = draft.config.flower;
  const double share =
      grown_share(draft.stage, draft.config.plant.leaves - 0.5, draft.config.plant.leaves + 1);
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
    growth.radius_tip_m = 0.6 * growth.radius_base_m;
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
    const double turn = 2.4 * k + draft.own.azimuth_rad;
    const double up = is_spike ? 0 : 0.5 * (k - 1.0) / std::max(1, c.branches);
    const double angle = is_spike ? 0 : share * c.branch_angle_rad * (1.15 - 0.8 * up);
    AxisGrowth growth;
    growth.start_m = top_m + share * up * 0.35 * c.spike_m * heading;
    growth.heading =
        (std::cos(angle) * heading + std::sin(angle) * around(axes, turn)).normalized();
    growth.length_m =
        share * draft.own.vigour *
        (is_spike ? c.spike_m : c.branch_m * (1 - 0.5 * up) * (0.9 + 0.1 * std::sin(5.0 * k)));
    growth.segments = 24;
    growth.tropisms.push_back({-Vector3d::UnitZ(), is_spike ? 0.15 : 0.7, 0.2});
    branch.line = grow_axis(growth);
    add_spikelets(branch.line, (is_spike ? 1.3 : 1.0) * c.spikelet_m);
    finish_tube(draft.config, branch, 8, c.albedo);
    if (is_spike) plant.keypoints.push_back({"tassel tip", branch.line.points_m.back()});
  }
}

void add_ear(MaizeDraft& draft, const LineWalk& axis) {
  const auto& c = draft.config.flower;
  constexpr int kSilks = 14;
  const int rank = std::min(c.ear_rank, draft.config.plant.leaves);
  Plant& plant = draft.plant;
  Organ& ear = add_organ(plant, OrganKind::flower, "ear", 0, rank);
  ear.look = kStalkLook;
  const int ear_id = ear.id;
  const double share = rank < 1 ? 0
                                : grown_share(draft.stage, draft.config.plant.leaves - 2,
                                              draft.config.plant.leaves + 1.5);
  Vector3d tip_m = Vector3d::Zero(), heading = Vector3d::UnitZ();
  if (share > 0.05) {
    const auto r = static_cast<std::size_t>(rank - 1);
    const LinePoint base = axis.at_m(draft.stalk.nodes_m[r] + 0.01);
    const double azimuth = draft.own.leaves[r].azimuth_rad;
    const Vector3d out(std::cos(azimuth), std::sin(azimuth), 0);
    AxisGrowth growth;
    growth.start_m = base.point_m + base.radius_m * out;
    growth.heading = (std::cos(0.38) * base.axes.col(0) + std::sin(0.38) * out).normalized();
    growth.length_m = share * draft.own.vigour * c.ear_m;
    growth.segments = 20;
    ear.line = grow_axis(growth);
    for (std::size_t i = 0; i < ear.line.radii_m.size(); ++i) {
      const double s = static_cast<double>(i) / 20;
      ear.line.radii_m[i] =
          share * c.ear_radius_m *
          std::max(0.08, std::pow(std::sin(kPi * (0.12 + 0.88 * std::pow(s, 0.8))), 0.7));
    }
    finish_tube(draft.config, ear, 16, c.ear_albedo);
    tip_m = ear.line.points_m.back();
    heading = growth.heading;
  }
  const Eigen::Matrix3d axes =
      frames_along(std::vector<Vector3d>{Vector3d::Zero(), heading}, Vector3d::UnitX()).front();
  for (int k = 0; k < kSilks; ++k) {
    Organ& silk =
        add_organ(plant, OrganKind::flower, "silk " + std::to_string(k + 1), ear_id, k + 1);
    silk.look = kFlowerLook;
    if (share < 0.6) continue;
    AxisGrowth growth;
    growth.start_m = tip_m - 0.005 * heading;
    const double angle = 0.25 + 0.35 * std::abs(std::sin(7.0 * k));
    growth.heading =
        (std::cos(angle) * heading + std::sin(angle) * around(axes, 2.4 * k)).normalized();
    growth.length_m = 0.035 + 0.03 * std::abs(std::sin(4.3 * k));
    growth.radius_base_m = 5e-4;
    growth.radius_tip_m = 4e-4;
    growth.segments = 12;
    growth.tropisms.push_back({-Vector3d::UnitZ(), 2.0, 0.1});
    silk.line = grow_axis(growth);
    finish_tube(draft.config, silk, 4, c.silk_albedo);
  }
}

}  // namespace cousin
