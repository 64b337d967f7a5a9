#include "benchmarks/app/terminal.h"

#include <cstdio>
#include <sstream>

#include "sim/types/utf8.h"

namespace cousin {

void print_message(const std::string& text) {
  std::fprintf(stderr, "%s\n", terminal_text(text).c_str());
}

void print_result_line(const std::string& text) {
  std::printf("%s\n", terminal_text(text).c_str());
}

void print_result_lines(const std::string& text) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) print_result_line(line);
}

}  // namespace cousin
