#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <cstdio>
#include <string>
#include <unordered_map>
#include <vector>

#include "sim/geometry/measure.h"

namespace cousin {
namespace {

/// Directed edge; `forward` where the triangle runs from the smaller index to the larger.
struct Edge {
  std::uint32_t low = 0, high = 0;
  bool forward = true;
  auto key() const { return std::pair(low, high); }
};

std::string edge_name(const Edge& edge) {
  return "edge " + std::to_string(edge.low) + "-" + std::to_string(edge.high);
}

std::vector<Edge> sorted_edges(const Mesh& mesh) {
  std::vector<Edge> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (const auto& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), a < b});
    }
  }
  std::sort(edges.begin(), edges.end(),
            [](const Edge& a, const Edge& b) { return a.key() < b.key(); });
  return edges;
}

/// Finite vertices and valid indices, or what is wrong.
std::string check_numbers(const Mesh& mesh) {
  if (mesh.triangles.empty()) return "no triangles";
  for (std::size_t i = 0; i < mesh.vertices_m.size(); ++i) {
    if (!mesh.vertices_m[i].allFinite()) return "vertex " + std::to_string(i) + " is not finite";
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const std::uint32_t index : mesh.triangles[t]) {
      if (index < mesh.vertices_m.size()) continue;
      return "triangle " + std::to_string(t) + " names vertex " + std::to_string(index) +
             "; there are " + std::to_string(mesh.vertices_m.size());
    }
  }
  return "";
}

/// @param volume_m3  0, negative or not a number
std::string volume_problem(double volume_m3) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.6g", volume_m3);
  if (volume_m3 < 0) {
    return "it is turned inside out: its triangles face inward, and its volume is " +
           std::string(text.data()) + " m3; flip its faces";
  }
  return "it is closed but holds nothing: its volume is " + std::string(text.data()) + " m3";
}

bool repeats_a_vertex(const std::array<std::uint32_t, 3>& t) {
  return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

using Bits = std::array<std::uint64_t, 3>;

struct BitsHash {
  std::size_t operator()(const Bits& bits) const {
    std::uint64_t hash = 0;
    for (const std::uint64_t b : bits) hash = (std::rotl(hash, 23) ^ b) * 0x9E3779B97F4A7C15ULL;
    return static_cast<std::size_t>(hash ^ (hash >> 32));
  }
};

}  // namespace

MeshCheck check_watertight(const Mesh& mesh) {
  MeshCheck check;
  check.problem = check_numbers(mesh);
  if (!check.problem.empty()) return check;
  const auto note = [&](const std::string& problem) {
    if (check.problem.empty()) check.problem = problem;  // the first one found
  };

  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    const Eigen::Vector3d& origin = mesh.vertices_m[a];
    const bool flat = (mesh.vertices_m[b] - origin).cross(mesh.vertices_m[c] - origin).isZero(0);
    if (flat) ++check.degenerate_triangles;
    if (repeats_a_vertex(mesh.triangles[t]))
      note("triangle " + std::to_string(t) + " uses a vertex twice");
  }

  const std::vector<Edge> edges = sorted_edges(mesh);
  for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
    while (end < edges.size() && edges[end].key() == edges[begin].key()) ++end;
    const std::size_t count = end - begin;
    if (count == 1) ++check.open_edges;
    if (count != 2) {
      note(edge_name(edges[begin]) + " belongs to " + std::to_string(count) +
           (count == 1 ? " triangle" : " triangles") + "; a closed mesh needs 2");
    } else if (edges[begin].forward == edges[begin + 1].forward) {
      note("the two triangles at " + edge_name(edges[begin]) + " have opposite orientations");
    }
  }
  if (!check.problem.empty() && check.open_edges > 0)
    check.problem += "; " + std::to_string(check.open_edges) + " edges are open in all";
  if (!check.problem.empty()) return check;

  const double volume_m3 = mass_properties(mesh).volume_m3;
  if (!(volume_m3 > 0)) note(volume_problem(volume_m3));
  check.ok = check.problem.empty();
  return check;
}

Mesh merged(std::span<const Mesh> meshes) {
  Mesh all;
  for (const Mesh& mesh : meshes) {
    const auto offset = static_cast<std::uint32_t>(all.vertices_m.size());
    all.vertices_m.insert(all.vertices_m.end(), mesh.vertices_m.begin(), mesh.vertices_m.end());
    for (const auto& t : mesh.triangles)
      all.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  }
  return all;
}

Mesh weld(const Mesh& mesh) {
  Mesh out;
  std::vector<std::uint32_t> new_index;
  new_index.reserve(mesh.vertices_m.size());
  std::unordered_map<Bits, std::uint32_t, BitsHash> seen;
  seen.reserve(mesh.vertices_m.size());
  for (const Eigen::Vector3d& v : mesh.vertices_m) {
    Bits bits;
    for (int k = 0; k < 3; ++k)
      bits[static_cast<std::size_t>(k)] = std::bit_cast<std::uint64_t>(v[k] + 0.0);  // -0 is 0
    const auto [found, fresh] =
        seen.try_emplace(bits, static_cast<std::uint32_t>(out.vertices_m.size()));
    if (fresh) out.vertices_m.push_back(v);
    new_index.push_back(found->second);
  }
  out.triangles.reserve(mesh.triangles.size());
  for (const auto& t : mesh.triangles) {
    const std::array<std::uint32_t, 3> welded = {new_index.at(t[0]), new_index.at(t[1]),
                                                 new_index.at(t[2])};
    if (!repeats_a_vertex(welded)) out.triangles.push_back(welded);
  }
  return out;
}

}  // namespace cousin
