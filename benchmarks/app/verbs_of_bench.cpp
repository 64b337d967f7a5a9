// The suites, and the pages that have their plots.
#include <array>

#include "benchmarks/app/commands.h"

namespace cousin {

std::span<const Verb> module_verbs() {
  static constexpr auto kVerbs = std::to_array<Verb>({
      {"bench", command_bench},
      {"report", command_report, Reads::input},
  });
  return kVerbs;
}

}  // namespace cousin
