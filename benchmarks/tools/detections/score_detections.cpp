#include "benchmarks/tools/detections/score_detections.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <set>
#include <span>
#include <stdexcept>
#include <utility>

#include "benchmarks/tools/detections/detection_pairs.h"
#include "benchmarks/tools/detections/plant_bootstrap.h"

namespace cousin {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Of one class at one threshold: what each picture gives to the curve.
struct PictureCurve {
  std::vector<ScoredDetection> detections;
  std::size_t objects = 0;
};

constexpr std::size_t kMostOfCoco = 100;  ///< detections of a picture that its curve is of
constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();

std::vector<PictureCurve> curves_of(const std::vector<PicturePair>& pairs, std::optional<int> only,
                                    double threshold,
                                    std::vector<std::vector<double>> PicturePair::*overlap,
                                    std::size_t most) {
  std::vector<PictureCurve> curves;
  for (const PicturePair& pair : pairs) {
    const DetectedImage image = image_of(pair, only, pair.*overlap);
    const DetectionMatches matches = match_detections(image, threshold, MatchRule::coco, most);
    PictureCurve& curve = curves.emplace_back();
    curve.objects = image.is_object_ignored.size();
    for (std::size_t i = 0; i < matches.order.size(); ++i)
      curve.detections.push_back(
          {image.score[matches.order[i]], matches.object_of[i] != DetectionMatches::kNone});
  }
  return curves;
}

double average_precision_of(const std::vector<PictureCurve>& curves,
                            std::span<const std::size_t> pictures) {
  std::vector<ScoredDetection> detections;
  std::size_t objects = 0;
  for (const std::size_t picture : pictures) {
    const PictureCurve& curve = curves[picture];
    detections.insert(detections.end(), curve.detections.begin(), curve.detections.end());
    objects += curve.objects;
  }
  return average_precision(std::move(detections), objects);
}

// ---- Outcomes at a confidence ----

/// Matched whatever the class, so that a fruit that is found as another is no miss.
PictureOutcome outcome_of(const PicturePair& pair, std::size_t place,
                          const DetectionScoreConfig& config) {
  PictureOutcome outcome;
  outcome.picture = place;
  DetectedImage image = image_of(pair, {}, pair.box);
  for (std::size_t d = 0; d < pair.found.size(); ++d) {
    if (pair.found[d].score < config.confidence)
      std::fill(image.overlap[d].begin(), image.overlap[d].end(), 0.0);
  }
  const DetectionMatches matches = match_detections(image, config.overlap, MatchRule::coco, kAll);
  outcome.detection_of.assign(pair.object_class.size(), -1);
  for (std::size_t i = 0; i < matches.order.size(); ++i) {
    const std::size_t d = matches.order[i];
    if (pair.found[d].score < config.confidence) continue;
    const int object = matches.object_of[i];
    if (object >= 0)
      outcome.detection_of[static_cast<std::size_t>(object)] =
          static_cast<int>(outcome.found.size());
    outcome.found.push_back(d);
    outcome.object_of.push_back(object);
    const bool is_right =
        object >= 0 && pair.object_class[static_cast<std::size_t>(object)] == pair.found_class[d];
    outcome.is_right.push_back(is_right ? 1 : 0);
  }
  return outcome;
}

struct Counts {
  double right = 0, found = 0, objects = 0;
  double precision() const { return found > 0 ? right / found : kNone; }
  double recall() const { return objects > 0 ? right / objects : kNone; }
  double f1() const { return found + objects > 0 ? 2 * right / (found + objects) : kNone; }
};

/// Counts over all classes, each matched by itself. Detections below the confidence do not count.
Counts counts_at(const std::vector<std::vector<PictureCurve>>& curves,
                 std::span<const std::size_t> pictures, double confidence) {
  Counts counts;
  for (const std::vector<PictureCurve>& of_class : curves) {
    for (const std::size_t picture : pictures) {
      counts.objects += static_cast<double>(of_class[picture].objects);
      for (const ScoredDetection& detection : of_class[picture].detections) {
        if (detection.score < confidence) continue;
        counts.found += 1;
        counts.right += detection.is_right ? 1 : 0;
      }
    }
  }
  return counts;
}

/// The confidence of the largest F1, and that; the highest of equal ones.
std::pair<double, double> best_f1(const std::vector<std::vector<PictureCurve>>& curves,
                                  std::span<const std::size_t> pictures) {
  std::vector<ScoredDetection> detections;
  double objects = 0;
  for (const std::vector<PictureCurve>& of_class : curves) {
    for (const std::size_t picture : pictures) {
      const PictureCurve& curve = of_class[picture];
      detections.insert(detections.end(), curve.detections.begin(), curve.detections.end());
      objects += static_cast<double>(curve.objects);
    }
  }
  std::stable_sort(
      detections.begin(), detections.end(),
      [](const ScoredDetection& a, const ScoredDetection& b) { return a.score > b.score; });
  std::pair<double, double> best{kNone, kNone};
  double right = 0;
  for (std::size_t i = 0; i < detections.size(); ++i) {
    right += detections[i].is_right ? 1 : 0;
    if (i + 1 < detections.size() && detections[i + 1].score == detections[i].score) continue;
    const double f1 = 2 * right / (static_cast<double>(i + 1) + objects);
    if (!(f1 <= best.second)) best = {detections[i].score, f1};
  }
  return best;
}

// ---- Rows ----

std::vector<std::string> plants_of(const std::vector<PicturePair>& pairs) {
  std::vector<std::string> plants;
  for (const PicturePair& pair : pairs) plants.push_back(pair.picture->plant);
  return plants;
}

class Rows {
 public:
  Rows(const std::vector<PicturePair>& pairs, const std::vector<std::string>& classes,
       const DetectionScoreConfig& config, const ScoreRow& base)
      : pairs_(pairs),
        config_(config),
        base_(base),
        bootstrap_(plants_of(pairs), config.resamples, config.seed) {
    std::set<int> shown;
    for (const PicturePair& pair : pairs)
      shown.insert(pair.object_class.begin(), pair.object_class.end());
    for (const int c : shown) classes_.emplace_back(c, classes[static_cast<std::size_t>(c)]);
  }

