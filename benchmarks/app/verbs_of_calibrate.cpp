// Calibration from photographs of a target.
#include <array>

#include "benchmarks/app/commands.h"

namespace cousin {

std::span<const Verb> module_verbs() {
  static constexpr auto kVerbs = std::to_array<Verb>({
      {"calibrate", command_calibrate, Reads::input},
  });
  return kVerbs;
}

}  // namespace cousin
