#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <type_traits>

namespace cousin {

/// Little-endian numbers and bytes, one after the other; ByteReader takes them again.
class ByteWriter {
 public:
  template <class Number>
  ByteWriter& add(const Number& value) {
    static_assert(std::is_arithmetic_v<Number>);
    return add(&value, sizeof value);
  }
  ByteWriter& add(const void* from, std::size_t size) {
    text.append(static_cast<const char*>(from), size);
    return *this;
  }
  std::string text;
};

/// Files that only this program writes and reads: a first line that names what it is, a body, and a
/// hash of both. `text` is the line, a line's end and the body, which may be large: it is not
/// copied. Written beside and renamed. @throws std::runtime_error naming the file
void write_sealed(const std::filesystem::path& file, std::string text);
/// The body. @throws std::runtime_error naming the file if it is above `limit_bytes`, has another
/// first line ("not a `what`"), or is cut off or altered
std::string read_sealed(const std::filesystem::path& file, std::string_view first_line,
                        std::string_view what, std::size_t limit_bytes);

}  // namespace cousin
