#pragma once

#include <vector>

#include "sim/truth/scene.h"

namespace cousin {

/// The instances that are scored, in the order of their ids; files and true seams number them so.
std::vector<const Instance*> specimens_of(const Scene& scene);

}  // namespace cousin
