#include <fstream>
#include <stdexcept>
#include <string>
#include <system_error>

#include "sim/geometry/mesh_formats.h"
#include "sim/types/memory_limit.h"
#include "sim/types/whole_file.h"

namespace cousin::geometry {
namespace fs = std::filesystem;

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
  const WriteOutcome outcome = write_whole_file(file, bytes);
  if (outcome.error == 0) return;
  throw std::runtime_error(
      (outcome.making_folder ? "cannot make the folder of " : "cannot write ") + file.string() +
      ": " + std::generic_category().message(outcome.error));
}

}  // namespace cousin::geometry
