#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace cousin {

/// Detections and objects of one category in one image.
struct DetectedImage {
  std::vector<double> score;  ///< of each detection, any order
  /// Whether it does not count where no object is matched, as detections of another size do not.
  std::vector<std::uint8_t> is_detection_ignored;
  /// Objects that may be found or missed: crowds, and what is outside a size.
  std::vector<std::uint8_t> is_object_ignored;
  std::vector<std::uint8_t> is_crowd;  ///< objects that several detections may match
  /// Intersection over union of detection d and object o at [d][o]; with a crowd, over the
  /// detection's own area.
  std::vector<std::vector<double>> overlap;
};

/// Which object a detection may take.
enum class MatchRule {
  coco,   ///< of those that none with a higher score took, the nearest [COCO, cocoeval.py]
  pascal  ///< the nearest of all; where it is taken the detection is wrong [Everingham et al.,
          ///< 2010]
};

/// What became of one image's detections at one threshold.
struct DetectionMatches {
  static constexpr int kNone = -1;
  std::vector<std::size_t> order;  ///< detections by falling score; those past `most` are left out
  std::vector<int> object_of;      ///< for each of `order` the object that it took, or kNone
  std::vector<std::uint8_t> is_ignored;  ///< for each of `order`: neither right nor wrong
  std::vector<int> detection_of;         ///< for each object the detection that took it, or kNone
};
/// Detections take objects in the order of their scores, equal ones as they come; each one of an
/// overlap of at least `threshold`.
/// @param most  detections of an image that count, by score
/// @throws std::invalid_argument where the sizes of `image` do not fit together
DetectionMatches match_detections(const DetectedImage& image, double threshold,
                                  MatchRule rule = MatchRule::coco, std::size_t most = 100);

/// Where precision is read off the curve, made to fall with recall.
enum class PrecisionAt {
  coco_101,    ///< at recalls 0, .01, ... 1
  pascal_11,   ///< at recalls 0, .1, ... 1
  every_point  ///< the area below
};

/// A detection of any image, with what became of it.
struct ScoredDetection {
  double score = 0;
  bool is_right = false;
};
/// @param detections  those that are not ignored, image after image; sorted here, equal scores as
/// they come
/// @param objects  those that are not ignored; NaN where there are none
double average_precision(std::vector<ScoredDetection> detections, std::size_t objects,
                         PrecisionAt at = PrecisionAt::coco_101);

/// The same of images at a threshold.
double average_precision(std::span<const DetectedImage> images, double threshold,
                         PrecisionAt at = PrecisionAt::coco_101, MatchRule rule = MatchRule::coco,
                         std::size_t most = 100);

/// Edges count from the image's corner.
struct PictureBox {
  double x = 0, y = 0, width = 0, height = 0;
};
double box_overlap(const PictureBox& a,
                   const PictureBox& b);  ///< over the union; 0 where that is 0

}  // namespace cousin
