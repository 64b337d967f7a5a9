#pragma once

namespace cousin {

/// Variance over repetitions of a normal error of standard deviation `sigma` after rounding to
/// multiples of `first` and then of `second` (0 = none), where the true values lie evenly between
/// the steps: the mean over 1024 evenly spread places of the exact variance there. The rest of
/// first^2 / 12 + second^2 / 12 repeats and counts as fixed.
double rounded_variance(double sigma, double first, double second);

/// sigma with rounded_variance(sigma, first, second) = variance, by bisection.
double unrounded_sigma(double variance, double first, double second);

}  // namespace cousin
