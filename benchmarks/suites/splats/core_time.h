#pragma once

#include <algorithm>
#include <ctime>

namespace cousin {

/// Seconds of a core that this thread has had.
inline double core_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Least core time of a call, of several: what the machine does beside it only adds.
template <class F>
double best_core_seconds(F call) {
  constexpr int kRepeats = 9;
  double best = 1e9;
  for (int i = 0; i < kRepeats; ++i) {
    const double before = core_seconds();
    call();
    best = std::min(best, core_seconds() - before);
  }
  return best;
}

}  // namespace cousin
