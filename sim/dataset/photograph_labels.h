#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/dataset/seam_io.h"
#include "sim/types/seams.h"

namespace cousin {

/// How somebody's labels name a picture.
struct LabelledPicture {
  int frame = 0;
  std::string file;  ///< below the source's folder, "train/IMG_1.jpg"
  std::string id;    ///< COCO's number; "" where the source has none
};

/// Somebody's labels of a capture's pictures, which stand for truth: DATASET/000000/labels/ holds
/// boxes.json (COCO results, masks where there are some) and
///   pictures.json  {"pictures": [{"frame": 0, "file": "IMG_1.jpg", "id": "17"}], "category_ids":
///   [1, 3]}
/// whose last key may be absent.
struct PhotographLabels {
  std::vector<LabelledPicture> pictures;  ///< one for each frame
  /// The source's own numbers of the dataset's categories, in their order; empty: it has none.
  std::vector<int> category_ids;
  Boxes boxes;
};

bool has_labels(const std::filesystem::path& scene_dir);
void write_labels(const std::filesystem::path& scene_dir, const PhotographLabels& labels,
                  int scene_index);
/// @param images  of which boxes may be @throws std::runtime_error naming file, key, value, limit
PhotographLabels read_labels(const std::filesystem::path& scene_dir, const DetectionImages& images);

/// pictures.json as text; boxes are left as they are. @throws as read_labels
std::string pictures_to_json(const PhotographLabels& labels);
PhotographLabels pictures_from_json(std::string_view text, const std::string& name);

}  // namespace cousin
