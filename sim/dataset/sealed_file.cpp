#include "sim/dataset/sealed_file.h"

#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/manifest.h"

namespace cousin {
namespace {

constexpr std::size_t kHash = 64;  ///< characters

}  // namespace

void write_sealed(const std::filesystem::path& file, std::string text) {
  text += sha256_hex(text);
  write_file(file, text);
}

std::string read_sealed(const std::filesystem::path& file, std::string_view first_line,
                        std::string_view what, std::size_t limit_bytes) {
  std::string text = read_file(file, limit_bytes);
  const std::size_t begin = first_line.size() + 1;
  if (text.size() < begin + kHash || !text.starts_with(first_line) || text[begin - 1] != '\n') {
    throw std::runtime_error(file.string() + ": not a " + std::string(what));
  }
  const std::size_t end = text.size() - kHash;
  if (sha256_hex(std::string_view(text).substr(0, end)) != std::string_view(text).substr(end)) {
    throw std::runtime_error(file.string() + ": the " + std::string(what) +
                             " is cut off or altered");
  }
  text.resize(end);
  text.erase(0, begin);
  return text;
}

}  // namespace cousin
