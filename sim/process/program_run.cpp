#include "sim/process/program_run.h"

#include <fcntl.h>
#include <signal.h>
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

#include "sim/process/interruption.h"
#include "sim/process/keeper.h"
#include "sim/process/spawn.h"
#include "sim/types/utf8.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

using Clock = std::chrono::steady_clock;

/// Waits until the program has ended or its time is over, and leaves its status to be taken.
/// @returns false if the limit was reached.
bool wait_for(pid_t child, double time_limit_s, const std::string& name) {
  const Clock::time_point start = Clock::now();
  auto pause = std::chrono::microseconds(200);
  while (true) {
    siginfo_t info{};
    const int options = WEXITED | WNOWAIT | (time_limit_s > 0 ? WNOHANG : 0);
    if (waitid(P_PID, static_cast<id_t>(child), &info, options) != 0) {
      if (errno == EINTR) continue;
      throw std::runtime_error("waiting for \"" + name + "\": " + std::strerror(errno));
    }
    if (info.si_pid == child) return true;
    if (std::chrono::duration<double>(Clock::now() - start).count() > time_limit_s) return false;
    std::this_thread::sleep_for(pause);
    pause = std::min(2 * pause, std::chrono::microseconds(20000));
  }
}

/// Ends what is left of the program's group and takes the program's status. The group's number is
/// nobody else's until then.
void end_group(pid_t child, int& status, rusage& usage) {
  interruption::forget_group(child, [&] {
    kill(-child, SIGKILL);
    while (wait4(child, &status, 0, &usage) < 0 && errno == EINTR) {
    }
  });
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
  SpawnFiles files;
  files.open(STDIN_FILENO, "/dev/null", O_RDONLY);
  if (call.log.empty()) {
    files.copy(STDERR_FILENO, STDOUT_FILENO);
  } else {
    make_log(call.log);
    files.open(STDOUT_FILENO, call.log.c_str(), O_WRONLY | O_APPEND);
    files.copy(STDOUT_FILENO, STDERR_FILENO);
  }
  const Clock::time_point start = Clock::now();
  ProgramOutcome outcome;
  pid_t child = -1;
  int error = 0;
  interruption::note_group([&] {
    error = spawn(call.words, call.environment, files, child);
    return error == 0 ? child : -1;
  });
  if (error != 0) {
    outcome.reason = "cannot start \"" + name + "\": " + std::strerror(error);
    return outcome;
  }
  int status = 0;
  rusage usage{};
  bool in_time = false;
  {
    const Keeper keeper("kill -s KILL -- -$1", std::to_string(child));
    in_time = wait_for(child, call.time_limit_s, name);
    end_group(child, status, usage);
  }
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
    text += " | " + cut_utf8(lines[i], 300);
  return text;
}

}  // namespace cousin
