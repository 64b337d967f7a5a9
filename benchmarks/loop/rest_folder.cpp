#include "benchmarks/loop/rest_folder.h"

#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/manifest.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kLimit_bytes = std::size_t{16} << 20;
constexpr std::size_t kHash_chars = 64;
constexpr std::size_t kName_chars = 32;
constexpr std::string_view kSum = "sha256 ";

/// Its first line is the hash of all that follows.
std::string sealed(const std::string& text) {
  return std::string(kSum) + sha256_hex(text) + "\n" + text;
}

std::string opened(const fs::path& file) {
  const std::string bytes = read_file(file, kLimit_bytes);
  const std::size_t head = kSum.size() + kHash_chars + 1;
  const std::string text = bytes.size() > head ? bytes.substr(head) : "";
  if (bytes != sealed(text))
    throw std::runtime_error(file.string() +
                             ": its sha256 is not that of its first line: it was cut off or "
                             "changed; delete it, and it is made anew");
  return text;
}

}  // namespace

fs::path RestFolder::file(const std::string& what, const char* extension) const {
  return folder_ / (sha256_hex(what).substr(0, kName_chars) + extension);
}

std::optional<RestStore::Kept> RestFolder::find(const std::string& what,
                                                const char* extension) const {
  const fs::path kept = file(what, extension);
  if (!fs::exists(kept)) return std::nullopt;
  return Kept{opened(kept), kept.string()};
}

void RestFolder::keep(const std::string& what, const char* extension,
                      const std::string& text) const {
  write_file(file(what, extension), sealed(text));
}

}  // namespace cousin
