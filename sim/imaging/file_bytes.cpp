#include "sim/imaging/file_bytes.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "sim/types/last_read.h"
#include "sim/types/whole_file.h"

namespace cousin::imaging {
namespace {

constexpr std::uint64_t kMaxFileBytes = std::uint64_t{1} << 31;

[[noreturn]] void fail(const std::filesystem::path& file, const char* doing, int code) {
  throw std::runtime_error("cannot " + std::string(doing) + " " + file.string() + ": " +
                           std::generic_category().message(code));
}

/// An open file descriptor.
class Descriptor {
 public:
  explicit Descriptor(int value) : value_(value) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() { close(); }
  int value() const { return value_; }
  bool close() {
    const int open = std::exchange(value_, -1);
    return open < 0 || ::close(open) == 0;
  }

 private:
  int value_;
};

}  // namespace

std::vector<std::uint8_t> read_bytes(const std::filesystem::path& file) {
  const Descriptor in(
      ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));  // a pipe must not block
  if (in.value() < 0) fail(file, "read", errno);
  struct stat status {};
  if (::fstat(in.value(), &status) != 0) fail(file, "read", errno);
  if (!S_ISREG(status.st_mode)) throw std::runtime_error(file.string() + ": not a regular file");
  const auto size = static_cast<std::uint64_t>(status.st_size);
  if (size > kMaxFileBytes) {
    throw std::runtime_error(file.string() + ": " + std::to_string(size) + " bytes; the limit is " +
                             std::to_string(kMaxFileBytes));
  }
  note_reading(file);
  std::vector<std::uint8_t> bytes(size);
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t count = ::read(in.value(), bytes.data() + done, bytes.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail(file, "read", errno);
    if (count == 0)
      throw std::runtime_error(file.string() + ": ends after " + std::to_string(done) + " bytes");
    done += static_cast<std::size_t>(count);
  }
  return bytes;
}

void replace_file(const std::filesystem::path& file, std::span<const std::uint8_t> bytes) {
  const WriteOutcome outcome =
      write_whole_file(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  if (outcome.making_folder) fail(file, "make the folder of", outcome.error);
  if (outcome.error != 0) fail(file, "write", outcome.error);
}

void check_image_size(const std::string& name, std::uint64_t width, std::uint64_t height) {
  constexpr std::uint64_t kMaxSide = 65535;
  constexpr std::uint64_t kMaxPixels = std::uint64_t{1} << 28;
  if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide ||
      width * height > kMaxPixels) {
    throw std::runtime_error(name + ": " + std::to_string(width) + " x " + std::to_string(height) +
                             " pixels; the limits are 1 to 65535 a side and 2^28 in all");
  }
}

}  // namespace cousin::imaging
