#include "sim/process/interruption.h"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <mutex>
#include <set>
#include <stdexcept>
#include <system_error>
#include <thread>

namespace cousin {
namespace fs = std::filesystem;
namespace {

struct Noted {
  std::mutex mutex;  ///< held to the end by the interruption
  std::set<pid_t> groups;
  std::set<fs::path> folders;
};

/// Never destroyed: an interruption may come while the process is ending.
Noted& noted() {
  static auto* const all = new Noted;
  return *all;
}

std::array<int, 2> signal_pipe = {-1, -1};

extern "C" void note_signal(int number) {
  const int error = errno;
  const auto byte = static_cast<unsigned char>(number);
  [[maybe_unused]] const auto written = write(signal_pipe[1], &byte, 1);
  errno = error;
}

/// Other threads may still write into it.
void remove_whole(const fs::path& folder) {
  constexpr int kTries = 50;
  std::error_code error;
  for (int i = 0; i < kTries; ++i) {
    fs::remove_all(folder, error);
    if (!fs::exists(fs::symlink_status(folder, error))) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

[[noreturn]] void end_by(int number) {
  noted().mutex.lock();
  for (const pid_t group : noted().groups) kill(-group, SIGKILL);
  for (const fs::path& folder : noted().folders) remove_whole(folder);
  signal(number, SIG_DFL);
  kill(getpid(), number);
  while (true) pause();
}

void await_signal() {
  unsigned char number = 0;
  while (true) {
    const auto count = read(signal_pipe[0], &number, 1);
    if (count == 1) end_by(number);
    if (count == 0 || errno != EINTR) return;
  }
}

}  // namespace

void clean_up_when_interrupted() {
  if (pipe2(signal_pipe.data(), O_CLOEXEC) != 0)
    throw std::system_error(errno, std::generic_category(), "a pipe for signals");
  std::thread(await_signal).detach();
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction action {};
    if (sigaction(number, nullptr, &action) != 0 || action.sa_handler == SIG_IGN) continue;
    action = {};
    action.sa_handler = note_signal;
    action.sa_flags = SA_RESTART;
    sigaction(number, &action, nullptr);
  }
}

namespace interruption {

void note_group(const std::function<pid_t()>& start) {
  const std::lock_guard lock(noted().mutex);
  if (const pid_t group = start(); group > 0) noted().groups.insert(group);
}

void forget_group(pid_t group, const std::function<void()>& end) {
  const std::lock_guard lock(noted().mutex);
  end();
  noted().groups.erase(group);
}

void note_folder(const std::function<fs::path()>& make) {
  const std::lock_guard lock(noted().mutex);
  if (fs::path folder = make(); !folder.empty()) noted().folders.insert(std::move(folder));
}

void forget_folder(const fs::path& folder) {
  const std::lock_guard lock(noted().mutex);
  noted().folders.erase(folder);
}

}  // namespace interruption
}  // namespace cousin
