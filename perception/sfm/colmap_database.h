#pragma once

#include <filesystem>
#include <vector>

namespace cousin {

/// What COLMAP's database says of one image: why it found a place, or none.
struct ImageMatches {
  int features = 0;
  int tried = 0;     ///< images that it was matched with
  int partners = 0;  ///< of these: images of which enough matches agree on one geometry
};

/// Reads the database of features and matches that COLMAP 3.8 keeps [COLMAP, "Database Format"];
/// one entry for each of `images` images, which are named as `colmap_image_name` does. The file is
/// only read; what its schema would run is not trusted.
/// @throws std::runtime_error naming the file if it is no such database, names other images, or
/// holds numbers that cannot be
std::vector<ImageMatches> read_colmap_database(const std::filesystem::path& file, int images);

}  // namespace cousin
