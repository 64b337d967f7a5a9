// What a first report needs: scenes to scores, and datasets.
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
      {"perceive", command_perceive},
      {"score", command_score},
      {"run", command_run},
      {"import", command_import},
      {"export", command_export},
      {"verify", command_verify},
      {"report", command_report},
  });
  return kVerbs;
}

}  // namespace cousin
