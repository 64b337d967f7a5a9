#pragma once

#include <filesystem>
#include <string>

#include "sim/dataset/export/export_scene.h"

namespace cousin {

/// Copies the file unless the same bytes are there already.
void copy_once(const std::filesystem::path& from, const std::filesystem::path& to);
/// write_file unless the same bytes are there already.
void write_once(const std::filesystem::path& file, const std::string& bytes);

/// The picture that `lens` took under `stem` with the ending that fits: the file's own bytes, or,
/// if it is to be undistorted, what the pinhole camera `handed` would have taken (PNG). Returns the
/// file written.
std::filesystem::path write_picture(const ExportPicture& picture, const Camera& lens,
                                    const Camera& handed, const std::filesystem::path& stem,
                                    const ExportOptions& options);
/// Its ending: ".png" or ".jpg".
std::string picture_ending(const ExportPicture& picture, const ExportOptions& options);

/// Depth of a frame in the pixels of its picture as `handed` over: what the sensor itself
/// measured there, or its depth sensor's, seen from the picture's camera. Empty = none.
struct ExportDepth {
  Image<std::uint16_t> depth;  ///< times unit_m = metres along the axis; 0 = none
  double unit_m = 0.001;
};
ExportDepth depth_of(const ExportScene& scene, const ExportPicture& picture, const Camera& handed,
                     const ExportOptions& options);

}  // namespace cousin
