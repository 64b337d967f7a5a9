#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/dataset/import_labels.h"
#include "sim/dataset/mask_codes.h"

namespace cousin {

/// Private to sim/dataset: what import_coco and import_yolo share.

/// The photographs as frames 0, 1, ..., with their names. @throws std::runtime_error naming the
/// folder where they take too much memory, or a file that cannot be read
LabelledPhotographs photographs_of(const std::filesystem::path& source,
                                   const std::vector<std::filesystem::path>& images);

/// What was found of labels that is not as it should be.
struct LabelCounts {
  int outside = 0;  ///< nothing of it is in the image
  int crowds = 0;
};
/// Appends the box of a mask, or else the box, with what lies in the image of the frame.
/// @param corner_px, size_px  from the image's corner
void add_label(int frame, int category, const Eigen::Vector2d& corner_px,
               const Eigen::Vector2d& size_px, PlacedMask mask, LabelledPhotographs& all,
               LabelCounts& counts);
/// Says what was left out, in the capture's warnings.
void warn_of_labels(const std::filesystem::path& source, const LabelCounts& counts,
                    LabelledPhotographs& all);

}  // namespace cousin