  void add(const std::string& case_name, const std::string& metric, const WithInterval& value,
           std::int64_t n) {
    ScoreRow row = base_;
    row.case_name = case_name;
    rows.push_back(with_interval(row, metric, "1", value, n));
    if (std::isnan(value.value)) rows.back().status = ScoreStatus::not_solved;
  }

  /// Average precisions of boxes or of masks.
  void add_precisions(const std::string& prefix,
                      std::vector<std::vector<double>> PicturePair::*overlap) {
    // [class][threshold]; all as one class last.
    std::vector<std::array<std::vector<PictureCurve>, 10>> curves;
    std::vector<std::string> cases;
    std::vector<std::int64_t> objects;
    const auto add_class = [&](std::optional<int> only, const std::string& name) {
      auto& of_class = curves.emplace_back();
      for (std::size_t t = 0; t < of_class.size(); ++t)
        of_class[t] =
            curves_of(pairs_, only, 0.5 + 0.05 * static_cast<double>(t), overlap, kMostOfCoco);
      std::int64_t n = 0;
      for (const PictureCurve& curve : of_class[0]) n += static_cast<std::int64_t>(curve.objects);
      objects.push_back(n);
      cases.push_back(name);
    };
    for (const auto& [place, name] : classes_) add_class(place, "class " + name);
    const std::size_t class_count = curves.size();
    add_class({}, "all as one class");
    struct Metric {
      const char* name;
      std::size_t first, last;  ///< thresholds
    };
    constexpr std::array<Metric, 3> kMetrics = {
        {{"AP50", 0, 0}, {"AP75", 5, 5}, {"AP50_95", 0, 9}}};
    for (const Metric& metric : kMetrics) {
      const auto of_class = [&](std::size_t c, std::span<const std::size_t> pictures) {
        double sum = 0;
        for (std::size_t t = metric.first; t <= metric.last; ++t)
          sum += average_precision_of(curves[c][t], pictures);
        return sum / static_cast<double>(metric.last - metric.first + 1);
      };
      const auto mean = [&](std::span<const std::size_t> pictures) {
        double sum = 0;
        int n = 0;
        for (std::size_t c = 0; c < class_count; ++c) {
          const double value = of_class(c, pictures);
          if (std::isnan(value)) continue;
          sum += value;
          ++n;
        }
        return n > 0 ? sum / n : kNone;
      };
      const std::string name = prefix + metric.name;
      add("mean of classes", name, bootstrap_.of(mean, name), objects.back());
      for (std::size_t c = 0; c < curves.size(); ++c) {
        if (class_count == 1 && c == class_count) continue;  // the same again
        // Names of their own: a gate on AP50 is on the mean alone.
        const std::string of = c == class_count ? ".as_one_class" : ".of_class";
        add(cases[c], name + of,
            bootstrap_.of([&](std::span<const std::size_t> p) { return of_class(c, p); },
                          cases[c] + name),
            objects[c]);
      }
    }
  }

