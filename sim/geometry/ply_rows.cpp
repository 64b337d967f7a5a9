#include "sim/geometry/ply_rows.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <stdexcept>

namespace cousin::geometry {
namespace {

constexpr std::size_t kMostRows = std::size_t{1} << 26;

[[noreturn]] void fail_row(const std::string& name, const std::string& where,
                           const std::string& what) {
  throw std::runtime_error(name + ": " + where + ": " + what);
}

PlyType type_of(std::string_view text, const std::string& name, const std::string& where) {
  struct Row {
    std::string_view text;
    PlyType type;
  };
  constexpr std::array<Row, 16> kTypes = {{{"char", PlyType::i8},
                                           {"int8", PlyType::i8},
                                           {"uchar", PlyType::u8},
                                           {"uint8", PlyType::u8},
                                           {"short", PlyType::i16},
                                           {"int16", PlyType::i16},
                                           {"ushort", PlyType::u16},
                                           {"uint16", PlyType::u16},
                                           {"int", PlyType::i32},
                                           {"int32", PlyType::i32},
                                           {"uint", PlyType::u32},
                                           {"uint32", PlyType::u32},
                                           {"float", PlyType::f32},
                                           {"float32", PlyType::f32},
                                           {"double", PlyType::f64},
                                           {"float64", PlyType::f64}}};
  for (const Row& row : kTypes) {
    if (row.text == text) return row.type;
  }
  fail_row(name, where, "type \"" + std::string(text) + "\" is unknown");
}

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  for (std::size_t i = 0; i < line.size();) {
    const std::size_t start = line.find_first_not_of(" \t\r", i);
    if (start == std::string_view::npos) break;
    const std::size_t end = std::min(line.find_first_of(" \t\r", start), line.size());
    words.push_back(line.substr(start, end - start));
    i = end;
  }
  return words;
}

PlyEncoding encoding_of(std::string_view word, const std::string& name, const std::string& where) {
  if (word == "ascii") return PlyEncoding::ascii;
  if (word == "binary_little_endian") return PlyEncoding::little;
  if (word == "binary_big_endian") return PlyEncoding::big;
  fail_row(name, where, "format \"" + std::string(word) + "\" is unknown");
}

std::size_t count_of(std::string_view word, const std::string& name, const std::string& where) {
  std::size_t count = 0;
  const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), count);
  if (error != std::errc() || stop != word.data() + word.size() || count > kMostRows)
    fail_row(name, where, "the count \"" + std::string(word) + "\" is not in 0..2^26");
  return count;
}

PlyProperty property_of(const std::vector<std::string_view>& words, const std::string& name,
                        const std::string& where) {
  PlyProperty property;
  property.name = words.back();
  property.type = type_of(words[words.size() - 2], name, where);
  property.is_list = words.size() == 5;
  if (property.is_list) property.count_type = type_of(words[2], name, where);
  return property;
}

}  // namespace

