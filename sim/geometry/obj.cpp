#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <map>

#include "sim/geometry/mesh_formats.h"
#include "sim/geometry/mesh_words.h"
#include "sim/geometry/polygon.h"
#include "sim/types/memory_limit.h"
#include "sim/types/utf8.h"

namespace cousin::geometry {
namespace {

/// Statements whose surfaces are no polygons, and those that read other files: a mesh without them
/// is another mesh.
constexpr std::array<std::string_view, 10> kRefused = {"cstype", "curv", "curv2", "surf", "bsp",
                                                       "bzp",    "cdc",  "res",   "call", "csh"};

/// Index of the vertex in "v", "v/vt", "v//vn" or "v/vt/vn"; negative counts from the end.
std::uint32_t index_of(std::string_view word, std::size_t vertices, const MeshWords& words) {
  const std::string_view text = word.substr(0, word.find('/'));
  long long index = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), index);
  const long long count = static_cast<long long>(vertices);
  if (error != std::errc() || stop != text.data() + text.size() || index == 0 || index > count ||
      index < -count) {
    words.fail("\"" + readable_utf8(word.substr(0, 40)) + "\" is no vertex of the " +
               std::to_string(vertices) + " so far");
  }
  return static_cast<std::uint32_t>(index > 0 ? index - 1 : count + index);
}

/// Parts by the o and g lines; a name that comes again is the same part.
class ObjParts {
 public:
  explicit ObjParts(UserMesh& user) : user_(user) {}
  /// The whole line is the name: it may have blanks.
  void begin(MeshWords& words) {
    const std::string_view name = words.rest_of_line();
    if (!is_utf8(name)) {
      words.fail("the name \"" + readable_utf8(name.substr(0, 200)) +
                 "\" is not UTF-8; save the file as UTF-8 or rename the part");
    }
    part_ = number_of(cut_utf8(name, 200));
    is_named_ = true;
  }
  void add(std::size_t triangles, const MeshWords& words) {
    if (user_.part_names.empty()) part_ = number_of("");
    if (part_ > 65534) words.fail("more than 65535 objects and groups");
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

class ObjReader {
 public:
  ObjReader(std::string_view bytes, const std::string& name, std::size_t most_triangles)
      : words_(bytes, name, true), parts_(user_), most_triangles_(most_triangles) {}

  MeshFile read() {
    for (std::string_view word = words_.next(); !word.empty(); word = words_.next()) {
      if (word == "v") {
        read_vertex();
      } else if (word == "f" || word == "fo") {
        read_face();
      } else if (word == "o" || word == "g") {
        parts_.begin(words_);
      } else if (word == "mtllib" || word == "usemtl") {
        has_materials_ = true;
      } else if (std::find(kRefused.begin(), kRefused.end(), word) != kRefused.end()) {
        words_.fail("\"" + std::string(word) +
                    "\" is not read; save the mesh as polygons, in one file");
      }
      words_.skip_line();
    }
    finish();
    return {std::move(user_), std::move(warnings_)};
  }

 private:
  /// "x y z", or "x y z 1", or "x y z r g b" with a colour.
  void read_vertex() {
    std::array<double, 7> numbers{};
    std::size_t count = 0;
    for (auto word = words_.next_on_line(); !word.empty(); word = words_.next_on_line()) {
      numbers[count++] = words_.number(word);
      if (count == numbers.size()) break;
    }
    if (count != 3 && count != 4 && count != 6) {
      words_.fail("a vertex of " + std::string(count == 7 ? "7 or more" : std::to_string(count)) +
                  " numbers; 3, 4 (the last is the weight 1) or 6 (with a colour) are read");
    }
    if (count == 4 && numbers[3] != 1)
      words_.fail("the weight " + std::to_string(numbers[3]) + " of a vertex is not 1");
    make_room(user_.mesh.vertices_m, "vertices");
    user_.mesh.vertices_m.emplace_back(numbers[0], numbers[1], numbers[2]);
    if (user_.mesh.vertices_m.size() > kMaxElements) words_.fail("more than 2^26 vertices");
    if (count == 6) add_colour({numbers[3], numbers[4], numbers[5]});
  }

  void add_colour(const std::array<double, 3>& srgb) {
    std::array<float, 3> linear{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto value = static_cast<float>(srgb[k]);
      if (!(value >= 0 && value <= 1))
        words_.fail("the colour " + std::to_string(value) + " is not in [0, 1]");
      linear[k] = linear_of_srgb(value);
    }
    user_.vertex_albedo.push_back({linear[0], linear[1], linear[2]});
  }

  void read_face() {
    const std::size_t vertices = user_.mesh.vertices_m.size();
    polygon_.clear();
    for (auto corner = words_.next_on_line(); !corner.empty(); corner = words_.next_on_line())
      polygon_.push_back(index_of(corner, vertices, words_));
    if (polygon_.size() < 3) words_.fail("a face has fewer than 3 vertices");
    const PolygonTriangles cut = triangles_of_polygon(user_.mesh.vertices_m, polygon_);
    if (!cut.problem.empty()) words_.fail("face: " + cut.problem);
    auto& triangles = user_.mesh.triangles;
    for (const auto& triangle : cut.triangles) {
      make_room(triangles, "triangles");
      triangles.push_back(triangle);
    }
    if (triangles.size() > most_triangles_) {
      words_.fail("more than " + std::to_string(most_triangles_) +
                  " triangles, which is the limit");
    }
    parts_.add(cut.triangles.size(), words_);
  }

  /// Asks before a list is made twice as long.
  template <class T>
  void make_room(std::vector<T>& list, const char* what) {
    constexpr std::size_t kSmall = std::size_t{1} << 20;
    if (list.size() < kSmall || list.size() < list.capacity()) return;
    check_memory(words_.name(), 3 * std::uint64_t{list.size()} * sizeof(T),
                 "more than " + std::to_string(list.size()) + " " + what);
  }

  void finish() {
    const std::size_t vertices = user_.mesh.vertices_m.size();
    if (vertices == 0) words_.fail("there are no vertices");
    const std::size_t coloured = user_.vertex_albedo.size();
    if (coloured > 0 && coloured != vertices) {
      words_.fail("colours at " + std::to_string(coloured) + " of " + std::to_string(vertices) +
                  " vertices; all need one, or none");
    }
    if (!parts_.is_named()) user_.triangle_part.clear();
    if (!user_.triangle_part.empty())
      name_parts(user_);
    else
      user_.part_names.clear();
    if (has_materials_ && coloured == 0) {
      warnings_.push_back(words_.name() +
                          ": materials and textures (mtllib, usemtl) are not read: "
                          "the surface has the colour of the configuration");
    }
  }

  UserMesh user_;
  std::vector<std::string> warnings_;
  MeshWords words_;
  ObjParts parts_;
  std::size_t most_triangles_;
  std::vector<std::uint32_t> polygon_;
  bool has_materials_ = false;
};

}  // namespace

MeshFile parse_obj(std::string_view bytes, const std::string& name, std::size_t most_triangles) {
  return ObjReader(bytes, name, most_triangles).read();
}

}  // namespace cousin::geometry
