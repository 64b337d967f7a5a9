#pragma once

#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include "sim/config/fields.h"

namespace cousin {

/// A value of an enumeration and what it is called in files and on the command line.
template <class Choice>
struct Named {
  Choice value;
  std::string_view name;
};

/// @throws std::invalid_argument if the value is none of them
template <class Choice>
std::string_view name_in(std::span<const Named<Choice>> names, Choice value) {
  for (const Named<Choice>& each : names) {
    if (each.value == value) return each.name;
  }
  throw std::invalid_argument("value " + std::to_string(static_cast<int>(value)) +
                              " does not exist");
}

/// A field that these names set: another one is refused with all of them.
/// @param names  outlive the field
template <class Choice>
TextField choice_field(const char* key, std::span<const Named<Choice>> names, Choice& value) {
  return {
      [names, &value] { return std::string(name_in<Choice>(names, value)); },
      [key, names, &value](const std::string& text) {
        std::string all;
        for (const Named<Choice>& each : names) {
          if (text == each.name) {
            value = each.value;
            return;
          }
          all += (all.empty() ? "" : ", ") + std::string(each.name);
        }
        throw std::invalid_argument(std::string(key) + " \"" + text + "\" is not one of " + all);
      }};
}

}  // namespace cousin
