#include <limits>

#include "benchmarks/suites/stability/contact_cases.h"

namespace cousin {

std::vector<StabilityRow> contact_cases(bool /*quick*/) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  return {{"contacts", "not built in: MuJoCo (WITH_MUJOCO=OFF)", "", nan, nan, true, false}};
}

}  // namespace cousin
