#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "sim/process/keeper.h"

namespace cousin {

/// A new, empty folder below the system's for temporary files, removed with all it holds,
/// also where this process is ended by a signal.
class ScratchFolder {
 public:
  /// @param name  what its own name starts with. @throws std::runtime_error if it cannot be made.
  explicit ScratchFolder(const std::string& name);
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  std::optional<Keeper> keeper_;
};

}  // namespace cousin
