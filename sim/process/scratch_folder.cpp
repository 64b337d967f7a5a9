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
}  // namespace

ScratchFolder::ScratchFolder(const std::string& name) {
  std::string made = (fs::temp_directory_path() / (name + "-XXXXXX")).string();
  int error = 0;
  interruption::note_folder([&] {
    if (mkdtemp(made.data()) == nullptr) {
      error = errno;
      made.clear();
    }
    return fs::path(made);
  });
  if (made.empty()) {
    throw std::runtime_error("cannot make a folder in " + fs::temp_directory_path().string() +
                             ": " + std::strerror(error));
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
