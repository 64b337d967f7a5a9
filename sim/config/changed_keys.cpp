#include "sim/config/changed_keys.h"

#include <algorithm>

namespace cousin {

std::vector<std::string> changed_keys(const Fields& fields, const Fields& defaults,
                                      std::initializer_list<std::string_view> prefixes) {
  std::vector<std::string> keys;
  for (const Field& field : fields) {
    const auto is_of = [&](std::string_view prefix) { return field.key.starts_with(prefix); };
    if (std::none_of(prefixes.begin(), prefixes.end(), is_of)) continue;
    const auto same = std::find_if(defaults.begin(), defaults.end(),
                                   [&](const Field& other) { return other.key == field.key; });
    if (same == defaults.end() || to_toml({field}) != to_toml({*same})) keys.push_back(field.key);
  }
  return keys;
}

}  // namespace cousin
