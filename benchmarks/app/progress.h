#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

#include "benchmarks/loop/simulate.h"

namespace cousin {

/// Where long work is: what is done of how much, seconds gone and, once that can be told, seconds
/// left.
struct ProgressState {
  std::string what;
  int done = 0;
  int total = 0;
  double gone_s = 0;   ///< since the list of these steps began
  double left_s = -1;  ///< by the rate of like steps; below 0 = not known
};
/// "render 000000 12/60, 0:41, 2:40 left".
std::string plain_text(const ProgressState& state);
/// "render 000000 [######........................] 12/60, 0:41, 2:40 left", in `columns` at most.
std::string bar_text(const ProgressState& state, int columns);

/// Of steps that print lines of their own: "" at the first, then ", 0:41, 2:40 left".
class StepClock {
 public:
  std::string text(int done, int total);

 private:
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  int first_ = -1;
};

/// A bar that redraws on a terminal, a plain line every few seconds elsewhere, nothing when quiet.
/// Goes to stderr. Safe to call from several threads.
class ProgressPrinter {
 public:
  explicit ProgressPrinter(bool quiet);
  ~ProgressPrinter();
  ProgressPrinter(const ProgressPrinter&) = delete;
  ProgressPrinter& operator=(const ProgressPrinter&) = delete;
  void operator()(const std::string& what, int done, int total);
  void line(const std::string& text);  ///< a whole line, above the bar
  Progress function();                 ///< calls this printer, which must outlive it

 private:
  using Clock = std::chrono::steady_clock;
  void clear();
  void show();          ///< where the work is now
  void keep_showing();  ///< while a step takes long, until stopped
  ProgressState state() const;

  bool quiet_;
  bool terminal_;
  std::mutex mutex_;  ///< of all below
  bool bar_shown_ = false;
  std::string what_;
  int done_ = 0, total_ = 0;
  int list_first_ = 0, first_ = 0;  ///< done as the list, and these words, came first
  Clock::time_point list_began_, began_;
  Clock::time_point last_;  ///< when something was shown
  bool stopped_ = false;
  std::condition_variable stop_;
  std::thread ticker_;  ///< started by the first step
};

}  // namespace cousin
