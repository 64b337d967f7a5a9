#include "benchmarks/app/progress.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <string>

#include "benchmarks/app/terminal.h"
#include "sim/types/utf8.h"

namespace cousin {
namespace {

using namespace std::chrono_literals;
constexpr auto kRedraw = 100ms;  ///< of a bar
constexpr auto kLines = 5s;      ///< between plain lines while work goes on
constexpr auto kTick = 1s;       ///< of a bar's clock while a step takes long
constexpr auto kStill = 30s;     ///< between plain lines while a step takes long

/// "0:41", "1:02:03".
std::string clock_text(double seconds) {
  const auto whole = static_cast<long long>(seconds + 0.5);
  char text[32];
  if (whole >= 3600)
    std::snprintf(text, sizeof text, "%lld:%02lld:%02lld", whole / 3600, whole / 60 % 60,
                  whole % 60);
  else
    std::snprintf(text, sizeof text, "%lld:%02lld", whole / 60, whole % 60);
  return text;
}

std::string numbers(const ProgressState& state) {
  std::string text = std::to_string(state.done) + "/" + std::to_string(state.total);
  if (state.gone_s >= 1) text += ", " + clock_text(state.gone_s);
  if (state.left_s >= 0) text += ", " + clock_text(state.left_s) + " left";
  return text;
}

double seconds(std::chrono::steady_clock::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

int terminal_columns() {
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

}  // namespace

std::string plain_text(const ProgressState& state) { return state.what + " " + numbers(state); }

std::string bar_text(const ProgressState& state, int columns) {
  constexpr int kWidth = 30;
  const int filled =
      state.total > 0
          ? std::clamp(static_cast<int>(static_cast<long long>(kWidth) * state.done / state.total),
                       0, kWidth)
          : 0;
  std::string bar(static_cast<std::size_t>(filled), '#');
  bar.resize(kWidth, '.');
  std::string name = state.what;
  if (name.size() < 10) name.resize(10, ' ');
  const auto most = static_cast<std::size_t>(std::max(columns - 1, 1));
  const std::string text = name + " [" + bar + "] " + numbers(state);
  return text.size() <= most ? text : cut_utf8(plain_text(state), most);
}

std::string StepClock::text(int done, int total) {
  if (first_ < 0) {
    first_ = done;
    began_ = std::chrono::steady_clock::now();
    return {};
  }
  const double gone_s = seconds(std::chrono::steady_clock::now() - began_);
  if (done <= first_ || gone_s < 1) return {};
  return ", " + clock_text(gone_s) + ", " + clock_text(gone_s * (total - done) / (done - first_)) +
         " left";
}

ProgressPrinter::ProgressPrinter(bool quiet)
    : quiet_(quiet), terminal_(isatty(STDERR_FILENO) != 0) {}

ProgressPrinter::~ProgressPrinter() {
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
    clear();
  }
  stop_.notify_all();
  if (ticker_.joinable()) ticker_.join();
}

void ProgressPrinter::clear() {
  if (bar_shown_) std::fputs("\r\033[K", stderr);
  bar_shown_ = false;
}

void ProgressPrinter::line(const std::string& text) {
  if (quiet_) return;
  const std::lock_guard lock(mutex_);
  clear();
  std::fprintf(stderr, "%s\n", terminal_text(text).c_str());
}

ProgressState ProgressPrinter::state() const {
  const auto now = Clock::now();
  ProgressState state{terminal_text(what_), done_, total_, seconds(now - list_began_)};
  const auto by_rate = [&](Clock::time_point began, int first) {
    const double gone_s = seconds(now - began);
    if (done_ > first && done_ <= total_ && gone_s >= 1)
      state.left_s = gone_s * (total_ - done_) / (done_ - first);
  };
  // Steps of one name take alike; so may jobs of a list. Stages, named "perceive: depth", do not.
  if (what_.find(": ") == std::string::npos) by_rate(list_began_, list_first_);
  by_rate(began_, first_);
  return state;
}

void ProgressPrinter::show() {
  last_ = Clock::now();
  if (!terminal_) {
    std::fprintf(stderr, "%s\n", plain_text(state()).c_str());
    return;
  }
  std::fprintf(stderr, "\r\033[K%s", bar_text(state(), terminal_columns()).c_str());
  std::fflush(stderr);
  bar_shown_ = true;
}

void ProgressPrinter::keep_showing() {
  std::unique_lock lock(mutex_);
  while (!stop_.wait_for(lock, kTick, [this] { return stopped_; })) {
    // A line that the verb has printed since stays as it is until the work goes on.
    const bool is_due = terminal_ ? bar_shown_ : Clock::now() - last_ >= kStill;
    if (is_due && done_ < total_) show();
  }
}

void ProgressPrinter::operator()(const std::string& what, int done, int total) {
  if (quiet_) return;
  const std::lock_guard lock(mutex_);
  const auto now = Clock::now();
  const bool is_new_list = total != total_ || done < done_ || what_.empty();
  const bool is_new = is_new_list || what != what_;
  if (is_new_list) {
    list_began_ = now;
    list_first_ = done;
  }
  if (is_new) {
    began_ = now;
    first_ = done;
    what_ = what;
  }
  done_ = done;
  total_ = total;
  const bool is_due = terminal_ ? now - last_ >= kRedraw : now - last_ >= kLines;
  if (is_new || is_due) show();
  if (!ticker_.joinable()) ticker_ = std::thread(&ProgressPrinter::keep_showing, this);
}

Progress ProgressPrinter::function() {
  return [this](const std::string& what, int done, int total) { (*this)(what, done, total); };
}

}  // namespace cousin
