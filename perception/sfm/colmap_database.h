#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace cousin {

/// What COLMAP's database says of one image: why it found a place, or none.
struct ImageMatches {
  int features = 0;
  int tried = 0;     ///< images that it was matched with
  int partners = 0;  ///< of these: images of which enough matches agree on one geometry
};

struct ColmapDatabase {
  std::vector<ImageMatches> images;  ///< none where there is a complaint
  std::string complaint;  ///< names the file: what it has that a database of these has not
};

/// Reads the database of features and matches that COLMAP 3.8 keeps [COLMAP, "Database Format"];
/// one entry for each of `images` images, which are named as `colmap_image_name` does. It is read
/// as a file that nobody writes, and what its schema would run is not run. It says what explains a
/// model, so that one that cannot be read is a complaint and no error.
ColmapDatabase read_colmap_database(const std::filesystem::path& file, int images);

}  // namespace cousin
