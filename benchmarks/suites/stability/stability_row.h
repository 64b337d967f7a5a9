#pragma once

#include <cmath>
#include <string>
#include <utility>

namespace cousin {

/// One line of the stability table: a measured quantity of a stiff or extreme case against its
/// limit.
struct StabilityRow {
  std::string case_name;
  std::string quantity;
  std::string unit;  ///< empty for counts and ratios
  double limit = 0;  ///< NaN: the value is shown only; if that is NaN too, it is not built in
  double value = 0;
  bool upper = true;  ///< the limit is an upper one: value <= limit passes; else value >= limit
  bool pass = false;  ///< NaN never passes
};

/// The larger of two numbers, and NaN once there was one, which std::max drops.
inline double worse(double a, double b) { return std::isnan(b) || b > a ? b : a; }

/// The smaller, likewise.
inline double lesser(double a, double b) { return std::isnan(b) || b < a ? b : a; }

/// A row with `pass` worked out.
inline StabilityRow make_row(std::string case_name, std::string quantity, std::string unit,
                             double limit, double value, bool upper = true) {
  const bool pass = upper ? value <= limit : value >= limit;
  return {std::move(case_name), std::move(quantity), std::move(unit), limit, value, upper, pass};
}

}  // namespace cousin
