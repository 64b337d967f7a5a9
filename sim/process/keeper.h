#pragma once

#include <sys/types.h>

#include <string>

namespace cousin {

/// A shell beside this process that does something should this process end without destroying it,
/// in whatever way: SIGKILL leaves no time for it ourselves.
class Keeper {
 public:
  /// @param script  reads its argument as $1. @throws std::runtime_error if it cannot be started.
  Keeper(const std::string& script, const std::string& argument);
  ~Keeper();  ///< the script is not run
  Keeper(const Keeper&) = delete;
  Keeper& operator=(const Keeper&) = delete;

 private:
  int line_ = -1;  ///< to the shell; it sees the end of the file when the last holder ends
  pid_t shell_ = -1;
};

}  // namespace cousin
