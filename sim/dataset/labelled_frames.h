#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/dataset/import_labels.h"
#include "sim/dataset/mask_codes.h"

namespace cousin {

/// Private to sim/dataset: what import_coco and import_yolo share.

/// The photographs as frames 0, 1, ..., with their names below `root`.
/// @param source  that named them @throws std::runtime_error naming the source where they take too
/// much memory, or a file that cannot be read or is named twice
LabelledPhotographs photographs_of(const std::filesystem::path& source,
                                   const std::filesystem::path& root,
                                   const std::vector<std::filesystem::path>& images);
/// Sets the names, id 1 first. @throws std::runtime_error naming the source where one is empty, too
/// long or stands twice
void set_categories(const std::filesystem::path& source, std::vector<std::string> names,
                    LabelledPhotographs& all);
/// Without the mark of byte order that some editors put first.
std::string_view without_bom(std::string_view text);

/// What was found of labels that is not as it should be.
struct LabelCounts {
  int outside = 0;  ///< nothing of it is in the image
  int crowds = 0;
  std::uint64_t mask_bytes = 0;
};
/// A box as its source gives it, from the image's corner, and its mask. A mask that covers no
/// pixel's middle is the pixel in the box's own.
struct GivenLabel {
  int frame = 0, category = 0;
  Eigen::Vector2d corner_px, size_px;
  std::optional<PlacedMask> mask;
};
/// Appends the box, cut off at its image's edges, with its mask.
/// @throws std::runtime_error naming the source where the masks take too much memory
void add_label(const std::filesystem::path& source, GivenLabel label, LabelledPhotographs& all,
               LabelCounts& counts);
/// Says what was left out, in the capture's warnings.
void warn_of_labels(const std::filesystem::path& source, const LabelCounts& counts,
                    LabelledPhotographs& all);

}  // namespace cousin
