#include "benchmarks/app/option_keys.h"

#include <algorithm>

namespace cousin {

bool is_given(const Options& options, std::string_view option) {
  return std::find(options.given.begin(), options.given.end(), option) != options.given.end();
}

void refuse_given(const Options& options, std::initializer_list<std::string_view> names,
                  const std::string& why) {
  for (const std::string_view name : names) {
    if (is_given(options, name)) throw std::invalid_argument(std::string(name) + " " + why);
  }
}

std::vector<std::string> assignments_of(const Options& options,
                                        const std::vector<KeyOption>& keys) {
  std::vector<std::string> assignments = options.sets;
  for (const KeyOption& each : keys) assignments.push_back(each.assignment());
  return assignments;
}

bool is_of_configuration(const std::string& message, const Options& options) {
  for (const std::string& file : {options.config, options.pipeline_config}) {
    if (!file.empty() && message.starts_with(file + ":")) return true;
  }
  return message.substr(0, message.find(':')).ends_with(".toml");
}

std::string with_option_name(const std::string& message, const std::vector<KeyOption>& keys) {
  for (const KeyOption& each : keys) {
    const bool is_of_key = message.starts_with(each.key + " = ") ||
                           message.starts_with(each.key + " \"") ||
                           message.find("'" + each.key + "'") != std::string::npos;
    if (is_of_key) return each.option + " " + each.value + ": " + message;
  }
  return message;
}

}  // namespace cousin
