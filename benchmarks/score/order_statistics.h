#pragma once

#include <span>
#include <vector>

namespace cousin {

/// All give NaN for no values. Sums run in the order given.
double mean(std::span<const double> values);
double rms(std::span<const double> values);
/// Linear between order statistics; probability in [0, 1]. Values must not be NaN.
double quantile(std::vector<double> values, double probability);

}  // namespace cousin
