#pragma once

#include <array>

#include "benchmarks/app/commands.h"

namespace cousin {

/// From a scene to its scores: the verbs of the first part, and of the part with every scene.
inline constexpr auto kJobVerbs = std::to_array<Verb>({
    {"scenes", command_scenes},
    {"rigs", command_rigs},
    {"methods", command_methods},
    {"doctor", command_doctor},
    {"render", command_render},
    {"perceive", command_perceive, Reads::input},
    {"score", command_score, Reads::input},
    {"run", command_run},
    {"measure", command_measure, Reads::input},
    {"verify", command_verify, Reads::input},
    {"report", command_report, Reads::input},
    {"ledger", command_ledger, Reads::input},
});

}  // namespace cousin
