#pragma once

#include <string>
#include <vector>

#include "benchmarks/score/trait_statistics.h"
#include "benchmarks/tools/measure/measured_table.h"

namespace cousin {

/// One trait of the seeds of one group, in the millimetres of its rows.
struct GroupTrait {
  std::string group, trait;
  std::string unit;  ///< of the trait, SI
  int seeds = 0;
  double mean = kNaN;
  double sd = kNaN;  ///< of what is measured
  /// Root mean square of the deviations that the measurement gives itself, which seeds do not
  /// share; NaN if some seed has none.
  double measurement_sd = kNaN;
  /// From seed to seed: what is left of `sd` without the measurement's; 0 where nothing is left.
  double seed_sd = kNaN;
  /// Seeds a group that see a difference of 2 % of the mean in 4 of 5 trials at a level of 5 %, two
  /// groups of this spread being compared [normal approximation]; 0 where that is not known.
  int seeds_for_two_percent = 0;
};

/// A later group's mean less the first one's.
struct GroupDifference {
  std::string trait;
  std::string unit;  ///< of the trait, SI
  std::string group, first;
  WithInterval difference;  ///< 95 % [Welch 1947], in millimetres
  WithInterval relative;    ///< over the first group's mean, a ratio
  double p_value = kNaN;    ///< two-sided
};

struct GroupComparison {
  std::vector<GroupTrait> traits;
  std::vector<GroupDifference> differences;
};

/// Groups are the rows' sources, in the order in which they come. Seeds are taken as independent;
/// the print's scale is not, and where two groups have different ones, its deviation is part of the
/// interval. @param scales  of each group, by name
GroupComparison compare_groups(const std::vector<MeasuredRow>& rows,
                               const std::vector<std::pair<std::string, PrintScale>>& scales);

}  // namespace cousin
