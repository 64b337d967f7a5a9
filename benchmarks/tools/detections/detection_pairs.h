#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "benchmarks/score/average_precision.h"
#include "benchmarks/tools/detections/found_files.h"
#include "benchmarks/tools/detections/score_detections.h"
#include "benchmarks/tools/detections/true_pictures.h"

namespace cousin {

/// Private to benchmarks/tools/detections.

/// A picture, its objects and what was found in it.
struct PicturePair {
  const TruePicture* picture = nullptr;
  std::span<const FoundObject> found;
  std::vector<int> found_class, object_class;  ///< into the list of classes
  /// Overlaps of each detection with each object; `mask` is empty where the file has none.
  std::vector<std::vector<double>> box, mask;
};

/// One for each picture of `truth`. `found` outlives them.
/// @param classes  in: the dataset's; out: those of the file alone behind them
/// @throws std::invalid_argument naming a class of the file that the dataset has not;
/// std::runtime_error where the overlaps take too much memory
std::vector<PicturePair> pairs_of(const TruePictures& truth, const FoundFile& found,
                                  const DetectionScoreConfig& config,
                                  std::vector<std::string>& classes);

/// Detections and objects of one class, or of all as one.
DetectedImage image_of(const PicturePair& pair, std::optional<int> only,
                       const std::vector<std::vector<double>>& overlap);

}  // namespace cousin
