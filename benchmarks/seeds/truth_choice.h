#pragma once

#include <string>
#include <string_view>

#include "sim/render/truth_pass.h"

namespace cousin {

/// Truth images by the names that `--truth` takes: a list such as "depth,part", "all" or "none".
/// @throws std::invalid_argument naming the word that is none of them, and those that exist.
TruthNeeds truth_needs_from_string(std::string_view text);

/// The names in a fixed order, "none" for none: equal choices give equal texts.
std::string to_string(const TruthNeeds& needs);

}  // namespace cousin
