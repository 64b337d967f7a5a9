#include "benchmarks/report/shown_numbers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace cousin {

ShownUnit shown_unit(std::string_view unit, std::string_view metric) {
  if (unit == "m") return {"mm", 1e3};
  if (unit == "m2") return {"mm²", 1e6};
  if (unit == "m3") return {"mm³", 1e9};
  if (unit == "kg") return {"g", 1e3};
  if (unit == "rad") return {"°", 57.29577951308232};
  if (unit == "%") return {"%", 100};
  if (unit == "1") {
    for (const std::string_view ratio : {"mape", "coverage_68", "coverage_95", "share"}) {
      if (metric.ends_with(ratio)) return {"%", 100};
    }
    return {"", 1};
  }
  return {std::string(unit), 1};
}

std::string shown_number(double value) {
  if (std::isnan(value)) return "–";
  std::array<char, 64> buffer{};
  const double size = std::abs(value);
  if (size != 0 && std::isfinite(value) && size >= 1e-4 && size < 1e7) {
    const int digits = std::max(0, 2 - static_cast<int>(std::floor(std::log10(size))));
    std::snprintf(buffer.data(), buffer.size(), "%.*f", digits, value);
  } else {
    std::snprintf(buffer.data(), buffer.size(), "%.3g", value);
  }
  return buffer.data();
}

std::string shown_precisely(double value) {
  const double size = std::abs(value);
  if (!(size >= 10 && size < 1e4) || size == std::floor(size)) return shown_number(value);
  std::array<char, 32> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%.2f", value);
  return buffer.data();
}

std::string limit_text(const ScoreRow& row, const ShownUnit& unit) {
  if (!has_limit(row)) return {};
  const auto shown = [&](double value) {
    std::array<char, 32> buffer{};
    std::snprintf(buffer.data(), buffer.size(), "%.4g", value * unit.factor);
    return std::string(buffer.data());
  };
  const std::string name = unit.name.empty() ? "" : " " + unit.name;
  std::string text;
  if (std::isnan(row.limit_low)) {
    text = "at most " + shown(row.limit_high) + name;
  } else if (std::isnan(row.limit_high)) {
    text = "at least " + shown(row.limit_low) + name;
  } else if (row.limit_low == -row.limit_high) {
    text = "within " + shown(row.limit_high) + name;
  } else {
    text = shown(row.limit_low) + " to " + shown(row.limit_high) + name;
  }
  if (row.limit_n > 0) text += ", of " + std::to_string(row.limit_n) + " at least";
  return text;
}

std::string shown_interval(const WithInterval& value, double factor) {
  std::string text = shown_number(factor * value.value);
  if (std::isfinite(value.low) && std::isfinite(value.high)) {
    text +=
        " [" + shown_number(factor * value.low) + ", " + shown_number(factor * value.high) + "]";
  }
  return text;
}

}  // namespace cousin
