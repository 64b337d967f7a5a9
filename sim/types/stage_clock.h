#pragma once

#include <string>

#include "sim/types/seams.h"

namespace cousin {

/// Measures one stage: wall time, CPU time of all threads of the process and of the programs that
/// it ran to their end meanwhile, and the peak memory of the process so far.
class StageClock {
 public:
  explicit StageClock(std::string stage);
  StageTiming finish() const;

 private:
  std::string stage_;
  double wall_start_s_;
  double cpu_start_s_;
};

double peak_rss_mb();     ///< largest resident set of this process so far, MiB
double current_rss_mb();  ///< resident now, MiB
/// Resident at the first call, MiB: the program makes it before any work, with its libraries
/// loaded.
double start_rss_mb();

}  // namespace cousin
