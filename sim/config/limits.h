#pragma once

#include <string_view>

#include "sim/config/fields.h"

namespace cousin {

/// Holds every single number of a configuration (not lists, not seeds) against the limits that its
/// field states.
/// @param name  put before the key in the message: "mvs", "fuse", ...; empty = the key alone
/// @throws std::invalid_argument naming key, value and limits for a number that is outside its
/// limits or not finite.
void check_limits(const Fields& fields, std::string_view name = {});

}  // namespace cousin
