#pragma once

#include <filesystem>

#include "sim/types/mesh.h"
#include "sim/types/seams.h"

namespace cousin {

/// Triangles alone of what read_user_mesh reads; STL and glTF are welded. Units are the file's.
/// Input is hostile: counts are bounded by the file's size and by 2^26.
/// @throws std::runtime_error naming file, line or byte, and what was expected.
Mesh read_mesh(const std::filesystem::path& file);

/// Binary little-endian PLY with double vertices. Written beside, then renamed.
void write_ply(const std::filesystem::path& file, const Mesh& mesh);

/// Binary STL with float corners of `factor` times the mesh's, repeated a triangle; normals are the
/// triangles'. @throws std::invalid_argument for 2^32 triangles or more, which it cannot count.
void write_stl(const std::filesystem::path& file, const Mesh& mesh, double factor = 1);

/// Points with float x y z, nx ny nz, uchar red green blue, float sigma; with `instance`, an int
/// more.
void write_ply(const std::filesystem::path& file, const Cloud& cloud);
void write_ply(const std::filesystem::path& file, const Clusters& clusters);
/// Columns that lack keep their defaults; instance lacks: all -1 and count 0.
Clusters read_cloud_ply(const std::filesystem::path& file);

}  // namespace cousin
