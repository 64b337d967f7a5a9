#include <array>
#include <charconv>
#include <cstring>
#include <map>
#include <stdexcept>

#include "sim/geometry/mesh_formats.h"

namespace cousin::geometry {
namespace {

[[noreturn]] void fail(const std::string& name, const std::string& where, const std::string& what) {
  throw std::runtime_error(name + ": " + where + ": " + what);
}

/// Words of text one after another, with the line they stand on.
class Words {
 public:
  explicit Words(std::string_view text) : text_(text) {}
  std::string_view next() {
    while (at_ < text_.size() && std::strchr(" \t\r\n", text_[at_])) line_ += text_[at_++] == '\n';
    const std::size_t start = at_;
    while (at_ < text_.size() && !std::strchr(" \t\r\n", text_[at_])) ++at_;
    return text_.substr(start, at_ - start);
  }
  /// The next word of this line; empty at its end.
  std::string_view next_on_line() {
    while (at_ < text_.size() && std::strchr(" \t\r", text_[at_])) ++at_;
    if (at_ == text_.size() || text_[at_] == '\n') return {};
    return next();
  }
  void skip_line() {
    while (at_ < text_.size() && text_[at_] != '\n') ++at_;
  }
  std::string where() const { return "line " + std::to_string(line_); }

 private:
  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t line_ = 1;
};

double number(std::string_view word, const Words& words, const std::string& name) {
  double value = 0;
  const char* begin = word.data() + (word.starts_with('+') ? 1 : 0);
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(begin, end, value);
  if (word.empty() || error != std::errc() || stop != end || !(value - value == 0)) {
    fail(name, words.where(),
         "expected a finite number, not \"" + std::string(word.substr(0, 40)) + "\"");
  }
  return value;
}

/// Index of the vertex in "v", "v/vt", "v//vn" or "v/vt/vn"; negative counts from the end.
std::uint32_t obj_index(std::string_view word, std::size_t vertices, const Words& words,
                        const std::string& name) {
  const std::string_view text = word.substr(0, word.find('/'));
  long long index = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), index);
  const long long count = static_cast<long long>(vertices);
  if (error != std::errc() || stop != text.data() + text.size() || index == 0 || index > count ||
      index < -count) {
    fail(name, words.where(),
         "\"" + std::string(word.substr(0, 40)) + "\" is no vertex of the " +
             std::to_string(vertices) + " so far");
  }
  return static_cast<std::uint32_t>(index > 0 ? index - 1 : count + index);
}

/// "x y z", or "x y z r g b" with a colour, or "x y z w".
void read_obj_vertex(UserMesh& user, Words& words, const std::string& name) {
  Eigen::Vector3d v;
  for (int k = 0; k < 3; ++k) v[k] = number(words.next_on_line(), words, name);
  user.mesh.vertices_m.push_back(v);
  if (user.mesh.vertices_m.size() > kMaxElements)
    fail(name, words.where(), "more than 2^26 vertices");
  std::array<float, 3> colour{};
  std::size_t count = 0;
  for (auto word = words.next_on_line(); !word.empty() && count < 3; word = words.next_on_line())
    colour[count++] = static_cast<float>(number(word, words, name));
  if (count < 3) return;
  for (float& c : colour) {
    if (!(c >= 0 && c <= 1))
      fail(name, words.where(), "the colour " + std::to_string(c) + " is not in [0, 1]");
    c = linear_of_srgb(c);
  }
  user.vertex_albedo.push_back({colour[0], colour[1], colour[2]});
}

/// Parts by the o and g lines; a name that comes again is the same part.
class ObjParts {
 public:
  explicit ObjParts(UserMesh& user) : user_(user) {}
  void begin(const std::string& name) {
    part_ = number_of(name);
    is_named_ = true;
  }
  void add(std::size_t triangles, const Words& words, const std::string& name) {
    if (user_.part_names.empty()) part_ = number_of("");
    if (part_ > 65534) fail(name, words.where(), "more than 65535 objects and groups");
    user_.triangle_part.insert(user_.triangle_part.end(), triangles,
                               static_cast<std::uint16_t>(part_));
  }
  bool is_named() const { return is_named_; }

 private:
  std::size_t number_of(const std::string& name) {
    const auto [found, is_new] = numbers_.try_emplace(name, user_.part_names.size());
    if (is_new) user_.part_names.push_back(name);
    return found->second;
  }

