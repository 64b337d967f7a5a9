#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "sim/dataset/export/export_scene.h"

namespace cousin {

/// A kind of thing to find, as the datasets name it.
struct Category {
  int id = 0;  ///< from 1, in the order of the names
  std::string name;
  std::vector<std::string> keypoints;  ///< of all its specimens
};
/// Those of the datasets' categories.json, and those of the specimens of all scenes. So a class has
/// the same id whether or not a dataset shows it. Keypoints are those of the specimen
/// with the most, in its order, then what only others have.
/// @param label  of the specimens by which they are sorted; empty: by Instance::category
/// @throws std::runtime_error naming the scene, a specimen without that label, and what it has
std::vector<Category> categories_of(const std::vector<ExportScene>& scenes,
                                    const std::string& label = {});

/// One specimen as a picture shows it.
struct LabelledObject {
  const Instance* instance = nullptr;
  int category = 0;  ///< Category::id
  /// Seen pixels, 255 inside, of the box alone.
  Image<std::uint8_t> mask;
  int box_x = 0, box_y = 0;  ///< of the mask's first pixel; width and height are the mask's
  std::int64_t area_px = 0;  ///< pixels seen
  double visible_fraction = 0;
  std::vector<KeypointView> keypoints;  ///< one for each of the category's; none = state none
};

/// @param categories  of categories_of by the label `options.category`
/// What a picture that truth is of shows, specimens by id; in the undistorted picture if asked.
/// Visible fractions are those of the picture as it was taken.
/// @throws std::runtime_error naming the scene and the truth that `render` must write.
std::vector<LabelledObject> labels_of(const ExportScene& scene, const ExportPicture& picture,
                                      const std::vector<Category>& categories,
                                      const ExportOptions& options);

/// @throws std::runtime_error naming the scene and what `render --truth` must list, unless truth
/// holds the instance images, and the keypoints if they are asked.
void require_labels(const ExportScene& scene, bool keypoints);

}  // namespace cousin
