#pragma once

#include <span>
#include <string_view>

#include "sim/types/mesh.h"

namespace cousin {

/// Bodies that no prior of the measurement was written for or tuned on: bean, pea, lentil, wedge,
/// blob. Free shapes, the size of seeds.
std::span<const std::string_view> shape_names();
/// A closed mesh in metres. @throws std::invalid_argument for another name
Mesh shape_mesh(std::string_view name);

}  // namespace cousin
