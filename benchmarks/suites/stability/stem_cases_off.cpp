#include <limits>

#include "benchmarks/suites/stability/stem_cases.h"

namespace cousin {

std::vector<StabilityRow> stem_cases(bool /*quick*/) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  return {{"stems", "not built in: MuJoCo (WITH_MUJOCO=OFF)", "", nan, nan, true, false}};
}

}  // namespace cousin
