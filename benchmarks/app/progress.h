#pragma once

#include <chrono>
#include <string>

#include "benchmarks/seeds/simulate.h"

namespace cousin {

/// A bar that redraws on a terminal, a plain line every few seconds elsewhere, nothing when quiet.
/// Goes to stderr.
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
  void clear();
  bool quiet_;
  bool terminal_;
  bool bar_shown_ = false;
  std::string last_what_;
  std::chrono::steady_clock::time_point last_;
};

}  // namespace cousin
