#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <stdexcept>

#include "sim/geometry/mesh_formats.h"
#include "sim/geometry/mesh_words.h"
#include "sim/types/memory_limit.h"
#include "sim/types/utf8.h"

namespace cousin::geometry {
namespace {

constexpr std::size_t kHeader = 84;
constexpr std::size_t kTriangle = 50;

std::string lower(std::string_view word) {
  std::string text(word.substr(0, 20));
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

std::uint32_t count_of(std::string_view bytes) {
  std::uint32_t count = 0;
  if (bytes.size() >= kHeader) std::memcpy(&count, bytes.data() + 80, 4);
  return count;
}

/// Binary files may begin with "solid" too. Four characters of a text, read as a number of
/// triangles, ask for more bytes than a file may have.
bool is_binary(std::string_view bytes) {
  if (bytes.size() < kHeader) return false;
  if (bytes.size() >= kHeader + kTriangle * std::size_t{count_of(bytes)}) return true;
  constexpr std::string_view kSolid = "solid";
  return lower(bytes.substr(0, kSolid.size())) != kSolid ||
         bytes.substr(0, kHeader).find('\0') != std::string_view::npos;
}

MeshFile parse_binary(std::string_view bytes, const std::string& name) {
  const std::uint32_t count = count_of(bytes);
  const std::size_t wanted = kHeader + kTriangle * std::size_t{count};
  const std::string counted = ": byte 80: a binary STL of " + std::to_string(count) + " triangles";
  if (bytes.size() < wanted) {
    throw std::runtime_error(name + counted + " has " + std::to_string(wanted) +
                             " bytes; this file has " + std::to_string(bytes.size()));
  }
  const std::size_t tail = bytes.size() - wanted;
  if (tail >= kTriangle) {
    throw std::runtime_error(name + counted + ", but " + std::to_string(tail) +
                             " bytes follow, enough for " + std::to_string(tail / kTriangle) +
                             " more; the count is wrong");
  }
  MeshFile file;
  if (tail > 0) {
    file.warnings.push_back(name + ": " + std::to_string(tail) + " bytes behind the last of " +
                            std::to_string(count) + " triangles are not read");
  }
  Mesh& mesh = file.user.mesh;
  check_memory(name,
               bytes.size() + std::uint64_t{count} *
                                  (3 * sizeof(Eigen::Vector3d) + sizeof(mesh.triangles.front())),
               std::to_string(count) + " triangles");
  mesh.vertices_m.reserve(std::size_t{3} * count);
  mesh.triangles.reserve(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    std::array<float, 9> corner{};
    std::memcpy(corner.data(), bytes.data() + kHeader + kTriangle * i + 12, sizeof corner);
    const auto first = static_cast<std::uint32_t>(mesh.vertices_m.size());
    for (std::size_t k = 0; k < 3; ++k) {
      mesh.vertices_m.emplace_back(corner[3 * k], corner[3 * k + 1], corner[3 * k + 2]);
      if (!mesh.vertices_m.back().allFinite())
        throw std::runtime_error(name + ": triangle " + std::to_string(i) + ": is not finite");
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return file;
}

/// The corners of one facet, up to its endloop.
void read_loop(MeshWords& words, Mesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices_m.size());
  std::string word;
  for (word = lower(words.next()); word == "vertex"; word = lower(words.next())) {
    Eigen::Vector3d v;
    for (int k = 0; k < 3; ++k) v[k] = words.number(words.next());
    mesh.vertices_m.push_back(v);
  }
  if (word != "endloop")
    words.fail("expected vertex or endloop, not \"" + readable_utf8(word) + "\"");
  const std::size_t corners = mesh.vertices_m.size() - first;
  if (corners != 3)
    words.fail("a facet has " + std::to_string(corners) + " corners; STL knows triangles alone");
  mesh.triangles.push_back({first, first + 1, first + 2});
}

MeshFile parse_text(std::string_view bytes, const std::string& name) {
  MeshWords words(bytes, name);
  if (lower(words.next()) != "solid") words.fail("neither a binary STL nor \"solid\"");
  words.skip_line();  // a name, which may be any words
  MeshFile file;
  bool is_open = true;
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    const std::string key = lower(word);
    if (key == "solid" || key == "endsolid") {
      is_open = key == "solid";
      words.skip_line();
    } else if (key == "loop") {
      read_loop(words, file.user.mesh);
    } else if (key == "vertex" || key == "endloop") {
      words.fail("\"" + key + "\" stands outside of a loop");
    }
  }
  if (is_open) words.fail("the file ends inside a triangle or before endsolid");
  return file;
}

}  // namespace

MeshFile parse_stl(std::string_view bytes, const std::string& name) {
  return is_binary(bytes) ? parse_binary(bytes, name) : parse_text(bytes, name);
}

}  // namespace cousin::geometry
