#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "sim/types/rng.h"

namespace cousin {

/// A trait of one specimen, measured and true, in the same unit.
struct TraitPair {
  double truth = 0;
  double measured = 0;
  double sigma =
      std::numeric_limits<double>::quiet_NaN();  ///< reported standard deviation; NaN = not given
  std::string run;  ///< specimens of one run share poses, light and scale: they are drawn together
};

/// A number with its 95 % interval; NaN where it is not defined.
struct WithInterval {
  double value = std::numeric_limits<double>::quiet_NaN();
  double low = std::numeric_limits<double>::quiet_NaN();
  double high = std::numeric_limits<double>::quiet_NaN();
};

struct BootstrapConfig {
  int resamples = 2000;
};

/// How well a trait is measured. With e = measured - true, over the n pairs:
struct TraitStatistics {
  int n = 0;
  int runs = 0;
  bool by_run =
      false;  ///< false: one run only, so the interval is over specimens and misses what they share
  WithInterval rmse;   ///< sqrt(mean e^2), unit of the trait
  WithInterval mape;   ///< mean |e / true|, a ratio; NaN if a true value is 0
  WithInterval bias;   ///< mean e
  WithInterval slope;  ///< of the least-squares line measured = slope * true + intercept
  WithInterval intercept;
  WithInterval r2_about_true_mean;  ///< 1 - sum e^2 / sum (true - mean true)^2
  WithInterval r2_paper;  ///< 1 - sum e^2 / sum (measured - mean measured)^2, as in the seeds paper
  WithInterval limit_low;   ///< bias - 1.96 sd(e): 95 % limits of agreement [Bland & Altman 1986]
  WithInterval limit_high;  ///< bias + 1.96 sd(e)
};

/// Statistics with bootstrap intervals. Whole runs are drawn with replacement (specimens if there
/// is one run); the percentiles are widened for the few runs there are, to Phi(-+ sqrt(k / (k - 1))
/// t_{k-1}) [Hesterberg, "What Teachers Should Know About the Bootstrap", 2015: expanded percentile
/// interval]. Deterministic in the pairs and `rng`, whatever the order of the pairs within and
/// between runs.
/// @throws std::invalid_argument if a value is not finite.
TraitStatistics trait_statistics(std::span<const TraitPair> pairs, Rng rng,
                                 const BootstrapConfig& config = {});

/// How honest reported sigmas are: the share of true values inside measured +- 1 sigma and +- 1.96
/// sigma, which ought to be 68.3 % and 95 %, with Wilson's interval. Pairs without a sigma do not
/// count.
struct SigmaCoverage {
  int n = 0;
  WithInterval within_68;
  WithInterval within_95;
  double normalised_rms =
      std::numeric_limits<double>::quiet_NaN();  ///< rms of e / sigma; 1 if honest
  /// Mean width of the 95 % intervals over the RMSE; 3.92 where errors are normal and sigmas right.
  double width_over_rmse = std::numeric_limits<double>::quiet_NaN();
};
SigmaCoverage sigma_coverage(std::span<const TraitPair> pairs);

/// Two methods on the same specimens.
struct PairedMeasurement {
  double truth = 0;
  double measured_a = 0;
  double measured_b = 0;
  std::string run;
};
struct PairedComparison {
  int n = 0;
  int runs = 0;
  WithInterval rmse_ratio;           ///< RMSE of a over RMSE of b; below 1: a is better
  WithInterval absolute_difference;  ///< mean |e_a| - |e_b|
  double t = std::numeric_limits<double>::quiet_NaN();  ///< of the paired t-test on |e_a| - |e_b|
  double p_value =
      std::numeric_limits<double>::quiet_NaN();  ///< two-sided; takes specimens as independent
};
/// Intervals as in `trait_statistics`. @throws std::invalid_argument if a value is not finite.
PairedComparison compare_paired(std::span<const PairedMeasurement> pairs, Rng rng,
                                const BootstrapConfig& config = {});

}  // namespace cousin
