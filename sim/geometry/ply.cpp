#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "sim/geometry/mesh_formats.h"

namespace cousin::geometry {
namespace {

enum class Encoding { ascii, little, big };
enum class Type { i8, u8, i16, u16, i32, u32, f32, f64 };

struct Property {
  std::string name;
  Type type = Type::f32;
  bool is_list = false;
  Type count_type = Type::u8;
};

std::size_t size_of(Type type) {
  constexpr std::array<std::size_t, 8> kSizes = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

[[noreturn]] void fail(const std::string& name, const std::string& where, const std::string& what) {
  throw std::runtime_error(name + ": " + where + ": " + what);
}

Type type_of(std::string_view text, const std::string& name, std::size_t line) {
  struct Row {
    std::string_view text;
    Type type;
  };
  constexpr std::array<Row, 16> kTypes = {{{"char", Type::i8},
                                           {"int8", Type::i8},
                                           {"uchar", Type::u8},
                                           {"uint8", Type::u8},
                                           {"short", Type::i16},
                                           {"int16", Type::i16},
                                           {"ushort", Type::u16},
                                           {"uint16", Type::u16},
                                           {"int", Type::i32},
                                           {"int32", Type::i32},
                                           {"uint", Type::u32},
                                           {"uint32", Type::u32},
                                           {"float", Type::f32},
                                           {"float32", Type::f32},
                                           {"double", Type::f64},
                                           {"float64", Type::f64}}};
  for (const Row& row : kTypes) {
    if (row.text == text) return row.type;
  }
  fail(name, "line " + std::to_string(line), "type \"" + std::string(text) + "\" is unknown");
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

/// Reads numbers of any type from the body, text or binary; never past its end.
class Body {
 public:
  Body(std::string_view bytes, std::size_t offset, Encoding encoding, const std::string& name)
      : bytes_(bytes), at_(offset), encoding_(encoding), name_(name) {}

  double number(Type type) {
    return encoding_ == Encoding::ascii ? text_number() : binary_number(type);
  }
  std::size_t left() const { return bytes_.size() - at_; }
  bool is_text() const { return encoding_ == Encoding::ascii; }
  std::string where() const { return "byte " + std::to_string(at_); }

 private:
  double text_number() {
    while (at_ < bytes_.size() && std::strchr(" \t\r\n", bytes_[at_])) ++at_;
    double value = 0;
    const char* begin = bytes_.data() + at_;
    const char* end = bytes_.data() + bytes_.size();
    if (begin < end && *begin == '+') ++begin;
    const auto [stop, error] = std::from_chars(begin, end, value);
    if (error != std::errc())
      fail(name_, where(), at_ == bytes_.size() ? "the file ends early" : "expected a number");
    at_ = static_cast<std::size_t>(stop - bytes_.data());
    return value;
  }
  template <class T>
  double take() {
    if (left() < sizeof(T)) fail(name_, where(), "the file ends early");
    std::array<char, sizeof(T)> raw{};
    std::memcpy(raw.data(), bytes_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    if ((encoding_ == Encoding::big) == (std::endian::native == std::endian::little))
      std::reverse(raw.begin(), raw.end());
    return static_cast<double>(std::bit_cast<T>(raw));
  }
  double binary_number(Type type) {
    switch (type) {
      case Type::i8:
        return take<std::int8_t>();
      case Type::u8:
        return take<std::uint8_t>();
      case Type::i16:
        return take<std::int16_t>();
      case Type::u16:
        return take<std::uint16_t>();
      case Type::i32:
        return take<std::int32_t>();
      case Type::u32:
        return take<std::uint32_t>();
      case Type::f32:
        return take<float>();
      case Type::f64:
        break;
    }
    return take<double>();
  }

  std::string_view bytes_;
  std::size_t at_;
  Encoding encoding_;
  const std::string& name_;
};

struct Header {
  Encoding encoding = Encoding::ascii;
  std::vector<PlyElement> elements;
  std::vector<std::vector<Property>> properties;  ///< of each element
  std::size_t body = 0;                           ///< offset of the first byte after end_header
};

Header parse_header(std::string_view bytes, const std::string& name) {
  Header header;
  bool has_format = false;
  std::size_t at = 0;
  for (std::size_t line_number = 1;; ++line_number) {
    const std::size_t end = bytes.find('\n', at);
    const std::string where = "line " + std::to_string(line_number);
    if (end == std::string_view::npos || line_number > 1000)
      fail(name, where, "the header has no end_header");
    const auto words = words_of(bytes.substr(at, end - at));
    at = end + 1;
    if (line_number == 1) {
      if (words.size() != 1 || words[0] != "ply")
        fail(name, where, "a PLY file begins with \"ply\"");
      continue;
    }
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "end_header") break;
    if (words[0] == "format" && words.size() == 3) {
      has_format = true;
      if (words[1] == "ascii")
        header.encoding = Encoding::ascii;
      else if (words[1] == "binary_little_endian")
        header.encoding = Encoding::little;
      else if (words[1] == "binary_big_endian")
        header.encoding = Encoding::big;
      else
        fail(name, where, "format \"" + std::string(words[1]) + "\" is unknown");
    } else if (words[0] == "element" && words.size() == 3) {
      PlyElement element;
      element.name = words[1];
      const auto [stop, error] =
          std::from_chars(words[2].data(), words[2].data() + words[2].size(), element.count);
      if (error != std::errc() || stop != words[2].data() + words[2].size() ||
          element.count > kMaxElements) {
        fail(name, where, "the count \"" + std::string(words[2]) + "\" is not in 0..2^26");
      }
      header.elements.push_back(std::move(element));
      header.properties.emplace_back();
    } else if (words[0] == "property" &&
               (words.size() == 3 || (words.size() == 5 && words[1] == "list"))) {
      if (header.elements.empty()) fail(name, where, "a property comes before any element");
      Property property;
      property.name = words.back();
      property.type = type_of(words[words.size() - 2], name, line_number);
      property.is_list = words.size() == 5;
      if (property.is_list) property.count_type = type_of(words[2], name, line_number);
      header.properties.back().push_back(property);
    } else {
      fail(name, where, "expected format, element, property or end_header");
    }
  }
  if (!has_format) fail(name, "header", "there is no format line");
  header.body = at;
  return header;
}

std::uint32_t whole(double value, Body& body, const std::string& name) {
  if (!(value >= 0) || value > 4294967295.0 || value != std::floor(value))
    fail(name, body.where(), "expected a whole number of 0 or more");
  return static_cast<std::uint32_t>(value);
}

void read_element(PlyElement& element, const std::vector<Property>& properties, Body& body,
                  const std::string& name) {
  // Each row takes at least this much: a count that the bytes cannot hold is refused before
  // anything is allocated.
  std::size_t least = 0;
  for (const Property& p : properties)
    least += body.is_text() ? 2 : size_of(p.is_list ? p.count_type : p.type);
  if (element.count > 0 &&
      (properties.empty() || element.count > (body.left() + 1) / std::max<std::size_t>(1, least))) {
    fail(name, body.where(),
         "the file is too short for " + std::to_string(element.count) + " " + element.name);
  }
  for (const Property& p : properties) {
    if (p.is_list) {
      const bool is_indices = p.name == "vertex_indices" || p.name == "vertex_index";
      if (is_indices || (element.name == "face" && element.list.empty())) element.list = p.name;
    } else {
      element.columns.push_back(p.name);
      element.is_float.push_back(p.type == Type::f32 || p.type == Type::f64);
      element.values.emplace_back(element.count);
    }
  }
  if (!element.list.empty()) element.lists.resize(element.count);
  for (std::size_t row = 0; row < element.count; ++row) {
    std::size_t column = 0;
    for (const Property& p : properties) {
      if (!p.is_list) {
        element.values[column++][row] = body.number(p.type);
        continue;
      }
      const std::uint32_t length = whole(body.number(p.count_type), body, name);
      const std::size_t item = body.is_text() ? 2 : size_of(p.type);
      if (length > (body.left() + 1) / item)
        fail(name, body.where(), "the file is too short for a list of " + std::to_string(length));
      const bool kept = p.name == element.list;
      for (std::uint32_t i = 0; i < length; ++i) {
        const double value = body.number(p.type);
        if (kept) element.lists[row].push_back(whole(value, body, name));
      }
    }
  }
}

}  // namespace

const std::vector<double>* PlyElement::column(std::string_view column_name) const {
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (columns[i] == column_name) return &values[i];
  }
  return nullptr;
}

const PlyElement* Ply::element(std::string_view element_name) const {
  for (const PlyElement& e : elements) {
    if (e.name == element_name) return &e;
  }
  return nullptr;
}

Ply parse_ply(std::string_view bytes, const std::string& name) {
  Header header = parse_header(bytes, name);
  Body body(bytes, header.body, header.encoding, name);
  for (std::size_t i = 0; i < header.elements.size(); ++i) {
    read_element(header.elements[i], header.properties[i], body, name);
  }
  return {std::move(header.elements)};
}

Mesh mesh_of_ply(const Ply& ply, const std::string& name) {
  const PlyElement* vertices = ply.element("vertex");
  if (!vertices) fail(name, "header", "there is no element \"vertex\"");
  const auto* x = vertices->column("x");
  const auto* y = vertices->column("y");
  const auto* z = vertices->column("z");
  if (!x || !y || !z) fail(name, "header", "vertices have no x, y and z");
  Mesh mesh;
  mesh.vertices_m.reserve(vertices->count);
  for (std::size_t i = 0; i < vertices->count; ++i) {
    mesh.vertices_m.emplace_back((*x)[i], (*y)[i], (*z)[i]);
    if (!mesh.vertices_m.back().allFinite())
      fail(name, "vertex " + std::to_string(i), "is not finite");
  }
  const PlyElement* faces = ply.element("face");
  if (!faces) return mesh;
  for (std::size_t i = 0; i < faces->lists.size(); ++i) {
    const auto& polygon = faces->lists[i];
    for (const std::uint32_t v : polygon) {
      if (v >= vertices->count) {
        fail(name, "face " + std::to_string(i),
             "vertex " + std::to_string(v) + " is not below " + std::to_string(vertices->count));
      }
    }
    for (std::size_t k = 2; k < polygon.size(); ++k)
      mesh.triangles.push_back({polygon[0], polygon[k - 1], polygon[k]});
  }
  return mesh;
}

}  // namespace cousin::geometry
