#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <string_view>

namespace cousin {

/// Breaks long lines, and prints of each verb the first sentence: its own help has the rest.
class HelpText : public CLI::Formatter {
 public:
  std::string make_subcommand(const CLI::App* verb) const override;
  std::string make_option_desc(const CLI::Option* option) const override;
};

/// What follows the options in a verb's help: options of all verbs, where it writes, examples.
std::string closing_text(std::string_view verb);
bool writes_files(std::string_view verb);

/// What to try first: for a command line without a verb.
std::string first_steps(const CLI::App& app);

}  // namespace cousin
