#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace cousin {

/// What is wrong with the command line, in a sentence, and where to read more. A word that no verb
/// or option takes is named first: CLI11 would complain of what follows from it, such as one
/// positional argument too many.
std::string explain(const CLI::App& app, const CLI::ParseError& error);

}  // namespace cousin
