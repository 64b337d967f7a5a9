#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/types/capture.h"

namespace cousin {

/// Private to sim/dataset: what the readers of other programs' captures share.

/// Largest coordinate of a camera's place, in the file's unit. A number beyond it is damage.
inline constexpr double kMostCoordinate = 1e9;

/// @throws std::runtime_error "WHERE: the name "caf\xe9.png" is not UTF-8" if it is not.
void require_utf8(const std::string& name, const std::string& where);

/// The file that a list names, below `folder`; nothing where it is absent. Names of Windows have
/// "\" in place of "/". A name without an ending that is no file itself is that of a .png, .jpg or
/// .jpeg. @throws std::runtime_error naming the path if it leads out of the folder or is no file,
/// and all files that it may mean if there are several.
std::optional<std::filesystem::path> find_listed_image(const std::filesystem::path& folder,
                                                       const std::string& listed);

/// @throws std::runtime_error naming the folder if the images, as their heads tell their sizes,
/// would take more memory than is allowed; no pixel is decoded.
void check_images_memory(const std::filesystem::path& folder,
                         const std::vector<std::filesystem::path>& images);
/// What depth images take beside the colour images that the capture holds.
void check_depth_memory(const std::filesystem::path& folder, const Capture& capture,
                        const std::vector<std::filesystem::path>& depth_images);

/// The colour image of a sensor of each frame, of the size of its camera. Adds a warning where
/// images have an alpha channel, which is not used, or an EXIF orientation, which is not applied.
/// @throws std::runtime_error naming file, frame and both sizes.
void read_frame_colors(Capture& capture, const std::vector<std::filesystem::path>& images,
                       std::size_t sensor_index = 0);

/// @throws std::runtime_error naming file, frame and both sizes unless they are equal.
void check_image_size(const std::filesystem::path& file, int frame, int width_px, int height_px,
                      const Camera& camera);

/// A warning for the files that say that a viewer turns them: their pixels stay as stored.
void warn_of_orientation(const std::vector<std::filesystem::path>& images, Capture& capture);

}  // namespace cousin
