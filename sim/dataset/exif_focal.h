#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/imaging/exif.h"

namespace cousin {

/// Private to sim/dataset: a focal length that files state, without a calibration.
struct ExifFocal {
  double focal_px = 0;
  double sigma_px = 0;  ///< one standard deviation
  std::string from;     ///< "26 mm on 35 mm film"
};

/// For a picture of that size; nothing where the tags say none, or where the picture was cut since.
/// From the imager's resolution: 3 %. From the length on 35 mm film: 5 %, as it is a whole number
/// and makers count along the diagonal or along the width, which differ by 4 %. Where both are
/// there and differ by more than 15 %, the latter, with their difference as its deviation.
std::optional<ExifFocal> exif_focal(const ExifTags& tags, int width_px, int height_px);

/// Of photographs of one lens: the one that those say that say one; `from` names the first and how
/// many. @throws std::runtime_error naming two photographs whose focal lengths differ by more than
/// 2 %.
std::optional<ExifFocal> exif_focal(const std::vector<std::filesystem::path>& images, int width_px,
                                    int height_px);

}  // namespace cousin