  UserMesh& user_;
  std::map<std::string, std::size_t> numbers_;
  std::size_t part_ = 0;
  bool is_named_ = false;
};

constexpr std::size_t kStlHeader = 84;
constexpr std::size_t kStlTriangle = 50;

std::uint32_t stl_count(std::string_view bytes) {
  std::uint32_t count = 0;
  if (bytes.size() >= kStlHeader) std::memcpy(&count, bytes.data() + 80, 4);
  return count;
}

Mesh parse_binary_stl(std::string_view bytes, const std::string& name) {
  Mesh mesh;
  const std::uint32_t count = stl_count(bytes);
  mesh.vertices_m.reserve(std::size_t{3} * count);
  for (std::uint32_t i = 0; i < count; ++i) {
    std::array<float, 9> corner{};
    std::memcpy(corner.data(), bytes.data() + kStlHeader + kStlTriangle * i + 12, sizeof corner);
    const auto first = static_cast<std::uint32_t>(mesh.vertices_m.size());
    for (std::size_t k = 0; k < 3; ++k) {
      mesh.vertices_m.emplace_back(corner[3 * k], corner[3 * k + 1], corner[3 * k + 2]);
      if (!mesh.vertices_m.back().allFinite())
        fail(name, "triangle " + std::to_string(i), "is not finite");
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

Mesh parse_ascii_stl(std::string_view bytes, const std::string& name) {
  Words words(bytes);
  if (words.next() != "solid")
    fail(name, "line 1", "neither a binary STL of its size nor \"solid\"");
  Mesh mesh;
  bool closed = false;
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    if (word == "endsolid") closed = true;
    if (word != "vertex") continue;
    Eigen::Vector3d v;
    for (int k = 0; k < 3; ++k) v[k] = number(words.next(), words, name);
    mesh.vertices_m.push_back(v);
    const auto count = static_cast<std::uint32_t>(mesh.vertices_m.size());
    if (count % 3 == 0) mesh.triangles.push_back({count - 3, count - 2, count - 1});
  }
  if (!closed || mesh.vertices_m.size() % 3 != 0)
    fail(name, words.where(), "the file ends inside a triangle or before endsolid");
  return mesh;
}

}  // namespace

UserMesh parse_obj(std::string_view bytes, const std::string& name, std::size_t most_triangles) {
  UserMesh user;
  Mesh& mesh = user.mesh;
  ObjParts parts(user);
  Words words(bytes);
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    if (word == "v") {
      read_obj_vertex(user, words, name);
    } else if (word == "f") {
      std::vector<std::uint32_t> polygon;
      for (auto corner = words.next_on_line(); !corner.empty(); corner = words.next_on_line()) {
        polygon.push_back(obj_index(corner, mesh.vertices_m.size(), words, name));
      }
      if (polygon.size() < 3) fail(name, words.where(), "a face has fewer than 3 vertices");
      for (std::size_t k = 2; k < polygon.size(); ++k)
        mesh.triangles.push_back({polygon[0], polygon[k - 1], polygon[k]});
      if (mesh.triangles.size() > most_triangles) {
        fail(name, words.where(),
             "more than " + std::to_string(most_triangles) + " triangles, which is the limit");
      }
      parts.add(polygon.size() - 2, words, name);
    } else if (word == "o" || word == "g") {
      parts.begin(std::string(words.next_on_line().substr(0, 200)));
    }
    words.skip_line();
  }
  if (mesh.vertices_m.empty()) fail(name, words.where(), "there are no vertices");
  if (!user.vertex_albedo.empty() && user.vertex_albedo.size() != mesh.vertices_m.size()) {
    fail(name, words.where(),
         "colours at " + std::to_string(user.vertex_albedo.size()) + " of " +
             std::to_string(mesh.vertices_m.size()) + " vertices; all need one, or none");
  }
  if (!parts.is_named()) user.triangle_part.clear();
  if (!user.triangle_part.empty())
    name_parts(user);
  else
    user.part_names.clear();
  return user;
}

Mesh parse_stl(std::string_view bytes, const std::string& name) {
  // Binary files may begin with "solid" too: the size decides.
  const bool is_binary = bytes.size() >= kStlHeader &&
                         bytes.size() == kStlHeader + kStlTriangle * std::size_t{stl_count(bytes)};
  return is_binary ? parse_binary_stl(bytes, name) : parse_ascii_stl(bytes, name);
}

}  // namespace cousin::geometry
