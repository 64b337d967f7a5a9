#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "sim/dataset/import_labels.h"
#include "sim/types/capture.h"

namespace cousin {

/// What `import` is asked for.
struct ImportRequest {
  std::string format;  ///< rgbd, stereo, tum, nerfstudio, colmap, phenomenal, folder, video; with
                       ///< labels coco or yolo
  std::filesystem::path source;
  std::string intrinsics;               ///< as for import_folder; "" = none
  std::optional<double> depth_unit_m;   ///< of rgbd, tum and nerfstudio
  int frames = 0;                       ///< of a video; 0 = 60
  std::optional<double> length_unit_m;  ///< of rgbd and stereo
};

/// The capture that another program or a camera wrote. Photographs without intrinsics get those of
/// EXIF, else of `unknown_lens`. @throws std::invalid_argument for a format that there is not, or
/// an option that the format has no use for; std::runtime_error for files that are not as they must
/// be.
Capture import_capture(const ImportRequest& request);

/// Whether the format brings labels: coco, yolo.
bool has_labels(const ImportRequest& request);
/// Labelled photographs of such a format. @throws as import_capture
LabelledPhotographs import_labelled(const ImportRequest& request);

}  // namespace cousin
