#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace cousin {

/// Reads little-endian numbers from the front of a file's bytes and knows where it is. Errors are
/// std::runtime_error "NAME: byte 12: ...". The bytes must outlive it.
class ByteReader {
 public:
  ByteReader(std::string_view bytes, std::string name)
      : all_(bytes.size()), rest_(bytes), name_(std::move(name)) {
    static_assert(std::endian::native == std::endian::little, "the files are little-endian");
  }

  template <class Number>
  Number take() {
    Number value;
    take(&value, sizeof value);
    return value;
  }
  void take(void* to, std::size_t size) {
    if (rest_.size() < size) throw std::runtime_error(where() + "the file ends here");
    std::memcpy(to, rest_.data(), size);
    rest_.remove_prefix(size);
  }
  std::size_t left() const { return rest_.size(); }
  /// A count of records of at least `least_bytes` each, which must fit into what is left.
  std::uint64_t count(std::size_t least_bytes) {
    const std::string here = where();
    const auto value = take<std::uint64_t>();
    if (value > rest_.size() / least_bytes) {
      throw std::runtime_error(here + "the count " + std::to_string(value) +
                               " needs more bytes than the " + std::to_string(rest_.size()) +
                               " that are left");
    }
    return value;
  }
  /// Up to a zero byte, which must come within `most_chars`.
  std::string text(std::size_t most_chars) {
    const std::size_t end = rest_.substr(0, most_chars + 1).find('\0');
    if (end == std::string_view::npos) {
      throw std::runtime_error(where() + "a name does not end within " +
                               std::to_string(most_chars) + " characters");
    }
    const std::string value(rest_.substr(0, end));
    rest_.remove_prefix(end + 1);
    return value;
  }
  /// At most as many as a `count` has said to be there.
  void skip(std::uint64_t bytes) { rest_.remove_prefix(static_cast<std::size_t>(bytes)); }
  std::string where() const {
    return name_ + ": byte " + std::to_string(all_ - rest_.size()) + ": ";
  }

 private:
  std::size_t all_;
  std::string_view rest_;
  std::string name_;
};

}  // namespace cousin
