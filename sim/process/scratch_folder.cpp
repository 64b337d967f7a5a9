#include "sim/process/scratch_folder.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <system_error>

#include "sim/process/interruption.h"

namespace cousin {
namespace fs = std::filesystem;

namespace {
/// What this process may still have written when it ended is gone after the second time.
constexpr const char* kRemove = "rm -rf -- \"$1\"; sleep 1; rm -rf -- \"$1\"";

/// @throws std::runtime_error naming it, if it is no folder
fs::path temporary_folder() {
  std::error_code error;
  const fs::path folder = fs::temp_directory_path(error);
  if (!error) return folder;
  const char* named = std::getenv("TMPDIR");
  throw std::runtime_error("the folder for temporary files" +
                           (named ? " (TMPDIR) " + std::string(named) : std::string()) + ": " +
                           error.message());
}
}  // namespace

ScratchFolder::ScratchFolder(const std::string& name) {
  std::string made = (temporary_folder() / (name + "-XXXXXX")).string();
  int error = 0;
  interruption::note_folder([&] {
    if (mkdtemp(made.data()) == nullptr) {
      error = errno;
      made.clear();
    }
    return fs::path(made);
  });
  if (made.empty()) {
    throw std::runtime_error("cannot make a folder in " + temporary_folder().string() + ": " +
                             std::strerror(error));
  }
  path_ = made;
  keeper_.emplace(kRemove, made);
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  interruption::forget_folder(path_);
}

}  // namespace cousin
