#pragma once

#include <initializer_list>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "benchmarks/app/options.h"

namespace cousin {

bool is_given(const Options& options, std::string_view option);
/// @throws std::invalid_argument naming the first of `names` that is given, and `why` it would not
/// be read.
void refuse_given(const Options& options, std::initializer_list<std::string_view> names,
                  const std::string& why);

/// An option that sets a configuration key, as --frames does with `views`.
struct KeyOption {
  std::string option, key, value;
  std::string assignment() const { return key + "=" + value; }
};

/// `--set`, then the options that set keys: they come last.
std::vector<std::string> assignments_of(const Options& options, const std::vector<KeyOption>& keys);

/// "--frames 20000: views = 20000: must be in [1, 10000]" of a message about that key.
std::string with_option_name(const std::string& message, const std::vector<KeyOption>& keys);

/// Whether a message begins with the name of --config, --pipeline-config or another TOML file.
bool is_of_configuration(const std::string& message, const Options& options);

/// Runs what reads a configuration. Mistakes in TOML files are configuration, not data; a key that
/// an option set is named with the option.
/// @throws std::invalid_argument
template <class Read>
auto read_config(const Options& options, const std::vector<KeyOption>& keys, const Read& read) {
  try {
    return read();
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(with_option_name(error.what(), keys));
  } catch (const std::runtime_error& error) {
    if (is_of_configuration(error.what(), options)) throw std::invalid_argument(error.what());
    throw;
  }
}

}  // namespace cousin
