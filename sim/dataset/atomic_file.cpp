#include "sim/dataset/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <stdexcept>
#include <system_error>

#include "sim/types/last_read.h"
#include "sim/types/whole_file.h"

namespace cousin {
namespace {

[[noreturn]] void fail(const std::filesystem::path& file, const std::string& doing, int code) {
  throw std::runtime_error(file.string() + ": " + doing + ": " +
                           std::system_category().message(code));
}

/// Closes on scope exit.
class Descriptor {
 public:
  explicit Descriptor(int value) : value_(value) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (value_ >= 0) ::close(value_);
  }
  int get() const { return value_; }

 private:
  int value_;
};

}  // namespace

void write_file(const std::filesystem::path& file, std::string_view bytes) {
  const WriteOutcome outcome = write_whole_file(file, bytes);
  if (outcome.making_folder) fail(file.parent_path(), "cannot make the folder", outcome.error);
  if (outcome.error != 0) fail(file, "cannot write", outcome.error);
}

std::string read_file(const std::filesystem::path& file, std::size_t limit_bytes) {
  Descriptor in(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));  // a FIFO must not block
  if (in.get() < 0) fail(file, "cannot read", errno);
  struct stat status {};
  if (::fstat(in.get(), &status) != 0) fail(file, "cannot read", errno);
  if (!S_ISREG(status.st_mode)) throw std::runtime_error(file.string() + ": not a regular file");
  if (static_cast<std::size_t>(status.st_size) > limit_bytes) {
    throw std::runtime_error(file.string() + ": " + std::to_string(status.st_size) +
                             " bytes; the limit is " + std::to_string(limit_bytes));
  }
  note_reading(file);
  std::string bytes(static_cast<std::size_t>(status.st_size), '\0');
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t count = ::read(in.get(), bytes.data() + done, bytes.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail(file, "cannot read", errno);
    if (count == 0) break;
    done += static_cast<std::size_t>(count);
  }
  bytes.resize(done);
  return bytes;
}

bool is_temporary_name(std::string_view file_name) {
  return file_name.starts_with('.') &&
         (file_name.ends_with(".part") || file_name.ends_with(".tmp"));
}

std::filesystem::path resolve_inside(const std::filesystem::path& root,
                                     const std::filesystem::path& relative) {
  const auto refuse = [&](const std::string& why) {
    throw std::runtime_error(root.string() + ": the path \"" + relative.string() + "\" " + why);
  };
  if (relative.string().find('\0') != std::string::npos) {
    throw std::runtime_error(root.string() + ": a path with a zero byte");
  }
  if (relative.empty()) refuse("is empty");
  if (relative.is_absolute()) refuse("is absolute; it must lie inside the folder");
  if (std::find(relative.begin(), relative.end(), "..") != relative.end()) {
    refuse("has \"..\"; it must lie inside the folder");
  }
  std::error_code error;
  const std::filesystem::path base = std::filesystem::weakly_canonical(root, error);
  if (error) refuse("cannot be resolved: " + error.message());
  std::filesystem::path whole = std::filesystem::weakly_canonical(base / relative, error);
  if (error) refuse("cannot be resolved: " + error.message());
  if (std::mismatch(base.begin(), base.end(), whole.begin(), whole.end()).first != base.end()) {
    refuse("leads outside the folder by a symbolic link");
  }
  return whole;
}

}  // namespace cousin
