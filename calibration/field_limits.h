#pragma once

#include "sim/config/fields.h"

namespace cousin {

/// @throws std::invalid_argument naming key, value and limits for a number that is not within its
/// limits or not finite.
void check_limits(const Fields& fields);

}  // namespace cousin
