#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/geometry/user_mesh.h"
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

/// A file's mesh, and what of the file was passed over; each warning names the file.
struct MeshFile {
  UserMesh user;
  std::vector<std::string> warnings;
};

/// A PLY file as columns [Turk 1994]: scalar properties as doubles; of faces the list
/// "vertex_indices" or "vertex_index", or else their only list of integers, as index lists.
struct PlyElement {
  std::string name;
  std::size_t count = 0;
  std::vector<std::string> columns;         ///< scalar properties, in order
  std::vector<std::vector<double>> values;  ///< values[column][row]
  std::vector<bool> is_float;               ///< of each column: its numbers are no integers
  std::string list;  ///< name of the list property that is kept; empty = none
  std::vector<std::vector<std::uint32_t>> lists;
  /// Column of that name, or null.
  const std::vector<double>* column(std::string_view column_name) const;
};
struct Ply {
  std::vector<PlyElement> elements;
  std::vector<std::string> comments;
  std::size_t bytes_left = 0;  ///< behind the last row, without blanks and ends of lines
  const PlyElement* element(std::string_view element_name) const;
};
Ply parse_ply(std::string_view bytes, const std::string& name);
/// Vertices and faces, polygons cut into triangles (polygon.h). A file without faces is a mesh of
/// points.
Mesh mesh_of_ply(const Ply& ply, const std::string& name);

/// The same with the vertices' colours, and warnings of a texture and of what is left behind the
/// last row.
MeshFile user_mesh_of_ply(const Ply& ply, const std::string& name);

/// v, f, o and g lines; f takes v, v/vt, v//vn, v/vt/vn and negative indices; a name is all that
/// follows on its line. Curved surfaces and calls of other files are refused, other lines are
/// passed over; a warning says where materials are. Ends where there are more than
/// `most_triangles`.
MeshFile parse_obj(std::string_view bytes, const std::string& name,
                   std::size_t most_triangles = kMaxElements);
/// ASCII or binary, told apart by size; a warning says where fewer bytes than a triangle has follow
/// the last. Vertices are repeated as the file repeats them.
MeshFile parse_stl(std::string_view bytes, const std::string& name);

/// Bytes of a file that a glTF file names. @throws std::runtime_error if there is none.
using OpenFile = std::function<std::string(const std::string& uri)>;
/// Of files in the folder of `file`; names that lead out of it are refused.
OpenFile files_beside(const std::filesystem::path& file);
/// glTF 2.0, as JSON or as the binary container.
MeshFile parse_gltf(std::string_view bytes, const std::string& name, const OpenFile& open,
                    std::size_t most_triangles = kMaxElements);

/// Linear light of an sRGB value in [0, 1] [IEC 61966-2-1].
float linear_of_srgb(float srgb);
/// Gives each part a name of its own, and a name at all.
void name_parts(UserMesh& user);

}  // namespace cousin::geometry