std::size_t size_of(PlyType type) {
  constexpr std::array<std::size_t, 8> kSizes = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

PlyHeader parse_ply_header(std::string_view bytes, const std::string& name) {
  PlyHeader header;
  bool has_format = false;
  std::size_t at = 0;
  for (std::size_t line_number = 1;; ++line_number) {
    const std::size_t end = bytes.find('\n', at);
    const std::string where = "line " + std::to_string(line_number);
    if (end == std::string_view::npos || line_number > 1000)
      fail_row(name, where, "the header has no end_header");
    const std::string_view line = bytes.substr(at, end - at);
    const auto words = words_of(line);
    at = end + 1;
    if (line_number == 1) {
      if (words.size() != 1 || words[0] != "ply")
        fail_row(name, where, "a PLY file begins with \"ply\"");
      continue;
    }
    if (words.empty() || words[0] == "obj_info") continue;
    if (words[0] == "comment") {
      header.comments.emplace_back(
          words.size() > 1 ? std::string_view(words[1].data(), line.data() + line.size())
                           : std::string_view());
      continue;
    }
    if (words[0] == "end_header") break;
    if (words[0] == "format" && words.size() == 3) {
      has_format = true;
      header.encoding = encoding_of(words[1], name, where);
    } else if (words[0] == "element" && words.size() == 3) {
      header.elements.push_back({std::string(words[1]), count_of(words[2], name, where), {}});
    } else if (words[0] == "property" &&
               (words.size() == 3 || (words.size() == 5 && words[1] == "list"))) {
      if (header.elements.empty()) fail_row(name, where, "a property comes before any element");
      header.elements.back().properties.push_back(property_of(words, name, where));
    } else {
      fail_row(name, where, "expected format, element, property or end_header");
    }
  }
  if (!has_format) fail_row(name, "header", "there is no format line");
  header.body = at;
  return header;
}

std::size_t PlyBody::left_but_blanks() const {
  const std::size_t next = bytes_.find_first_not_of(" \t\r\n", at_);
  return next == std::string_view::npos ? 0 : bytes_.size() - next;
}

double PlyBody::text_number() {
  while (at_ < bytes_.size() && std::strchr(" \t\r\n", bytes_[at_])) ++at_;
  double value = 0;
  const char* begin = bytes_.data() + at_;
  const char* end = bytes_.data() + bytes_.size();
  if (begin < end && *begin == '+') ++begin;
  const auto [stop, error] = std::from_chars(begin, end, value);
  if (error != std::errc())
    fail_row(name_, where(), at_ == bytes_.size() ? "the file ends early" : "expected a number");
  at_ = static_cast<std::size_t>(stop - bytes_.data());
  return value;
}

template <class T>
double PlyBody::take() {
  if (left() < sizeof(T)) fail_row(name_, where(), "the file ends early");
  std::array<char, sizeof(T)> raw{};
  std::memcpy(raw.data(), bytes_.data() + at_, sizeof(T));
  at_ += sizeof(T);
  if ((encoding_ == PlyEncoding::big) == (std::endian::native == std::endian::little))
    std::reverse(raw.begin(), raw.end());
  return static_cast<double>(std::bit_cast<T>(raw));
}

double PlyBody::binary_number(PlyType type) {
  switch (type) {
    case PlyType::i8:
      return take<std::int8_t>();
    case PlyType::u8:
      return take<std::uint8_t>();
    case PlyType::i16:
      return take<std::int16_t>();
    case PlyType::u16:
      return take<std::uint16_t>();
    case PlyType::i32:
      return take<std::int32_t>();
    case PlyType::u32:
      return take<std::uint32_t>();
    case PlyType::f32:
      return take<float>();
    case PlyType::f64:
      break;
  }
  return take<double>();
}

std::size_t PlyBody::list_length(const PlyProperty& property) {
  const double length = number(property.count_type);
  if (!(length >= 0) || length > 4294967295.0 || length != std::floor(length))
    fail_row(name_, where(), "expected a whole number of 0 or more");
  const auto items = static_cast<std::size_t>(length);
  const std::size_t item = encoding_ == PlyEncoding::ascii ? 2 : size_of(property.type);
  if (items > (left() + 1) / item)
    fail_row(name_, where(), "the file is too short for a list of " + std::to_string(items));
  return items;
}

void PlyBody::require_rows(const PlyElementHeader& element) const {
  std::size_t least = 0;
  for (const PlyProperty& p : element.properties)
    least += encoding_ == PlyEncoding::ascii ? 2 : size_of(p.is_list ? p.count_type : p.type);
  if (element.count > 0 && (element.properties.empty() ||
                            element.count > (left() + 1) / std::max<std::size_t>(1, least))) {
    fail_row(name_, where(),
             "the file is too short for " + std::to_string(element.count) + " " + element.name);
  }
}

void skip_rows(const PlyElementHeader& element, PlyBody& body) {
  body.require_rows(element);
  for (std::size_t row = 0; row < element.count; ++row) {
    for (const PlyProperty& p : element.properties) {
      const std::size_t items = p.is_list ? body.list_length(p) : 1;
      for (std::size_t i = 0; i < items; ++i) body.number(p.type);
    }
  }
}

}  // namespace cousin::geometry
