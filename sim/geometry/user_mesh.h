#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "sim/types/image.h"
#include "sim/types/mesh.h"

namespace cousin {

/// A mesh as somebody's file holds it, with what its author coloured and named.
struct UserMesh {
  Mesh mesh;  ///< in the file's unit, or metres where the format has one; nothing is welded
  std::vector<Rgbf> vertex_albedo;  ///< linear, in [0, 1], one for each vertex; empty = no colours
  std::vector<std::uint16_t> triangle_part;  ///< index into part_names; empty = no parts
  std::vector<std::string> part_names;       ///< unique, not empty
  bool is_in_metres = false;                 ///< the format says so: glTF
};

/// Triangles of a file beyond which it is refused, unless the caller says otherwise.
inline constexpr std::size_t kMostUserTriangles = 20'000'000;

/// Reads a scan, or another program's plant, by its ending:
/// - .ply: ASCII and binary; colours from red, green, blue (integers of 255 or floats of 1, sRGB).
/// - .obj: parts from o and g lines, colours from "v x y z r g b" (sRGB of 1).
/// - .stl: ASCII and binary.
/// - .gltf, .glb: glTF 2.0 [Khronos, ISO/IEC 12113]: the nodes of its scene that carry triangles
///   are the parts, placed as the nodes are; y up becomes z up; COLOR_0 times the material's base
///   colour are the colours. Buffers are embedded or files inside the folder. Textures, skins,
///   morphs and animations are not read (mesh_warnings.h says which a file has); sparse and
///   compressed data are refused.
/// Polygons are cut into triangles inside them, concave ones too (polygon.h). Input is hostile:
/// counts are bounded by the file's size and most_triangles.
/// @throws std::runtime_error naming file, place, value and limit.
UserMesh read_user_mesh(const std::filesystem::path& file,
                        std::size_t most_triangles = kMostUserTriangles);

/// Vertices that are equal bit by bit become one, of the first one's colour, and triangles that
/// then use a vertex twice are dropped; parts are no more.
UserMesh welded(const UserMesh& user);

/// Metres per unit: m, dm, cm, mm, um, in or ft. @throws std::invalid_argument naming those.
double metres_per_unit(const std::string& unit);

}  // namespace cousin
