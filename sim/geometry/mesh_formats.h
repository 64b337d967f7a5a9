#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "sim/types/mesh.h"

namespace cousin::geometry {

/// Private to sim/geometry: mesh file formats from bytes in memory. `name` is the file's, for
/// messages; all throw std::runtime_error that names it, the line or byte, and what was expected.
/// Counts are bounded by the bytes there are.
inline constexpr std::size_t kMaxElements = std::size_t{1} << 26;

/// Whole file. @throws std::runtime_error if it is missing, not a regular file or larger than 4
/// GiB.
std::string read_whole(const std::filesystem::path& file);
/// Writes beside the final name, flushes to the disk, then renames; whatever fails, nothing new
/// stays.
/// @throws std::runtime_error naming the file and the system's reason.
void write_whole(const std::filesystem::path& file, std::string_view bytes);

/// A PLY file as columns [Turk 1994]: scalar properties as doubles; the list "vertex_indices" or
/// "vertex_index", or else a face's first, as index lists.
struct PlyElement {
  std::string name;
  std::size_t count = 0;
  std::vector<std::string> columns;         ///< scalar properties, in order
  std::vector<std::vector<double>> values;  ///< values[column][row]
  std::string list;  ///< name of the list property that is kept; empty = none
  std::vector<std::vector<std::uint32_t>> lists;
  /// Column of that name, or null.
  const std::vector<double>* column(std::string_view column_name) const;
};
struct Ply {
  std::vector<PlyElement> elements;
  const PlyElement* element(std::string_view element_name) const;
};
Ply parse_ply(std::string_view bytes, const std::string& name);
/// Vertices and faces; polygons are fanned. A file without faces is a mesh of points.
Mesh mesh_of_ply(const Ply& ply, const std::string& name);

/// v and f lines; f takes v, v/vt, v//vn, v/vt/vn and negative indices; other lines are passed
/// over.
Mesh parse_obj(std::string_view bytes, const std::string& name);
/// ASCII or binary, told apart by size. Vertices are repeated as the file repeats them.
Mesh parse_stl(std::string_view bytes, const std::string& name);

}  // namespace cousin::geometry
