#include "benchmarks/loop/score_boxes.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <span>
#include <stdexcept>
#include <tuple>
#include <vector>

#include "benchmarks/loop/box_truth.h"
#include "benchmarks/loop/score_geometry.h"
#include "benchmarks/loop/score_plants.h"
#include "sim/truth/specimens.h"

namespace cousin {
namespace {

constexpr double kLeastOverlap = 0.5;

double overlap(const TrueBox& a, const DetectedBox& b) {
  const Eigen::Vector2d size =
      (a.high_px.cwiseMin(b.high_px) - a.low_px.cwiseMax(b.low_px)).cwiseMax(0.0);
  const double both = size.prod();
  return both / ((a.high_px - a.low_px).prod() + (b.high_px - b.low_px).prod() - both);
}

/// Place of each true box's measured one; -1 where there is none. Best overlaps first.
std::vector<int> match_boxes(const std::vector<TrueBox>& truth, const Boxes& measured) {
  std::vector<std::tuple<double, std::size_t, std::size_t>> pairs;
  for (std::size_t t = 0; t < truth.size(); ++t) {
    for (std::size_t m = 0; m < measured.size(); ++m) {
      if (measured[m].frame != truth[t].frame ||
          measured[m].sensor != static_cast<int>(truth[t].sensor))
        continue;
      const double share = overlap(truth[t], measured[m]);
      if (share >= kLeastOverlap) pairs.emplace_back(-share, t, m);
    }
  }
  std::sort(pairs.begin(), pairs.end());
  std::vector<int> result(truth.size(), -1);
  std::vector<bool> taken(measured.size(), false);
  for (const auto& [share, t, m] : pairs) {
    if (result[t] >= 0 || taken[m]) continue;
    result[t] = static_cast<int>(m);
    taken[m] = true;
  }
  return result;
}

/// The true value of a box's trait.
double true_value(const TrueBox& box, const std::string& trait) {
  if (trait == "point_x") return box.point_m.x();
  if (trait == "point_y") return box.point_m.y();
  if (trait == "point_z") return box.point_m.z();
  if (trait == "distance") return box.point_m.norm();
  throw std::invalid_argument("trait \"" + trait + "\" is not one of a box");
}

SpecimenRow row_of_box(const TrueBox& box, const Instance& object, const std::string& trait,
                       const SpecimenTraits* measured, const SeedsScoreLabels& labels) {
  SpecimenRow row;
  row.dataset = labels.suite;
  row.scene = labels.scene;
  row.frame = box.frame;
  row.instance = object.id;
  row.cultivar = variety_of(object);
  row.run = labels.run;
  row.method = labels.method;
  row.trait = trait;
  row.unit = "m";
  row.truth = true_value(box, trait);
  row.status = ScoreStatus::not_solved;
  if (!measured || measured->status != TraitStatus::ok) return row;
  for (const Trait& m : measured->traits) {
    if (m.name != trait) continue;
    if (m.unit != row.unit)
      throw std::invalid_argument("traits.json: box " + std::to_string(measured->instance) + ": " +
                                  m.name + " is in " + m.unit + ", and the true one in m");
    row.measured = m.value;
    row.sigma = m.sigma;
    row.status = ScoreStatus::ok;
  }
  return row;
}

constexpr const char* kBoxTraits[] = {"point_x", "point_y", "point_z", "distance"};

/// RMSE and mean absolute error of rows whose box is between two distances.
void add_errors(const std::string& case_name, const std::vector<SpecimenRow>& rows, double from_m,
                double to_m, const ScoreRow& base, std::vector<ScoreRow>& scores) {
  std::map<std::pair<std::int64_t, std::int64_t>, double> distance_m;
  for (const SpecimenRow& row : rows) {
    if (row.trait == "distance") distance_m[{row.frame, row.instance}] = row.truth;
  }
  for (const char* trait : kBoxTraits) {
    double squares = 0, absolute = 0;
    std::int64_t n = 0;
    for (const SpecimenRow& row : rows) {
      const double at_m = distance_m[{row.frame, row.instance}];
      if (row.trait != trait || row.status != ScoreStatus::ok || at_m < from_m || at_m >= to_m)
        continue;
      const double error = row.measured - row.truth;
      squares += error * error;
      absolute += std::abs(error);
      ++n;
    }
    if (n == 0) continue;
    ScoreRow row = base;
    row.case_name = case_name;
    const auto count = static_cast<double>(n);
    scores.push_back(measured_row(row, std::string(trait) + ".rmse_by_distance",
                                  std::sqrt(squares / count), "m", n));
    scores.push_back(
        measured_row(row, std::string(trait) + ".mae_by_distance", absolute / count, "m", n));
  }
}

using TraitsOfBoxes = std::map<std::pair<int, int>, const SpecimenTraits*>;  ///< by frame and id

/// Scores of the images of one sensor.
SeedsScores score_sensor(const SceneTruth& truth, std::size_t sensor, const Boxes& measured,
                         const TraitsOfBoxes& traits_of, const SeedsScoreLabels& labels) {
  SeedsScores scores;
  ScoreRow base = labelled_row(labels);
  const std::string other = sensor == 0 ? "" : truth.other_sensors.at(sensor - 1).sensor + ", ";
  base.case_name = other + base.case_name;
  const auto objects = specimens_of(truth.scene);
  const std::vector<TrueBox> boxes = true_boxes_of(truth, sensor);
  const std::vector<int> match = match_boxes(boxes, measured);
  std::int64_t found = 0, measured_boxes = 0;
  double distance_m = 0;
  for (std::size_t t = 0; t < boxes.size(); ++t) {
    const SpecimenTraits* traits = nullptr;
    if (match[t] >= 0) {
      ++found;
      const DetectedBox& box = measured[static_cast<std::size_t>(match[t])];
      const auto own = traits_of.find({box.frame, box.id});
      if (own != traits_of.end()) traits = own->second;
    }
    const Instance& object = *objects[static_cast<std::size_t>(boxes[t].specimen)];
    for (const char* trait : kBoxTraits)
      scores.specimens.push_back(row_of_box(boxes[t], object, trait, traits, labels));
    const auto rows = std::span(scores.specimens).last(std::size(kBoxTraits));
    if (std::any_of(rows.begin(), rows.end(),
                    [](const SpecimenRow& row) { return row.status != ScoreStatus::ok; }))
      continue;
    ++measured_boxes;
    distance_m += std::hypot(rows[0].measured - rows[0].truth, rows[1].measured - rows[1].truth,
                             rows[2].measured - rows[2].truth);
  }
  const auto n = static_cast<std::int64_t>(boxes.size());
  const auto there = std::count_if(measured.begin(), measured.end(), [&](const DetectedBox& box) {
    return box.sensor == static_cast<int>(sensor);
  });
  const auto add = [&](const std::string& metric, double value, const char* unit, std::int64_t of) {
    scores.rows.push_back(measured_row(base, metric, value, unit, of));
  };
  add("boxes.found", static_cast<double>(found), "1", n);
  add("boxes.missed", static_cast<double>(n - found), "1", n);
  add("boxes.spurious", static_cast<double>(there - found), "1", n);
  add("boxes.measured", static_cast<double>(measured_boxes), "1", n);
  if (measured_boxes > 0)
    add("point.error_3d", distance_m / static_cast<double>(measured_boxes), "m", measured_boxes);
  constexpr double kSteps_m[] = {0.3, 0.4, 0.5, 0.6};
  for (std::size_t i = 0; i + 1 < std::size(kSteps_m); ++i) {
    char name[40];
    std::snprintf(name, sizeof name, "%.1f to %.1f m", kSteps_m[i], kSteps_m[i + 1]);
    add_errors(other + name, scores.specimens, kSteps_m[i], kSteps_m[i + 1], base, scores.rows);
  }
  return scores;
}

}  // namespace

SeedsScores score_boxes(const SceneTruth& truth, const Estimate& estimate,
                        const SeedsScoreLabels& labels) {
  TraitsOfBoxes traits_of;
  for (const SpecimenTraits& traits : estimate.traits)
    traits_of[{traits.frame, traits.instance}] = &traits;
  SeedsScores scores;
  for (const std::size_t sensor : sensors_with_truth(truth)) {
    const bool has_boxes =
        std::any_of(estimate.boxes.begin(), estimate.boxes.end(),
                    [&](const DetectedBox& box) { return box.sensor == static_cast<int>(sensor); });
    if (sensor > 0 && !has_boxes) continue;
    SeedsScores own = score_sensor(truth, sensor, estimate.boxes, traits_of, labels);
    scores.rows.insert(scores.rows.end(), own.rows.begin(), own.rows.end());
    if (sensor == 0) scores.specimens = std::move(own.specimens);
  }
  score_timings(estimate, labelled_row(labels), scores.rows);
  return scores;
}

SeedsScores score_estimate(TraitsOf traits_of, const SceneTruth& truth, const Estimate& estimate,
                           const SeedsScoreLabels& labels) {
  if (traits_of == TraitsOf::boxes) return score_boxes(truth, estimate, labels);
  if (traits_of == TraitsOf::plants) return score_plants(truth, estimate, labels);
  return score_run(truth, estimate, labels);
}

}  // namespace cousin
