#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace cousin {

/// Another program to run. No shell reads the words: a blank or a quote in one stays what it is.
struct ProgramCall {
  std::vector<std::string> words;  ///< the program, as `find_program` takes it, then its arguments
  std::vector<std::pair<std::string, std::string>> environment;  ///< set in it beside ours
  /// Takes what it prints on stdout and stderr, of earlier content nothing is left; empty: it goes
  /// to our stderr, as our stdout is for results.
  std::filesystem::path log;
  double time_limit_s = 0;  ///< it is killed then, with all that it started; 0 = none
};

/// `not_started`: there is no such program, or it may not be executed.
enum class ProgramEnd { exited, signalled, timed_out, not_started };

struct ProgramOutcome {
  ProgramEnd end = ProgramEnd::not_started;
  int code = -1;       ///< exit status, or the signal's number
  std::string reason;  ///< "" if it exited with 0; else what happened, the program's name in it
  double wall_s = 0;
  double cpu_s = 0;  ///< of the program and what it waited for
};
inline bool succeeded(const ProgramOutcome& outcome) {
  return outcome.end == ProgramEnd::exited && outcome.code == 0;
}

/// Runs the program to its end, its stdin empty. What it has started and left running is ended with
/// it, and all of them end with this process, however that ends.
/// @throws std::invalid_argument if there are no words; std::runtime_error if the log cannot be
/// made or the system does not let it wait.
ProgramOutcome run_program(const ProgramCall& call);

/// Where a program is: a name with a slash is the file itself, a bare one is looked up in PATH, as
/// a shell would. Empty if it is not there or may not be executed.
std::filesystem::path find_program(const std::string& name);

/// The last `count` lines that are not empty, each of at most 300 bytes, after a newline and
/// two blanks; of a file however long. "" if it cannot be read.
std::string last_lines(const std::filesystem::path& file, int count = 4);

}  // namespace cousin
