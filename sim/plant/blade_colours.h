#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "sim/plant/organ_surface.h"
#include "sim/types/image.h"

namespace cousin {

/// Brightest of a blade's colours, channel by channel: the material's, of which vertices take
/// shares.
Eigen::Vector3d brightest(const std::vector<double>& a, const std::vector<double>& b,
                          const std::vector<double>& c);

/// How a blade is coloured.
struct BladeColours {
  Eigen::Vector3d lamina, vein, base;  ///< base: the material's
  double vein_m = 0;                   ///< width of the midrib
  double halo = 0;  ///< how far the veins' colour spreads into the lamina beside them
  double length_m = 0;
  std::uint64_t key = 0;
};

/// A share of the material's colour for each vertex: midrib and side veins, paler than the lamina
/// between them, which is mottled. @param cell_m  that a vertex stands for
std::vector<Rgbf> blade_albedo(const OrganSurface& surface, const BladeShape& shape,
                               const BladeColours& c, double cell_m);

}  // namespace cousin
