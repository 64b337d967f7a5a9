#include "benchmarks/suites/program/program_suite.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "sim/types/whole_file.h"

extern char** environ;

namespace cousin {
namespace {

constexpr int kStarts = 21;
constexpr double kStartLimit_s = 0.1, kRunLimit_s = 240, kRunLimit_bytes = 2e9;

struct ProcessCost {
  int exit_code = -1;
  double wall_s = 0;
  double cpu_s = 0;
  double peak_rss_bytes = ScoreRow::kNone;
};

/// Largest resident set of a running process so far; 0 when it has ended. (ru_maxrss begins with
/// the peak of the process that started it.)
double peak_rss_bytes(pid_t process) {
  std::ifstream status("/proc/" + std::to_string(process) + "/status");
  for (std::string word; status >> word;) {
    double kib = 0;
    if (word == "VmHWM:" && status >> kib) return 1024 * kib;
  }
  return 0;
}

enum class Watch { time, time_and_memory };

/// Runs a program with its output thrown away. Memory is looked at every 20 ms, and so misses what
/// the last 20 ms add.
ProcessCost run_process(std::vector<std::string> words, Watch watch) {
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  const auto start = std::chrono::steady_clock::now();
  pid_t child = 0;
  const int error = posix_spawn(&child, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) {
    throw std::runtime_error(words[0] + ": cannot be started: " + std::strerror(error));
  }
  ProcessCost cost;
  int status = 0;
  rusage usage{};
  for (;;) {
    const pid_t ended = wait4(child, &status, watch == Watch::time ? 0 : WNOHANG, &usage);
    if (ended == child) break;
    if (ended < 0 && errno != EINTR) {
      throw std::runtime_error(words[0] + ": was lost: " + std::strerror(errno));
    }
    if (ended != 0) continue;
    cost.peak_rss_bytes = std::fmax(cost.peak_rss_bytes, peak_rss_bytes(child));  // not NaN
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  cost.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  cost.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  cost.cpu_s = seconds(usage.ru_utime) + seconds(usage.ru_stime);
  return cost;
}

ScoreRow row_of(const std::string& case_name, const std::string& metric, double value,
                const std::string& unit, std::int64_t n, double most, const ProcessCost& cost) {
  ScoreRow row;
  row.suite = "program";
  row.scene = "seeds";
  row.case_name = case_name;
  row.method = "whole";
  row.metric = metric;
  row.value = value;
  row.unit = unit;
  row.n = n;
  row.wall_s = cost.wall_s;
  row.cpu_s = cost.cpu_s;
  row.peak_rss_mb = cost.peak_rss_bytes / (1 << 20);
  row = limited(row, at_most(most));
  if (cost.exit_code != 0) row.status = ScoreStatus::error;
  return row;
}

}  // namespace

ScoreFile program_suite(const std::filesystem::path& program, const std::filesystem::path& out,
                        const std::function<void(const std::string&, int, int)>& progress) {
  const auto say = [&](const std::string& what, int done) {
    if (progress) progress(what, done, 2);
  };
  ScoreFile file;
  say("start", 0);
  std::vector<ProcessCost> starts;
  for (int i = 0; i < kStarts; ++i) {
    starts.push_back(run_process({program.string(), "--help"}, Watch::time));
  }
  std::sort(starts.begin(), starts.end(),
            [](const ProcessCost& a, const ProcessCost& b) { return a.wall_s < b.wall_s; });
  ProcessCost median = starts[starts.size() / 2];
  for (const ProcessCost& start : starts) {
    if (start.exit_code != 0) median.exit_code = start.exit_code;
  }
  file.scores.push_back(
      row_of("cousin --help", "seconds.start", median.wall_s, "s", kStarts, kStartLimit_s, median));
  say("run seeds", 1);
  const std::filesystem::path folder = out / "run";
  remove_own_folder(folder);  // of an earlier measurement
  if (std::filesystem::exists(folder))
    throw std::invalid_argument(folder.string() +
                                " is in the way: it holds files that no `cousin bench program` "
                                "left there; move them away, or choose another --out");
  own_all_in(folder);
  const ProcessCost run =
      run_process({program.string(), "run", "seeds", "--quiet", "--out", folder.string()},
                  Watch::time_and_memory);
  file.scores.push_back(
      row_of("cousin run seeds", "seconds.wall", run.wall_s, "s", 1, kRunLimit_s, run));
  file.scores.push_back(
      row_of("cousin run seeds", "peak_rss", run.peak_rss_bytes, "B", 1, kRunLimit_bytes, run));
  return file;
}

}  // namespace cousin
