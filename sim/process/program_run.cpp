#include "sim/process/program_run.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <thread>

extern char** environ;

namespace cousin {
namespace fs = std::filesystem;
namespace {

using Clock = std::chrono::steady_clock;

/// Owns what posix_spawn is told to do with the files.
class FileActions {
 public:
  FileActions() { check(posix_spawn_file_actions_init(&actions_)); }
  ~FileActions() { posix_spawn_file_actions_destroy(&actions_); }
  FileActions(const FileActions&) = delete;
  FileActions& operator=(const FileActions&) = delete;
  void open(int descriptor, const char* file, int flags) {
    check(posix_spawn_file_actions_addopen(&actions_, descriptor, file, flags, 0644));
  }
  void copy(int from, int to) { check(posix_spawn_file_actions_adddup2(&actions_, from, to)); }
  const posix_spawn_file_actions_t* get() const { return &actions_; }

 private:
  static void check(int error) {
    if (error != 0) throw std::runtime_error("posix_spawn: " + std::string(std::strerror(error)));
  }
  posix_spawn_file_actions_t actions_{};
};

/// Our environment with some variables set.
std::vector<std::string> environment_with(
    const std::vector<std::pair<std::string, std::string>>& set) {
  std::vector<std::string> result;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string text = *entry;
    const bool is_set = std::any_of(set.begin(), set.end(), [&](const auto& variable) {
      return text.starts_with(variable.first + "=");
    });
    if (!is_set) result.push_back(text);
  }
  for (const auto& [name, value] : set) result.push_back(name + "=" + value);
  return result;
}

std::vector<char*> pointers(std::vector<std::string>& words) {
  std::vector<char*> result;
  for (std::string& word : words) result.push_back(word.data());
  result.push_back(nullptr);
  return result;
}

/// Ends the program and takes its status, so that nothing of it is left.
void kill_and_wait(pid_t child, int& status, rusage& usage) {
  kill(child, SIGKILL);
  while (wait4(child, &status, 0, &usage) < 0 && errno == EINTR) {
  }
}

/// @returns false if the limit was reached and the program was killed.
bool wait_for(pid_t child, double time_limit_s, const std::string& name, int& status,
              rusage& usage) {
  const Clock::time_point start = Clock::now();
  auto pause = std::chrono::microseconds(200);
  while (true) {
    const pid_t ended = wait4(child, &status, time_limit_s > 0 ? WNOHANG : 0, &usage);
    if (ended == child) return true;
    if (ended < 0 && errno != EINTR)
      throw std::runtime_error("waiting for \"" + name + "\": " + std::strerror(errno));
    if (ended < 0) continue;
    if (std::chrono::duration<double>(Clock::now() - start).count() > time_limit_s) {
      kill_and_wait(child, status, usage);
      return false;
    }
    std::this_thread::sleep_for(pause);
    pause = std::min(2 * pause, std::chrono::microseconds(20000));
  }
}

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

/// Makes the log, so that a folder that cannot be written to is not taken for a missing program.
void make_log(const fs::path& log) {
  std::ofstream out(log, std::ios::trunc);
  if (!out) throw std::runtime_error(log.string() + ": cannot be written");
}

}  // namespace

ProgramOutcome run_program(const ProgramCall& call) {
  if (call.words.empty()) throw std::invalid_argument("run_program: no program is named");
  const std::string& name = call.words.front();
  FileActions actions;
  actions.open(STDIN_FILENO, "/dev/null", O_RDONLY);
  if (call.log.empty()) {
    actions.copy(STDERR_FILENO, STDOUT_FILENO);
  } else {
    make_log(call.log);
    actions.open(STDOUT_FILENO, call.log.c_str(), O_WRONLY | O_APPEND);
    actions.copy(STDOUT_FILENO, STDERR_FILENO);
  }
  std::vector<std::string> words = call.words;
  std::vector<std::string> variables = environment_with(call.environment);
  const std::vector<char*> arguments = pointers(words), environment = pointers(variables);
  const Clock::time_point start = Clock::now();
  ProgramOutcome outcome;
  pid_t child = 0;
  const int error = posix_spawnp(&child, name.c_str(), actions.get(), nullptr, arguments.data(),
                                 environment.data());
  if (error != 0) {
    outcome.reason = "cannot start \"" + name + "\": " + std::strerror(error);
    return outcome;
  }
  int status = 0;
  rusage usage{};
  const bool in_time = wait_for(child, call.time_limit_s, name, status, usage);
  outcome.wall_s = std::chrono::duration<double>(Clock::now() - start).count();
  outcome.cpu_s = seconds(usage.ru_utime) + seconds(usage.ru_stime);
  if (!in_time) {
    outcome.end = ProgramEnd::timed_out;
    outcome.code = SIGKILL;
    std::ostringstream limit;
    limit << call.time_limit_s;
    outcome.reason = "\"" + name + "\" was stopped after its time limit of " + limit.str() + " s";
  } else if (WIFSIGNALED(status)) {
    outcome.end = ProgramEnd::signalled;
    outcome.code = WTERMSIG(status);
    outcome.reason = "\"" + name + "\" was ended by signal " + std::to_string(outcome.code);
  } else {
    outcome.end = ProgramEnd::exited;
    outcome.code = WEXITSTATUS(status);
    if (outcome.code != 0)
      outcome.reason = "\"" + name + "\" exited with " + std::to_string(outcome.code);
  }
  return outcome;
}

fs::path find_program(const std::string& name) {
  const auto executable = [](const fs::path& file) {
    std::error_code ignored;
    return fs::is_regular_file(file, ignored) && access(file.c_str(), X_OK) == 0;
  };
  if (name.empty()) return {};
  if (name.find('/') != std::string::npos) return executable(name) ? fs::path(name) : fs::path();
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (executable(fs::path(folder) / name)) return fs::path(folder) / name;
  }
  return {};
}

std::string last_lines(const fs::path& file, int count) {
  constexpr std::streamoff kTailBytes = 1 << 16;
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  if (!in) return "";
  const std::streamoff size = in.tellg();
  in.seekg(std::max<std::streamoff>(0, size - kTailBytes));
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) {
    if (!line.empty()) lines.push_back(line);
  }
  std::string text;
  const auto wanted = static_cast<std::size_t>(std::max(0, count));
  for (std::size_t i = lines.size() > wanted ? lines.size() - wanted : 0; i < lines.size(); ++i)
    text += "\n  " + lines[i].substr(0, 300);
  return text;
}

}  // namespace cousin
