#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <string>
#include <system_error>

#include "sim/geometry/mesh_formats.h"
#include "sim/types/memory_limit.h"

namespace cousin::geometry {
namespace fs = std::filesystem;
namespace {

/// 0 or the error number. Every step can meet a full disk, closing too.
int write_new(const fs::path& file, std::string_view bytes) {
  std::FILE* stream = std::fopen(file.c_str(), "wbx");
  if (!stream) return errno;
  int code = 0;
  if (std::fwrite(bytes.data(), 1, bytes.size(), stream) != bytes.size()) code = errno;
  if (code == 0 && (std::fflush(stream) != 0 || ::fsync(::fileno(stream)) != 0)) code = errno;
  if (std::fclose(stream) != 0 && code == 0) code = errno;
  return code;
}

}  // namespace

std::string read_whole(const fs::path& file) {
  constexpr std::uintmax_t kLargestFile = std::uintmax_t{1} << 32;
  std::error_code error;
  if (!fs::exists(file, error)) throw std::runtime_error(file.string() + ": no such file");
  if (!fs::is_regular_file(file, error))
    throw std::runtime_error(file.string() + ": not a regular file");
  const std::uintmax_t size = fs::file_size(file, error);
  if (error) throw std::runtime_error(file.string() + ": " + error.message());
  if (size > kLargestFile) {
    throw std::runtime_error(file.string() + ": " + std::to_string(size) + " bytes; the limit is " +
                             std::to_string(kLargestFile));
  }
  check_memory(file, size, "the file's bytes");
  std::ifstream stream(file, std::ios::binary);
  std::string bytes(size, '\0');
  if (!stream.read(bytes.data(), static_cast<std::streamsize>(size))) {
    throw std::runtime_error(file.string() + ": cannot be read");
  }
  return bytes;
}

void write_whole(const fs::path& file, std::string_view bytes) {
  std::error_code made;
  if (file.has_parent_path()) fs::create_directories(file.parent_path(), made);
  if (made)
    throw std::runtime_error("cannot make the folder of " + file.string() + ": " + made.message());
  // Process and counter keep two writers of the same file apart; the rename decides which one
  // stays.
  static std::atomic<unsigned> counter{0};
  std::string name = ".";
  name += file.filename().string() + "." + std::to_string(::getpid()) + "." +
          std::to_string(counter++) + ".part";
  const fs::path beside = file.parent_path() / name;
  int code = write_new(beside, bytes);
  if (code == 0 && std::rename(beside.c_str(), file.c_str()) != 0) code = errno;
  if (code == 0) return;
  if (code != EEXIST) std::remove(beside.c_str());
  throw std::runtime_error("cannot write " + file.string() + ": " +
                           std::generic_category().message(code));
}

}  // namespace cousin::geometry
