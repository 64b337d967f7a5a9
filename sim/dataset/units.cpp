#include "sim/dataset/units.h"

#include <array>
#include <numbers>
#include <stdexcept>
#include <string>

namespace cousin {
namespace {

struct Row {
  std::string_view name;
  SiUnit unit;
};

/// Lengths: their squares and cubes follow.
constexpr std::array<Row, 6> kLengths = {{{"m", {"m", 1}},
                                          {"dm", {"m", 1e-1}},
                                          {"cm", {"m", 1e-2}},
                                          {"mm", {"m", 1e-3}},
                                          {"um", {"m", 1e-6}},
                                          {"µm", {"m", 1e-6}}}};
constexpr std::array<double, 6> kAreas = {1, 1e-2, 1e-4, 1e-6, 1e-12, 1e-12};
constexpr std::array<double, 6> kVolumes = {1, 1e-3, 1e-6, 1e-9, 1e-18, 1e-18};

constexpr std::array<Row, 20> kOthers = {{{"l", {"m3", 1e-3}},
                                          {"L", {"m3", 1e-3}},
                                          {"dl", {"m3", 1e-4}},
                                          {"cl", {"m3", 1e-5}},
                                          {"ml", {"m3", 1e-6}},
                                          {"mL", {"m3", 1e-6}},
                                          {"ul", {"m3", 1e-9}},
                                          {"uL", {"m3", 1e-9}},
                                          {"µl", {"m3", 1e-9}},
                                          {"µL", {"m3", 1e-9}},
                                          {"rad", {"rad", 1}},
                                          {"deg", {"rad", std::numbers::pi / 180}},
                                          {"°", {"rad", std::numbers::pi / 180}},
                                          {"kg", {"kg", 1}},
                                          {"g", {"kg", 1e-3}},
                                          {"mg", {"kg", 1e-6}},
                                          {"s", {"s", 1}},
                                          {"ms", {"s", 1e-3}},
                                          {"1", {"1", 1}},
                                          {"%", {"1", 1e-2}}}};

/// 1 for "", 2 for "2", "^2" or "²", 3 likewise; 0 for anything else.
int power_of(std::string_view ending) {
  if (ending.empty()) return 1;
  if (ending == "2" || ending == "^2" || ending == "²") return 2;
  return ending == "3" || ending == "^3" || ending == "³" ? 3 : 0;
}

}  // namespace

SiUnit si_unit(std::string_view unit) {
  for (const Row& row : kOthers) {
    if (row.name == unit) return row.unit;
  }
  for (std::size_t i = 0; i < kLengths.size(); ++i) {
    if (!unit.starts_with(kLengths[i].name)) continue;
    const int power = power_of(unit.substr(kLengths[i].name.size()));
    if (power == 1) return kLengths[i].unit;
    if (power == 2) return {"m2", kAreas[i]};
    if (power == 3) return {"m3", kVolumes[i]};
  }
  throw std::invalid_argument(
      "is not a unit that is read: m, dm, cm, mm, um, their squares and cubes (m2, m3), l, dl, cl, "
      "ml, ul, rad, deg, kg, g, mg, s, ms, 1, %");
}

}  // namespace cousin
