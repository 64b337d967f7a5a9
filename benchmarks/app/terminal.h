#pragma once

#include <string>

namespace cousin {

/// A line for people on stderr. What files, programs and users wrote into it reaches no terminal as
/// a command (`terminal_text`).
void print_message(const std::string& text);
/// A line of results on stdout, likewise.
void print_result_line(const std::string& text);
/// Several lines of results on stdout, each likewise. Whoever made the lines has shown the ends of
/// lines in the names of files in them (terminal_text).
void print_result_lines(const std::string& text);

}  // namespace cousin
