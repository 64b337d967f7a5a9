#include "benchmarks/app/progress.h"

#include <unistd.h>

#include <cstdio>
#include <string>

#include "benchmarks/app/terminal.h"
#include "sim/types/utf8.h"

namespace cousin {

ProgressPrinter::ProgressPrinter(bool quiet)
    : quiet_(quiet), terminal_(isatty(STDERR_FILENO) != 0) {}

ProgressPrinter::~ProgressPrinter() { clear(); }

void ProgressPrinter::clear() {
  if (bar_shown_) std::fputs("\r\033[K", stderr);
  bar_shown_ = false;
}

void ProgressPrinter::line(const std::string& text) {
  if (quiet_) return;
  clear();
  print_message(text);
}

void ProgressPrinter::operator()(const std::string& what, int done, int total) {
  if (quiet_) return;
  using namespace std::chrono_literals;
  const auto now = std::chrono::steady_clock::now();
  const bool is_new = what != last_what_;
  if (!is_new && now - last_ < (terminal_ ? 100ms : 5000ms)) return;
  last_ = now;
  last_what_ = what;
  if (!terminal_) {
    print_message(what + " " + std::to_string(done) + "/" + std::to_string(total));
    return;
  }
  constexpr int kWidth = 30;
  const int filled = total > 0 ? kWidth * done / total : 0;
  std::string bar(static_cast<std::size_t>(filled), '#');
  bar.resize(kWidth, '.');
  std::fprintf(stderr, "\r\033[K%-10s [%s] %d/%d", terminal_text(what).c_str(), bar.c_str(), done,
               total);
  std::fflush(stderr);
  bar_shown_ = true;
}

Progress ProgressPrinter::function() {
  return [this](const std::string& what, int done, int total) { (*this)(what, done, total); };
}

}  // namespace cousin
