// Targets to print, and calibration from photographs of one.
#include <array>

#include "benchmarks/app/commands.h"

namespace cousin {

std::span<const Verb> module_verbs() {
  static constexpr auto kVerbs = std::to_array<Verb>({
      {"board", command_board},
      {"calibrate", command_calibrate, Reads::input},
  });
  return kVerbs;
}

}  // namespace cousin
