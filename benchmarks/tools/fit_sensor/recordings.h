#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/types/image.h"

namespace cousin {

/// Frames of one flat wall at one distance, camera and wall at rest.
struct WallFolder {
  std::string name;                ///< of the folder: "wall_0.60m"
  double distance_m = 0;           ///< stated, along the optical axis through the image's middle
  double distance_sigma_m = 0;     ///< standard deviation of that statement
  double albedo = 0.5;             ///< of the wall at the device's wavelength, as far as known
  double light = 0.02;             ///< irradiance of the wall, full sunlight being 3
  std::vector<std::string> files;  ///< depth frames by name, in order
};

/// Frames of an evenly lit field, or of darkness, by one exposure.
struct FlatFolder {
  std::string name;
  std::vector<std::string> files;
};

/// A rectangle of pixels.
struct ImageRegion {
  int x = 0, y = 0, width = 0, height = 0;
};

/// A user's recordings of a camera: what `cousin fit-sensor` reads.
///
///   FOLDER/wall_0.60m/*.png   16-bit depth, times depth_unit_m; 0 = none; a folder a distance
///   FOLDER/dark/*.png         raw linear frames of darkness: grey PNG of 8 or 16 bits, mosaic or
///   FOLDER/flat_*/*.png       not; and of an even field, a folder a brightness
///   FOLDER/recordings.toml    optional: the keys below; ["wall_0.60m"] with distance_m,
///                             distance_sigma_m, albedo, light for what differs in a folder
struct Recordings {
  std::filesystem::path folder;
  std::optional<double> depth_unit_m, focal_px, baseline_m;  ///< else those of the rig's preset
  std::optional<ImageRegion> region;  ///< where the wall fills the image; else the middle half
  int color_bits = 0;                 ///< of the raw frames: 8..16; 0 = as the PNG stores
  std::vector<WallFolder> walls;      ///< by distance, then name
  std::vector<std::string> dark;
  std::vector<FlatFolder> flats;  ///< by name
};

inline constexpr int kMostFolders = 64, kMostFramesOfFolder = 256, kMostSide_px = 4096;

/// @throws std::runtime_error naming file or folder, key, value and limit: a folder whose name says
/// no distance and which has none in recordings.toml, a table without a folder, too many of either.
Recordings read_recordings(const std::filesystem::path& folder);

/// What names of folders and the text of recordings.toml say, without looking at frames.
/// @param folders  names of what lies in the folder
Recordings recordings_from_index(const std::vector<std::string>& folders, std::string_view toml,
                                 const std::string& toml_name);

/// A depth frame. @throws std::runtime_error naming the file if it is no 16-bit grey PNG or has a
/// side above kMostSide_px.
Image<std::uint16_t> read_depth_frame(const std::filesystem::path& file);

/// A raw frame with the bits that its PNG stores. @throws std::runtime_error as above; colour PNG
/// is refused: developed colours do not have the sensor's noise.
struct RawFrame {
  Image<std::uint16_t> codes;
  int bits = 16;
};
RawFrame read_raw_frame(const std::filesystem::path& file);

}  // namespace cousin
