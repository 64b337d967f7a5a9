#pragma once

#include <array>
#include <span>
#include <vector>

#include "sim/types/mesh.h"

namespace cousin {

/// How much of several sheets passes through others of them.
struct SurfaceCrossing {
  double area_m2 = 0;     ///< of all sheets, one side
  double crossed_m2 = 0;  ///< of it, in triangles that meet another sheet's
  int pairs = 0;          ///< of sheets that meet
  double share() const { return area_m2 > 0 ? crossed_m2 / area_m2 : 0; }
};

/// Area where leaves pass through each other. Sheets have no thickness and cross along lines, so
/// their crossing has an area only at a resolution: counted is the area of the triangles, cut until
/// no edge is longer than `resolution_m`, that meet a triangle of another sheet. Triangles that
/// share a plane do not count as meeting.
/// @param sheet  of each triangle; negative = not counted.
/// @throws std::invalid_argument unless there is one number for each triangle and resolution_m > 0.
SurfaceCrossing surface_crossing(const Mesh& mesh, std::span<const int> sheet,
                                 double resolution_m = 0.002);

/// Whether two triangles share a point, other than by lying in one plane: an edge of one passes
/// through the other [Möller & Trumbore 1997].
bool triangles_meet(const std::array<Eigen::Vector3d, 3>& a,
                    const std::array<Eigen::Vector3d, 3>& b);

}  // namespace cousin
