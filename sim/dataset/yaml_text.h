#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace cousin {

/// Private to sim/dataset: scalars as readers of YAML 1.1 (PyYAML, yaml-cpp, OpenCV) and of
/// YAML 1.2 take them.

/// Digits that read back to the same double, with the dot that YAML 1.1 asks of a number with an
/// exponent: "2.0e-04" where "2e-04" is text. @throws std::invalid_argument unless it is finite.
std::string yaml_number(double value);
/// The numbers so, with ", " between them.
std::string yaml_numbers(const std::vector<double>& values);

/// The text in double quotes; what YAML does not print is escaped.
/// @throws std::runtime_error unless it is UTF-8.
std::string yaml_quoted(std::string_view text);
/// The text as it is if every reader takes it for text, else in double quotes: "no", "12:30",
/// "1_000", "a: b" and "" are something else without them.
std::string yaml_name(std::string_view text);

}  // namespace cousin
