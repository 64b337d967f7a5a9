#pragma once

#include <string>
#include <string_view>

#include "benchmarks/score/scores.h"

namespace cousin {

/// How a unit is shown to people: metres in millimetres and so on.
struct ShownUnit {
  std::string name;   ///< "mm", "mm²", "°", "%", "" for a ratio
  double factor = 1;  ///< times the SI value
};
/// @param metric  ratios whose name ends in mape, coverage_68, ... are shown in per cent
ShownUnit shown_unit(std::string_view unit, std::string_view metric = {});

/// Three significant digits, no exponent between 1e-4 and 1e7; "–" for NaN.
std::string shown_number(double value);
/// For cards: two decimals of numbers from ten to ten thousand that are not whole, so that
/// 120.04 mm can be held against a publication; others as shown_number.
std::string shown_precisely(double value);
/// "at most 0.15 mm", "at least 90 %", "0.97 to 1.03", "within 0.03 mm" of a limit of a value whose
/// unit is shown so; "" without one.
std::string limit_text(const ScoreRow& row, const ShownUnit& unit);
/// "0.123 [0.101, 0.145]"; without the bracket where there is no interval.
std::string shown_interval(const WithInterval& value, double factor);

}  // namespace cousin
