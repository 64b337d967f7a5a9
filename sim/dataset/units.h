#pragma once

#include <string_view>

namespace cousin {

/// A unit of a file in ours: a value times `factor` is in `si_unit`.
struct SiUnit {
  std::string_view si_unit;  ///< m, m2, m3, rad, kg, s or 1
  double factor = 1;         ///< exactly 1 for the SI unit itself
};

/// Private to sim/dataset: m, dm, cm, mm, um and their squares and cubes ("mm2", "mm^2", "mm²"),
/// ml and other litres, rad and deg, kg and g, s and ms, 1 and %.
/// @throws std::invalid_argument saying which units are read.
SiUnit si_unit(std::string_view unit);

}  // namespace cousin
