#pragma once

#include <array>
#include <string_view>

namespace cousin {

/// A power of a length, as tables of sizes show it.
struct LengthUnit {
  std::string_view si;           ///< "m2"
  std::string_view millimetres;  ///< "mm2", in tables for programs
  std::string_view shown;        ///< "mm²", for people
  double factor = 1;             ///< from SI to millimetres
  int power = 0;                 ///< of a length
};
inline constexpr std::array<LengthUnit, 3> kLengthUnits = {
    {{"m", "mm", "mm", 1e3, 1}, {"m2", "mm2", "mm²", 1e6, 2}, {"m3", "mm3", "mm³", 1e9, 3}}};

/// That of an SI unit; another unit stays as it is and is no power of a length.
constexpr LengthUnit length_unit(std::string_view si) {
  for (const LengthUnit& unit : kLengthUnits) {
    if (unit.si == si) return unit;
  }
  return {si, si, si == "1" ? "" : si, 1, 0};
}

}  // namespace cousin