  void add_counts() {
    std::vector<std::vector<PictureCurve>> curves;
    std::int64_t n = 0;
    for (const auto& [place, name] : classes_)
      curves.push_back(curves_of(pairs_, place, config_.overlap, &PicturePair::box, kAll));
    for (const PicturePair& pair : pairs_) n += static_cast<std::int64_t>(pair.object_class.size());
    // Of classes that the dataset does not show: found, and never right.
    std::vector<PictureCurve> others;
    for (const PicturePair& pair : pairs_) {
      PictureCurve& curve = others.emplace_back();
      for (std::size_t d = 0; d < pair.found.size(); ++d) {
        const bool is_shown = std::any_of(classes_.begin(), classes_.end(), [&](const auto& c) {
          return c.first == pair.found_class[d];
        });
        if (!is_shown) curve.detections.push_back({pair.found[d].score, false});
      }
    }
    curves.push_back(std::move(others));
    using Pictures = std::span<const std::size_t>;
    const auto at = [&](Pictures p) { return counts_at(curves, p, config_.confidence); };
    const std::string name = "all classes";
    add(name, "precision", bootstrap_.of([&](Pictures p) { return at(p).precision(); }, "p"), n);
    add(name, "recall", bootstrap_.of([&](Pictures p) { return at(p).recall(); }, "r"), n);
    add(name, "f1", bootstrap_.of([&](Pictures p) { return at(p).f1(); }, "f"), n);
    add(name, "f1_best", bootstrap_.of([&](Pictures p) { return best_f1(curves, p).second; }, "b"),
        n);
    add(name, "f1_best.confidence",
        bootstrap_.of([&](Pictures p) { return best_f1(curves, p).first; }, "c"), n);
  }

  /// Recall whatever the class, of the objects that `group` puts together.
  void add_recall_by(
      const std::string& what, const std::vector<PictureOutcome>& outcomes,
      const std::function<std::string(const TruePicture&, const TrueObject&)>& group) {
    std::map<std::string, std::vector<std::pair<double, double>>> groups;  // found, objects
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      const TruePicture& picture = *pairs_[i].picture;
      for (std::size_t o = 0; o < picture.objects.size(); ++o) {
        const std::string name = group(picture, picture.objects[o]);
        if (name.empty()) continue;
        auto& counts = groups[name];
        counts.resize(pairs_.size());
        counts[i].first += outcomes[i].detection_of[o] >= 0 ? 1 : 0;
        counts[i].second += 1;
      }
    }
    for (const auto& [name, counts] : groups) {
      double n = 0;
      for (const auto& count : counts) n += count.second;
      const std::string case_name = what + " " + name;
      add(case_name, "recall." + what,
          bootstrap_.of(
              [&, &of = counts](std::span<const std::size_t> pictures) {
                double found = 0, objects = 0;
                for (const std::size_t p : pictures) found += of[p].first, objects += of[p].second;
                return objects > 0 ? found / objects : kNone;
              },
              case_name),
          static_cast<std::int64_t>(n));
    }
  }

  std::vector<ScoreRow> rows;

 private:
  const std::vector<PicturePair>& pairs_;
  const DetectionScoreConfig& config_;
  const ScoreRow& base_;
  PlantBootstrap bootstrap_;
  std::vector<std::pair<int, std::string>> classes_;  ///< that the dataset shows
};

std::string visible_group(const TruePicture&, const TrueObject& object) {
  constexpr std::array<const char*, 4> kNames = {"below 0.25", "0.25 to 0.5", "0.5 to 0.75",
                                                 "from 0.75"};
  if (std::isnan(object.visible_fraction)) return {};
  const double quarter = std::clamp(4 * object.visible_fraction, 0.0, 3.0);
  return kNames.at(static_cast<std::size_t>(quarter));
}

std::string size_group(const TruePicture&, const TrueObject& object) {
  const auto area = static_cast<double>(object.area_px);
  return area < 32 * 32 ? "below 32 px" : area < 96 * 96 ? "32 to 96 px" : "from 96 px";
}

