#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "sim/config/fields.h"

namespace cousin {

/// Keys that begin with one of `prefixes` and whose values are not those of `defaults`, a
/// configuration of the same type.
std::vector<std::string> changed_keys(const Fields& fields, const Fields& defaults,
                                      std::initializer_list<std::string_view> prefixes);

/// A sentence for each such key, that the method does not use it.
template <class Config>
std::vector<std::string> keys_without_effect(Config config, std::string_view method,
                                             std::initializer_list<std::string_view> prefixes) {
  Config defaults;
  std::vector<std::string> sentences;
  for (const std::string& key : changed_keys(fields(config), fields(defaults), prefixes))
    sentences.push_back(key + " is not used by method " + std::string(method));
  return sentences;
}

}  // namespace cousin
