#pragma once

#include "sim/config/fields.h"

namespace cousin {

/// Holds every number of a configuration against the limits that its field states.
/// @param name  put before the key in the message: "mvs", "fuse", ...
/// @throws std::invalid_argument naming key, value and limits for a number that is outside its
/// limits or not finite.
void require_within_limits(std::string_view name, const Fields& fields);

}  // namespace cousin
