#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "calibration/boards/charuco_layout.h"
#include "sim/types/calibration_target.h"
#include "sim/types/capture.h"
#include "sim/types/image.h"

namespace cousin {

/// One image of a target.
struct CalibrationPhoto {
  std::filesystem::path file;
  std::string name;             ///< below the folder that was given
  int camera = 0;               ///< index into CalibrationPhotos::cameras
  int frame = 0;                ///< same number = same instant
  bool is_linear_grey = false;  ///< of an infrared imager; else 8-bit sRGB
  double time_s = std::numeric_limits<double>::quiet_NaN();  ///< NaN: unknown
  /// As its EXIF block says: how a viewer turns it (sim/imaging/exif.h). Pixels, and all that comes
  /// out of them, are those that are stored.
  int exif_orientation = 1;
};

/// One depth image of a dataset, in the pixels of one of its cameras.
struct CalibrationDepth {
  std::filesystem::path file;
  int camera = 0;  ///< index into CalibrationPhotos::cameras
  int frame = 0;
  double unit_m = 0.001;
};

/// What is calibrated from.
struct CalibrationPhotos {
  CalibrationTarget target;
  /// Of a charuco board; none: the photographs say which (layout_seen).
  std::optional<CharucoLayout> layout;
  std::vector<std::string> cameras;
  std::vector<CalibrationPhoto> photos;  ///< by camera, then frame
  std::vector<SensorReport> reported;    ///< what a dataset's device says of `cameras`; or empty
  std::vector<CalibrationDepth> depths;  ///< by frame
};

/// "KIND:COLUMNSxROWS:PITCH[:SHARE[:DICTIONARY]]" in metres, or a preset of the boards scene:
/// chessboard:6x4:0.030 counts inner corners, charuco:11x8:0.022:0.73:DICT_4X4_50 squares (then
/// ":current" or ":legacy" for its CharucoLayout, which is else found),
/// aprilgrid:6x6:0.022:0.3 tags (side, space over side), circles:8x6:0.03[:0.3] and
/// acircles:4x11:0.018[:0.42] discs. @throws std::invalid_argument naming the text and the form.
CalibrationTarget target_from_option(const std::string& text);
/// The layout that such a text names; none if it names none.
std::optional<CharucoLayout> layout_from_option(const std::string& text);

/// All PNG and JPEG of a folder: one camera; or, where every name begins with "left" or "right",
/// the two of a stereo head, whose images belong together where the rest of their names does.
/// @throws std::runtime_error naming the folder, and for more than 5000 images.
CalibrationPhotos photos_of_folder(const std::filesystem::path& folder,
                                   const CalibrationTarget& target);

/// All frames of a dataset, and the rig's sensors that have images. Its rig.json names the target;
/// `board`, if not empty, must agree. @throws std::runtime_error naming the scene whose board is
/// none, or another than the others', with both.
CalibrationPhotos photos_of_dataset(const std::filesystem::path& dataset, const std::string& board);

/// Of a charuco board with two layouts: photos.layout, or the one that more pairs of markers lie
/// as in. @throws std::runtime_error naming a photograph that cannot be read.
CharucoLayout layout_seen(const CalibrationPhotos& photos);

/// Metres, NaN = none. @throws std::runtime_error naming the file.
Image<float> read_depth(const CalibrationDepth& depth);

/// @throws std::runtime_error naming the file.
Image<float> read_light(const CalibrationPhoto& photo);

}  // namespace cousin