std::string maturity_group(const TruePicture&, const TrueObject& object) {
  if (const auto label = object.labels.find("maturity"); label != object.labels.end())
    return label->second;
  const auto maturity = object.traits.find("maturity");
  if (maturity == object.traits.end()) return {};
  constexpr std::array<const char*, 3> kNames = {"low", "medium", "high"};
  return kNames.at(static_cast<std::size_t>(std::clamp(maturity->second, 0.0, 2.0)));
}

void add_confusion(const std::vector<PicturePair>& pairs,
                   const std::vector<PictureOutcome>& outcomes,
                   const std::vector<std::string>& classes, Rows& rows) {
  const std::size_t nothing = classes.size();
  std::vector<std::vector<std::int64_t>> count(nothing + 1, std::vector<std::int64_t>(nothing + 1));
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const PictureOutcome& outcome = outcomes[i];
    for (std::size_t o = 0; o < outcome.detection_of.size(); ++o) {
      const int found = outcome.detection_of[o];
      const std::size_t as =
          found < 0 ? nothing
                    : static_cast<std::size_t>(
                          pairs[i].found_class[outcome.found[static_cast<std::size_t>(found)]]);
      ++count[static_cast<std::size_t>(pairs[i].object_class[o])][as];
    }
    for (std::size_t d = 0; d < outcome.found.size(); ++d) {
      if (outcome.object_of[d] < 0)
        ++count[nothing][static_cast<std::size_t>(pairs[i].found_class[outcome.found[d]])];
    }
  }
  const auto name = [&](std::size_t c) { return c == nothing ? "nothing" : classes[c]; };
  for (std::size_t is = 0; is <= nothing; ++is) {
    for (std::size_t as = 0; as <= nothing; ++as) {
      if (is == nothing && as == nothing) continue;
      WithInterval value;
      value.value = static_cast<double>(count[is][as]);
      rows.add("is " + name(is) + ", found as " + name(as), "confusion", value, count[is][as]);
    }
  }
}

}  // namespace

std::size_t PictureOutcome::errors() const {
  const auto wrong = std::count(is_right.begin(), is_right.end(), 0);
  const auto missed = std::count(detection_of.begin(), detection_of.end(), -1);
  return static_cast<std::size_t>(wrong + missed);
}

std::map<int, std::string> class_map_from_string(const std::string& text) {
  std::map<int, std::string> classes;
  for (std::size_t from = 0; from < text.size();) {
    const std::size_t comma = std::min(text.find(',', from), text.size());
    const std::string word = text.substr(from, comma - from);
    const std::size_t equals = word.find('=');
    int number = -1;
    const char* end = word.data() + std::min(equals, word.size());
    const auto [at, error] = std::from_chars(word.data(), end, number);
    if (equals == std::string::npos || equals + 1 == word.size() || error != std::errc{} ||
        at != end || number < 0 || !classes.emplace(number, word.substr(equals + 1)).second)
      throw std::invalid_argument("--class-map \"" + text + "\": \"" + word +
                                  "\" is not NUMBER=NAME of another class");
    from = comma + 1;
  }
  return classes;
}

DetectionScores score_detections(const TruePictures& truth, const FoundFile& found,
                                 const DetectionScoreConfig& config, const ScoreRow& base) {
  DetectionScores scores;
  scores.classes = truth.categories;
  const std::vector<PicturePair> pairs = pairs_of(truth, found, config, scores.classes);
  for (std::size_t i = 0; i < pairs.size(); ++i)
    scores.outcomes.push_back(outcome_of(pairs[i], i, config));
  Rows rows(pairs, scores.classes, config, base);
  rows.add_precisions("", &PicturePair::box);
  if (found.has_masks) rows.add_precisions("mask_", &PicturePair::mask);
  rows.add_counts();
  rows.add_recall_by("visible", scores.outcomes, visible_group);
  rows.add_recall_by("size", scores.outcomes, size_group);
  rows.add_recall_by("light", scores.outcomes,
                     [](const TruePicture& picture, const TrueObject&) { return picture.light; });
  rows.add_recall_by("maturity", scores.outcomes, maturity_group);
  add_confusion(pairs, scores.outcomes, scores.classes, rows);
  scores.rows = std::move(rows.rows);
  return scores;
}

}  // namespace cousin
