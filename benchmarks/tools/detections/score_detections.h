#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "benchmarks/score/scores.h"
#include "benchmarks/tools/detections/found_files.h"
#include "benchmarks/tools/detections/true_pictures.h"

namespace cousin {

struct DetectionScoreConfig {
  double confidence = 0.25;  ///< precision, recall, F1 and pictures are of detections from here on
  double overlap = 0.5;      ///< with which a detection is right, of these
  int resamples = 300;       ///< of the bootstrap over plants
  std::uint64_t seed = 0;
  /// Names of the file's classes, as the dataset's categories are named; empty: class k of a COCO
  /// file is the k-th category, from 1, and of YOLO's text from 0.
  std::map<int, std::string> classes;
  bool is_from_zero = false;  ///< the file numbers classes from 0, if `classes` does not say
};

/// What became of an object or a detection, classes apart from their place.
struct PictureOutcome {
  std::size_t picture = 0;
  std::vector<std::size_t> found;      ///< detections of at least the confidence, by their place
  std::vector<int> object_of;          ///< for each of these; -1: nothing is there
  std::vector<int> detection_of;       ///< for each object, into `found`; -1: missed
  std::vector<std::uint8_t> is_right;  ///< for each of `found`: object and class
  std::size_t errors() const;          ///< missed, wrong, or of another class
};

struct DetectionScores {
  std::vector<ScoreRow> rows;
  std::vector<PictureOutcome> outcomes;  ///< of each picture
  std::vector<std::string> classes;      ///< the dataset's, then those of the file alone
};

/// "0=low,1=medium,2=high". @throws std::invalid_argument naming the text
std::map<int, std::string> class_map_from_string(const std::string& text);

/// With 95 % intervals over plants:
/// - AP50, AP50_95 [COCO], AP75: the mean over classes that the dataset shows; "AP50.of_class" of
///   each and "AP50.as_one_class" of all; of masks too ("mask_AP50") where the file has them;
/// - precision, recall, F1 at the confidence; the best F1 over confidences, and where it is;
/// - "recall.visible", "recall.size" (COCO's 32 and 96 px), "recall.light", and "recall.maturity"
///   where there is such a label or trait: of the objects of each group;
/// - confusion: objects of each class that were found as each other, and as nothing.
/// @throws std::invalid_argument naming a class of the file that the dataset has not
DetectionScores score_detections(const TruePictures& truth, const FoundFile& found,
                                 const DetectionScoreConfig& config, const ScoreRow& base);

}  // namespace cousin
