#include "sim/types/last_read.h"

#include <mutex>

namespace cousin {
namespace {

std::mutex mutex;
/// Text that is there before memory is short.
std::string& noted() {
  static std::string file;
  return file;
}

}  // namespace

void note_reading(const std::filesystem::path& file) {
  const std::lock_guard lock(mutex);
  noted() = file.native();
}

std::string last_read() {
  const std::lock_guard lock(mutex);
  return noted();
}

}  // namespace cousin
