// Sensor presets from recordings.
#include <array>

#include "benchmarks/app/commands.h"

namespace cousin {

std::span<const Verb> module_verbs() {
  static constexpr auto kVerbs = std::to_array<Verb>({
      {"fit-sensor", command_fit_sensor, Reads::input},
  });
  return kVerbs;
}

}  // namespace cousin
