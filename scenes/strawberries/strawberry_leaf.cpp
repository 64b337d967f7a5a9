#include "scenes/strawberries/strawberry_leaf.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/geometry/gradient_noise.h"
#include "sim/plant/blade_colours.h"
#include "sim/plant/color.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

BladeShape leaflet_shape(const StrawberryPlantConfig& config, const LeafPose& pose, double length_m,
                         double phase_rad) {
  const auto& l = config.leaf;
  BladeShape shape;
  const double open = smoothstep(0.0, l.open_age, pose.age);
  shape.width_m = length_m * l.width_share * (1 - l.opening_width + l.opening_width * open);
  shape.envelope_base = l.outline[0];
  shape.envelope_peak = l.outline[1];
  shape.envelope_rise = l.outline[2];
  shape.envelope_fall = l.outline[3];
  shape.envelope_tip = l.outline[4];
  shape.sweep_base_rad = l.sweep_base_rad;
  shape.sweep_tip_rad = l.sweep_tip_rad;
  shape.lobes = l.veins;  // without sinuses: side veins alone
  shape.lobe_depth = 0;
  shape.teeth = l.teeth;
  shape.teeth_depth = l.teeth_depth;
  shape.fold_rad = std::lerp(l.fold_young_rad, l.fold_rad, open);
  shape.camber = -l.camber * open;
  shape.wave_m = l.wave_m * pose.size;
  shape.wave_count = l.wave_count;
  shape.wave_phase_rad = phase_rad;
  shape.quilt_m = l.quilt_m * pose.size;
  return shape;
}

/// The petiole, and in its last steps the middle leaflet's own stalk.
CentreLine petiole_line(const StrawberryPlantConfig& config, const LeafPose& pose,
                        const Vector3d& blade) {
  const auto& l = config.leaf;
  AxisGrowth growth;
  growth.start_m = pose.base_m;
  growth.heading = {std::sin(pose.angle_rad) * std::cos(pose.azimuth_rad),
                    std::sin(pose.angle_rad) * std::sin(pose.azimuth_rad),
                    std::cos(pose.angle_rad)};
  growth.length_m = pose.petiole_m;
  growth.radius_base_m = l.petiole_thick[0] * std::sqrt(pose.size) * l.petiole_radius_m;
  growth.radius_tip_m = l.petiole_thick[1] * std::sqrt(pose.size) * l.petiole_radius_m;
  growth.segments = 14;
  growth.tropisms.push_back({-Vector3d::UnitZ(), pose.sag_rad, l.sag_begin});
  CentreLine line = grow_axis(growth);
  Vector3d heading = (line.points_m.back() - line.points_m[line.points_m.size() - 2]).normalized();
  constexpr int kSteps = 4;
  for (int i = 1; i <= kSteps; ++i) {
    heading = (heading + 0.6 * blade).normalized();
    line.points_m.push_back(line.points_m.back() + pose.size * l.petiolule_m / kSteps * heading);
    line.radii_m.push_back(0.8 * growth.radius_tip_m);
  }
  return line;
}

}  // namespace

void add_surface(OrganSurface& all, const OrganSurface& more) {
  const auto first = static_cast<std::uint32_t>(all.mesh.vertices_m.size());
  all.mesh.vertices_m.insert(all.mesh.vertices_m.end(), more.mesh.vertices_m.begin(),
                             more.mesh.vertices_m.end());
  for (const auto& t : more.mesh.triangles)
    all.mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  all.place.insert(all.place.end(), more.place.begin(), more.place.end());
}

LeafOrgans make_strawberry_leaf(const StrawberryPlantConfig& config, const LeafPose& pose) {
  const auto& l = config.leaf;
  const auto& s = config.surface;
  const Vector3d out(std::cos(pose.azimuth_rad), std::sin(pose.azimuth_rad), 0);
  const Vector3d level = Vector3d::UnitZ().cross(out);
  const Vector3d blade =
      std::cos(pose.droop_rad) * out - std::sin(pose.droop_rad) * Vector3d::UnitZ();
  const Vector3d side = Eigen::AngleAxisd(pose.roll_rad, blade) * level;
  const Vector3d upper = blade.cross(side);
  LeafOrgans leaf;
  leaf.petiole_line = petiole_line(config, pose, blade);
  leaf.petiole = tube_surface(leaf.petiole_line, s.sides);
  const std::size_t joint = leaf.petiole_line.points_m.size() - 5;  // where the petiolule begins
  const double open = smoothstep(0.0, l.open_age, pose.age);
  for (std::size_t k = 0; k < 3; ++k) {
    const double turn = (k == 0 ? 0 : (k == 1 ? 1 : -1)) * l.side_rad *
                        (l.folded_side + (1 - l.folded_side) * open);
    const Vector3d heading = Eigen::AngleAxisd(turn, upper) * blade;
    // The outer leaflets hang a little on their outer side.
    const Vector3d normal = Eigen::AngleAxisd(-l.side_roll * turn * open, blade) * upper;
    AxisGrowth growth;
    growth.start_m = k == 0 ? leaf.petiole_line.points_m.back() : leaf.petiole_line.points_m[joint];
    growth.heading = (heading - heading.dot(normal) * normal).normalized();
    growth.length_m = pose.size * l.leaflet_m * (k == 0 ? 1 : l.side_share);
    growth.radius_base_m = 0.0006;
    growth.radius_tip_m = 0.0002;
    growth.segments = 16;
    growth.curls.push_back({normal.cross(growth.heading), l.curl_rad * pose.age, l.curl_begin});
    leaf.midribs[k] = grow_axis(growth);
    leaf.shapes[k] = leaflet_shape(config, pose, growth.length_m, pose.phases_rad[k]);
    leaf.leaflets[k] =
        blade_surface(LineWalk(leaf.midribs[k], normal), leaf.shapes[k], s.rows, s.columns);
  }
  return leaf;
}

std::vector<Rgbf> leaflet_albedo(const StrawberryPlantConfig& config, const LeafPose& pose,
                                 const LeafOrgans& leaf, std::size_t k) {
  const auto& l = config.leaf;
  const double green = smoothstep(0.0, 0.35, pose.age), old = smoothstep(0.8, 1.3, pose.age);
  BladeColours colours;
  colours.lamina = (1 - green) * color_vector(l.albedo_young) + green * color_vector(l.albedo);
  colours.lamina = (1 - old) * colours.lamina + old * color_vector(l.albedo_old);
  colours.vein = (1 - green) * color_vector(l.albedo_young) + green * color_vector(l.albedo_vein);
  colours.base =
      brightest(l.albedo, l.albedo_young, l.albedo_vein).cwiseMax(color_vector(l.albedo_old));
  colours.vein_m = std::max(0.3, pose.size) * l.vein_width_m;
  colours.halo = 0.22;
  colours.length_m = length_m(leaf.midribs[k]);
  colours.key = pose.colour_key + k;
  return blade_albedo(leaf.leaflets[k], leaf.shapes[k], colours,
                      colours.length_m / config.surface.rows);
}

}  // namespace cousin
