#pragma once

#include <Eigen/Core>
#include <numbers>
#include <vector>

#include "sim/plant/centre_line.h"
#include "sim/types/mesh.h"

namespace cousin {

/// A sampled parametric surface.
struct OrganSurface {
  Mesh mesh;
  /// Of each vertex, for colouring: x along the organ, 0 at its base and 1 at its tip; y across: of
  /// a tube the turn about its axis in [0, 1], of a blade from -1 (left margin) to 1.
  std::vector<Eigen::Vector2d> place;
};

/// Round tube about a line, closed by a half-sphere-like cap at each end: watertight, outward.
/// @param sides  corners of the round section, at least 3
/// @throws std::invalid_argument for fewer sides or points.
OrganSurface tube_surface(const CentreLine& line, int sides);

/// A leaf blade's flat outline and how the sheet is bent. Rows start at the midrib and run out to
/// both margins, swept forward by an angle that goes from `sweep_base_rad` to `sweep_tip_rad`: a
/// row of a lobed leaf follows its side vein. A row at right angles (pi / 2 at both ends) makes the
/// plain leaf of a grass; more than that at the base makes a heart's two basal lobes.
struct BladeShape {
  double width_m = 0.02;  ///< of the widest row, both halves, along the row
  // Half width of a row = width_m / 2 * envelope * lobes; the envelope is
  // (base + (1 - base) (s / peak)^rise) up to `peak`, (1 - ((s - peak) / (1 - peak))^fall)^tip
  // beyond.
  double envelope_base = 0;  ///< at the base, over the widest
  double envelope_peak = 0.4;
  double envelope_rise = 0.5;
  double envelope_fall = 2;
  double envelope_tip = 1;  ///< 1: pointed, 0.5: round
  double sweep_base_rad = 0.5 * std::numbers::pi;
  double sweep_tip_rad = 0.5 * std::numbers::pi;
  int lobes = 0;           ///< a side
  double lobe_depth = 0;   ///< how far the sinuses cut, 0 .. 1
  double lobe_round = 1;   ///< above 1: narrow sinuses and broad lobes
  double teeth_depth = 0;  ///< the same on a scale of `teeth` a side
  int teeth = 0;
  // Bending of the sheet about the midrib's own line.
  double fold_rad = 0;    ///< each half is turned up about the midrib
  double camber = 0;      ///< margins lift by camber * y^2 / half width
  double wave_m = 0;      ///< amplitude of the margin's undulation
  double wave_count = 3;  ///< along the blade
  double wave_phase_rad = 0;
  double quilt_m = 0;    ///< bulge of the lamina between side veins
  double twist_rad = 0;  ///< of the tip about the midrib
};
/// @throws std::invalid_argument naming the value and its limit.
void validate(const BladeShape& shape);

/// Half width of a row over the widest, in [0, 1].
double row_share(const BladeShape& shape, double along);
/// Places of the side veins along the midrib, one a lobe.
std::vector<double> side_veins(const BladeShape& shape);

/// The sheet, open, without thickness; counter-clockwise seen from the upper side, which is where
/// the midrib's normals point.
/// @param rows  cells along the midrib  @param columns  cells from margin to margin, even
OrganSurface blade_surface(const LineWalk& midrib, const BladeShape& shape, int rows, int columns);

/// Sum of the triangles; of an open sheet one side.
double surface_area_m2(const Mesh& mesh);

}  // namespace cousin
