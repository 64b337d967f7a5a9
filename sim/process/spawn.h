#pragma once

#include <fcntl.h>
#include <spawn.h>
#include <sys/types.h>

#include <string>
#include <utility>
#include <vector>

namespace cousin {

/// Owns what a new process is told to do with its files.
class SpawnFiles {
 public:
  SpawnFiles();
  ~SpawnFiles();
  SpawnFiles(const SpawnFiles&) = delete;
  SpawnFiles& operator=(const SpawnFiles&) = delete;
  void open(int descriptor, const char* file, int flags);
  void copy(int from, int to);
  const posix_spawn_file_actions_t* get() const { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_{};
};

/// Starts a program in a process group of its own, whose number is the child's: the program can be
/// ended with all that it starts.
/// @param set  variables of its environment beside ours. @returns 0, or the error's number.
int spawn(std::vector<std::string> words,
          const std::vector<std::pair<std::string, std::string>>& set, const SpawnFiles& files,
          pid_t& child);

}  // namespace cousin
