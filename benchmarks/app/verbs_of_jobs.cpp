// What a first report needs: from a scene to its scores.
#include <array>

#include "benchmarks/app/commands.h"

namespace cousin {

std::span<const Verb> module_verbs() {
  static constexpr auto kVerbs = std::to_array<Verb>({
      {"scenes", command_scenes},
      {"rigs", command_rigs},
      {"methods", command_methods},
      {"doctor", command_doctor},
      {"render", command_render},
      {"perceive", command_perceive, Reads::input},
      {"score", command_score, Reads::input},
      {"run", command_run},
      {"verify", command_verify, Reads::input},
      {"report", command_report, Reads::input},
  });
  return kVerbs;
}

}  // namespace cousin
