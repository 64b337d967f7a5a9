#include "sim/process/spawn.h"

#include <signal.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>

extern char** environ;

namespace cousin {
namespace {

void check(int error) {
  if (error != 0) throw std::runtime_error("posix_spawn: " + std::string(std::strerror(error)));
}

/// Owns how a new process starts.
class Attributes {
 public:
  Attributes() {
    check(posix_spawnattr_init(&attributes_));
    sigset_t none;
    sigemptyset(&none);
    check(posix_spawnattr_setsigmask(&attributes_, &none));
    check(posix_spawnattr_setpgroup(&attributes_, 0));
    check(posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK));
  }
  ~Attributes() { posix_spawnattr_destroy(&attributes_); }
  Attributes(const Attributes&) = delete;
  Attributes& operator=(const Attributes&) = delete;
  const posix_spawnattr_t* get() const { return &attributes_; }

 private:
  posix_spawnattr_t attributes_{};
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

}  // namespace

SpawnFiles::SpawnFiles() { check(posix_spawn_file_actions_init(&actions_)); }
SpawnFiles::~SpawnFiles() { posix_spawn_file_actions_destroy(&actions_); }
void SpawnFiles::open(int descriptor, const char* file, int flags) {
  check(posix_spawn_file_actions_addopen(&actions_, descriptor, file, flags, 0644));
}
void SpawnFiles::copy(int from, int to) {
  check(posix_spawn_file_actions_adddup2(&actions_, from, to));
}

int spawn(std::vector<std::string> words,
          const std::vector<std::pair<std::string, std::string>>& set, const SpawnFiles& files,
          pid_t& child) {
  std::vector<std::string> variables = environment_with(set);
  const std::vector<char*> arguments = pointers(words), environment = pointers(variables);
  const Attributes attributes;
  return posix_spawnp(&child, words.front().c_str(), files.get(), attributes.get(),
                      arguments.data(), environment.data());
}

}  // namespace cousin
