#include "benchmarks/score/average_precision.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace cousin {
namespace {

void check_sizes(const DetectedImage& image) {
  const std::size_t detections = image.score.size(), objects = image.is_object_ignored.size();
  bool fits = image.is_detection_ignored.size() == detections &&
              image.overlap.size() == detections && image.is_crowd.size() == objects;
  for (const std::vector<double>& row : image.overlap) fits = fits && row.size() == objects;
  if (!fits)
    throw std::invalid_argument("sizes of an image's detections and objects do not fit together");
}

std::vector<std::size_t> by_falling_score(const std::vector<double>& score) {
  std::vector<std::size_t> order(score.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return score[a] > score[b]; });
  return order;
}

/// The object that a detection takes. COCO takes one that counts before one that does not.
int nearest(const DetectedImage& image, std::size_t detection, const std::vector<int>& taken_by,
            double threshold, MatchRule rule) {
  const std::size_t objects = image.is_object_ignored.size();
  for (const bool ignored : {false, true}) {
    int best = DetectionMatches::kNone;
    double overlap = std::min(threshold, 1 - 1e-10);  // as COCO's
    for (std::size_t o = 0; o < objects; ++o) {
      if ((image.is_object_ignored[o] != 0) != ignored) continue;
      const bool is_taken = taken_by[o] != DetectionMatches::kNone && image.is_crowd[o] == 0;
      if (is_taken && rule == MatchRule::coco) continue;
      const double own = image.overlap[detection][o];
      // Of equal ones COCO takes the last, Pascal the first.
      const bool is_better = rule == MatchRule::coco || best == DetectionMatches::kNone
                                 ? own >= overlap
                                 : own > overlap;
      if (!is_better) continue;
      overlap = own;
      best = static_cast<int>(o);
    }
    if (best != DetectionMatches::kNone) return best;
  }
  return DetectionMatches::kNone;
}

/// Precision at each rank, none lower than a later one.
struct Curve {
  std::vector<double> recall, precision;
};
Curve falling_curve(const std::vector<ScoredDetection>& detections, std::size_t objects) {
  Curve curve;
  double right = 0, wrong = 0;
  for (const ScoredDetection& detection : detections) {
    (detection.is_right ? right : wrong) += 1;
    curve.recall.push_back(right / static_cast<double>(objects));
    curve.precision.push_back(right / (right + wrong));
  }
  for (std::size_t i = curve.precision.size(); i-- > 1;)
    curve.precision[i - 1] = std::max(curve.precision[i - 1], curve.precision[i]);
  return curve;
}

double mean_at(const Curve& curve, int steps) {
  // As numpy.linspace rounds it, where both references take their recalls: 0.6 is a bit above 9/15.
  const double step = 1.0 / steps;
  double sum = 0;
  for (int i = 0; i <= steps; ++i) {
    const double recall = i < steps ? i * step : 1.0;
    const auto at = std::lower_bound(curve.recall.begin(), curve.recall.end(), recall);
    if (at != curve.recall.end())
      sum += curve.precision[static_cast<std::size_t>(at - curve.recall.begin())];
  }
  return sum / (steps + 1);
}

double area_below(const Curve& curve) {
  double area = 0, before = 0;
  for (std::size_t i = 0; i < curve.recall.size(); ++i) {
    area += (curve.recall[i] - before) * curve.precision[i];
    before = curve.recall[i];
  }
  return area;
}

}  // namespace

DetectionMatches match_detections(const DetectedImage& image, double threshold, MatchRule rule,
                                  std::size_t most) {
  check_sizes(image);
  DetectionMatches matches;
  matches.order = by_falling_score(image.score);
  if (matches.order.size() > most) matches.order.resize(most);
  matches.detection_of.assign(image.is_object_ignored.size(), DetectionMatches::kNone);
  for (const std::size_t detection : matches.order) {
    int object = nearest(image, detection, matches.detection_of, threshold, rule);
    bool is_ignored = image.is_detection_ignored[detection] != 0;
    if (object != DetectionMatches::kNone) {
      const auto o = static_cast<std::size_t>(object);
      is_ignored = image.is_object_ignored[o] != 0;
      const bool is_taken = matches.detection_of[o] != DetectionMatches::kNone;
      if (is_taken && image.is_crowd[o] == 0)
        object = DetectionMatches::kNone;  // Pascal's: wrong, or ignored with its object
      else if (!is_taken)
        matches.detection_of[o] = static_cast<int>(detection);
    }
    matches.object_of.push_back(object);
    matches.is_ignored.push_back(is_ignored ? 1 : 0);
  }
  return matches;
}

double average_precision(std::vector<ScoredDetection> detections, std::size_t objects,
                         PrecisionAt at) {
  if (objects == 0) return std::numeric_limits<double>::quiet_NaN();
  std::stable_sort(
      detections.begin(), detections.end(),
      [](const ScoredDetection& a, const ScoredDetection& b) { return a.score > b.score; });
  const Curve curve = falling_curve(detections, objects);
  switch (at) {
    case PrecisionAt::coco_101:
      return mean_at(curve, 100);
    case PrecisionAt::pascal_11:
      return mean_at(curve, 10);
    case PrecisionAt::every_point:
      break;
  }
  return area_below(curve);
}

double average_precision(std::span<const DetectedImage> images, double threshold, PrecisionAt at,
                         MatchRule rule, std::size_t most) {
  std::vector<ScoredDetection> detections;
  std::size_t objects = 0;
  for (const DetectedImage& image : images) {
    const DetectionMatches matches = match_detections(image, threshold, rule, most);
    for (std::size_t i = 0; i < matches.order.size(); ++i) {
      if (matches.is_ignored[i] != 0) continue;
      detections.push_back(
          {image.score[matches.order[i]], matches.object_of[i] != DetectionMatches::kNone});
    }
    objects += static_cast<std::size_t>(
        std::count(image.is_object_ignored.begin(), image.is_object_ignored.end(), 0));
  }
  return average_precision(std::move(detections), objects, at);
}

double box_overlap(const PictureBox& a, const PictureBox& b) {
  const double width = std::min(a.x + a.width, b.x + b.width) - std::max(a.x, b.x);
  const double height = std::min(a.y + a.height, b.y + b.height) - std::max(a.y, b.y);
  if (width <= 0 || height <= 0) return 0;
  const double shared = width * height;
  const double all = a.width * a.height + b.width * b.height - shared;
  return all > 0 ? shared / all : 0;
}

}  // namespace cousin
