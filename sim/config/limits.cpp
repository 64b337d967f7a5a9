#include "sim/config/limits.h"

#include <cmath>
#include <sstream>
#include <stdexcept>

namespace cousin {

void check_limits(const Fields& fields, std::string_view name) {
  for (const Field& field : fields) {
    double value = 0;
    if (const auto* number = std::get_if<double*>(&field.value)) {
      value = **number;
    } else if (const auto* count = std::get_if<int*>(&field.value)) {
      value = **count;
    } else {
      continue;
    }
    if (std::isfinite(value) && value >= field.min && value <= field.max) continue;
    std::ostringstream text;
    if (!name.empty()) text << name << ".";
    text << field.key << " = " << value << " is not within [" << field.min << ", " << field.max
         << "]";
    throw std::invalid_argument(text.str());
  }
}

}  // namespace cousin
