#include "sim/types/stage_clock.h"

#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include <fstream>
#include <utility>

namespace cousin {
namespace {

double clock_s(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Of this process, and of the programs that it has waited for.
double cpu_s() {
  rusage children{};
  getrusage(RUSAGE_CHILDREN, &children);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return clock_s(CLOCK_PROCESS_CPUTIME_ID) + seconds(children.ru_utime) +
         seconds(children.ru_stime);
}

}  // namespace

StageClock::StageClock(std::string stage)
    : stage_(std::move(stage)), wall_start_s_(clock_s(CLOCK_MONOTONIC)), cpu_start_s_(cpu_s()) {
  start_rss_mb();
}

StageTiming StageClock::finish() const {
  return {stage_, clock_s(CLOCK_MONOTONIC) - wall_start_s_, cpu_s() - cpu_start_s_, peak_rss_mb(),
          peak_rss_mb() - start_rss_mb()};
}

double peak_rss_mb() {
  // Not ru_maxrss where this can be read: it begins with the peak of the process that started us.
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    double kib = 0;
    if (word == "VmHWM:" && status >> kib) return kib / 1024;
  }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

double current_rss_mb() {
  std::ifstream file("/proc/self/statm");
  long total_pages = 0;
  long resident_pages = 0;
  file >> total_pages >> resident_pages;
  return static_cast<double>(resident_pages) * static_cast<double>(sysconf(_SC_PAGESIZE)) /
         (1 << 20);
}

double start_rss_mb() {
  static const double start_mb = current_rss_mb();
  return start_mb;
}

}  // namespace cousin
