#include "benchmarks/loop/score_boxes.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "benchmarks/loop/box_truth.h"
#include "benchmarks/loop/score_geometry.h"
#include "benchmarks/loop/score_places.h"
#include "benchmarks/loop/score_plants.h"
#include "benchmarks/loop/score_trees.h"
#include "benchmarks/score/trait_statistics.h"
#include "perception/fruit/fruit_place.h"
#include "perception/pipelines/pipeline_table.h"
#include "sim/truth/specimens.h"
#include "sim/types/trait_table.h"

namespace cousin {
namespace {

/// A true value and its unit.
struct TrueValue {
  double value = 0;
  std::string unit;
};
TrueValue true_value(const TrueBox& box, const Instance& object, std::string_view trait) {
  if (trait == "point_x") return {box.point_m.x(), "m"};
  if (trait == "point_y") return {box.point_m.y(), "m"};
  if (trait == "point_z") return {box.point_m.z(), "m"};
  if (trait == "distance") return {box.point_m.norm(), "m"};
  if (is_of_place(trait)) {
    const std::string_view name = trait.substr(0, trait.size() - 2);
    const int k = trait.back() - 'x';
    if (name == "axis") return {box.axis[k], "1"};
    if (name == "approach") return {approach_to(box.cut_m, box.axis)[k], "1"};
    return {(name == "centre" ? box.centre_m : name == "calyx" ? box.calyx_m : box.cut_m)[k], "m"};
  }
  for (const TrueTrait& own : object.traits) {
    if (own.name == trait) return {own.value, own.unit};
  }
  throw std::invalid_argument("trait \"" + std::string(trait) + "\" is not one of " + object.name);
}

SpecimenRow row_of_box(const TrueBox& box, const Instance& object, std::string_view trait,
                       const SpecimenTraits* measured, const SeedsScoreLabels& labels) {
  SpecimenRow row;
  const TrueValue truth = true_value(box, object, trait);
  row.dataset = labels.suite;
  row.scene = labels.scene;
  row.frame = box.frame;
  row.instance = object.id;
  row.cultivar = variety_of(object);
  row.run = labels.run;
  row.method = labels.method;
  row.trait = trait;
  row.unit = truth.unit;
  row.truth = truth.value;
  row.status = ScoreStatus::not_solved;
  if (!measured || measured->status != TraitStatus::ok) return row;
  for (const Trait& m : measured->traits) {
    if (m.name != trait) continue;
    if (m.unit != row.unit)
      throw std::invalid_argument("traits.json: box " + std::to_string(measured->instance) + ": " +
                                  m.name + " is in " + m.unit + ", and the true one in " +
                                  row.unit);
    row.measured = m.value;
    row.sigma = m.sigma;
    row.status = ScoreStatus::ok;
  }
  return row;
}

constexpr std::string_view kBoxTraits[] = {"point_x", "point_y", "point_z", "distance"};

bool is_point(std::string_view trait) {
  return std::find(std::begin(kBoxTraits), std::end(kBoxTraits), trait) != std::end(kBoxTraits);
}

/// Those that an estimate has, of those asked for if any are.
std::vector<std::string_view> traits_in(const Estimate& estimate, TraitNames asked) {
  std::vector<std::string_view> names;
  for (const SpecimenTraits& box : estimate.traits) {
    for (const Trait& trait : box.traits) {
      if (std::find(names.begin(), names.end(), trait.name) == names.end())
        names.push_back(trait.name);
    }
  }
  if (names.empty()) {
    if (asked.empty()) return {std::begin(kBoxTraits), std::end(kBoxTraits)};
    return {asked.begin(), asked.end()};
  }
  if (asked.empty()) return names;
  std::vector<std::string_view> own;
  for (const std::string_view name : asked) {
    if (std::find(names.begin(), names.end(), name) != names.end()) own.push_back(name);
  }
  if (own.empty()) own.assign(asked.begin(), asked.end());  // none of them is measured
  return own;
}

/// Of each case and trait: how many boxes there are and were measured, and how well.
/// @param case_of  of each row; empty: it does not count
/// @param traits  of the rows of a box that count
void add_cases(const std::string& other, const std::vector<SpecimenRow>& rows,
               const std::vector<std::string>& case_of, TraitNames traits, const ScoreRow& base,
               std::vector<ScoreRow>& scores) {
  const std::set<std::string> cases(case_of.begin(), case_of.end());
  for (const std::string& name : cases) {
    if (name.empty()) continue;
    std::vector<SpecimenRow> own;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (case_of[i] == name) own.push_back(rows[i]);
    }
    ScoreRow row = base;
    row.case_name = other + name;
    const auto boxes = static_cast<std::int64_t>(own.size() / traits.size());
    scores.push_back(measured_row(row, "boxes.there", static_cast<double>(boxes), "1", boxes));
    add_place_rows(own, traits, row, scores);
    for (const std::string_view trait : traits) {
      const auto pairs = trait_pairs(own, trait, [](const SpecimenRow&) { return true; });
      scores.push_back(measured_row(row, std::string(trait) + ".measured",
                                    static_cast<double>(pairs.size()), "1", boxes));
      if (pairs.empty()) continue;
      const std::string unit(trait_row(trait).unit);
      for (ScoreRow& one :
           score_rows(row, std::string(trait), unit, trait_statistics(pairs, Rng(base.seed))))
        scores.push_back(std::move(one));
      for (ScoreRow& one : score_rows(row, std::string(trait), sigma_coverage(pairs)))
        scores.push_back(std::move(one));
    }
  }
}

/// RMSE and mean absolute error of rows whose box is between two distances.
void add_errors(const std::string& case_name, const std::vector<SpecimenRow>& rows, double from_m,
                double to_m, const ScoreRow& base, std::vector<ScoreRow>& scores) {
  std::map<std::pair<std::int64_t, std::int64_t>, double> distance_m;
  for (const SpecimenRow& row : rows) {
    if (row.trait == "distance") distance_m[{row.frame, row.instance}] = row.truth;
  }
  for (const std::string_view trait : kBoxTraits) {
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

/// Distance of a box's measured point from the true one.
double point_error_m(std::span<const SpecimenRow> rows) {
  double squares = 0;
  for (const SpecimenRow& row : rows) {
    if (row.trait == "point_x" || row.trait == "point_y" || row.trait == "point_z")
      squares += (row.measured - row.truth) * (row.measured - row.truth);
  }
  return std::sqrt(squares);
}

using TraitsOfBoxes = std::map<std::pair<int, int>, const SpecimenTraits*>;  ///< by frame and id

/// Scores of the images of one sensor.
SeedsScores score_sensor(const SceneTruth& truth, std::size_t sensor, const Boxes& measured,
                         const TraitsOfBoxes& traits_of, TraitNames traits_wanted,
                         const SeedsScoreLabels& labels) {
  SeedsScores scores;
  ScoreRow base = labelled_row(labels);
  const std::string other = sensor == 0 ? "" : truth.other_sensors.at(sensor - 1).sensor + ", ";
  base.case_name = other + base.case_name;
  const auto objects = specimens_of(truth.scene);
  const std::vector<TrueBox> boxes = true_boxes_of(truth, sensor);
  const std::vector<int> match = match_boxes(boxes, measured);
  const bool has_points = are_of_points(traits_wanted);
  std::vector<std::string_view> others;
  std::copy_if(traits_wanted.begin(), traits_wanted.end(), std::back_inserter(others),
               [](std::string_view trait) { return !is_point(trait); });
  const HiddenEdges hidden =
      std::any_of(others.begin(), others.end(), is_of_place) ? kPickersEdges : HiddenEdges{};
  std::vector<std::string> case_of;  // one for each specimen row
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
    const std::string box_is =
        others.empty() ? ""
                       : box_case(boxes[t], object.id,
                                  truth_of_sensor(truth, sensor).images[boxes[t].view], hidden);
    for (const std::string_view trait : traits_wanted) {
      SpecimenRow row = row_of_box(boxes[t], object, trait, traits, labels);
      const std::string own_case = is_point(trait) ? "" : box_is;
      if (!own_case.empty()) row.cultivar += ", " + own_case;
      scores.specimens.push_back(std::move(row));
      case_of.push_back(own_case);
    }
    const auto rows = std::span(scores.specimens).last(traits_wanted.size());
    if (std::any_of(rows.begin(), rows.end(), [&](const SpecimenRow& row) {
          return row.status != ScoreStatus::ok && (!has_points || is_point(row.trait));
        }))
      continue;
    ++measured_boxes;
    if (has_points) distance_m += point_error_m(rows);
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
  if (!others.empty()) add_cases(other, scores.specimens, case_of, others, base, scores.rows);
  if (!has_points) return scores;
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

bool are_of_points(TraitNames traits) {
  return std::any_of(traits.begin(), traits.end(), is_point);
}

bool are_all_of_points(TraitNames traits) {
  return std::all_of(traits.begin(), traits.end(), is_point);
}

std::string box_case(const TrueBox& box, int instance, const TruthImages& images,
                     HiddenEdges edges) {
  const auto own =
      std::find_if(images.visibility.begin(), images.visibility.end(),
                   [&](const InstanceVisibility& v) { return v.instance == instance; });
  if (own == images.visibility.end()) return {};
  const bool is_cut = own->box_x <= 0 || own->box_y <= 0 ||
                      own->box_x + own->box_width >= images.instance.width() ||
                      own->box_y + own->box_height >= images.instance.height();
  if (is_cut) return "cut by the image";
  if (box.point_m.z() < 0.3) return "nearer than 0.3 m";
  if (box.point_m.z() > 1) return "farther than 1 m";
  const double hidden = 1 - own->visible_fraction;
  if (hidden < 0.05) return "unoccluded";
  const std::string half = std::to_string(edges.half), most = std::to_string(edges.most);
  if (hidden < 0.01 * edges.half) return "hidden below " + half + " %";
  if (hidden < 0.01 * edges.most) return "hidden " + half + " to " + most + " %";
  return "hidden above " + most + " %";
}

SeedsScores score_boxes(const SceneTruth& truth, const Estimate& estimate,
                        const SeedsScoreLabels& labels, TraitNames traits) {
  const std::vector<std::string_view> wanted = traits_in(estimate, traits);
  TraitsOfBoxes traits_of;
  for (const SpecimenTraits& traits : estimate.traits)
    traits_of[{traits.frame, traits.instance}] = &traits;
  SeedsScores scores;
  for (const std::size_t sensor : sensors_with_truth(truth)) {
    const bool has_boxes =
        std::any_of(estimate.boxes.begin(), estimate.boxes.end(),
                    [&](const DetectedBox& box) { return box.sensor == static_cast<int>(sensor); });
    if (sensor > 0 && !has_boxes) continue;
    SeedsScores own = score_sensor(truth, sensor, estimate.boxes, traits_of, wanted, labels);
    scores.rows.insert(scores.rows.end(), own.rows.begin(), own.rows.end());
    if (sensor == 0) scores.specimens = std::move(own.specimens);
  }
  score_timings(estimate, labelled_row(labels), scores.rows);
  return scores;
}

namespace {

/// Whether a pipeline that measures plants names the trait; internode_3 is one of internode.
bool is_of_plants(const std::string& trait) {
  const auto is_named = [&](std::string_view own) {
    return trait == own || trait.starts_with(std::string(own) + "_");
  };
  const std::vector<const PipelineRow*> table = pipeline_table();
  return std::any_of(table.begin(), table.end(), [&](const PipelineRow* row) {
    return row->traits_of == TraitsOf::plants &&
           std::any_of(row->traits.begin(), row->traits.end(), is_named);
  });
}

}  // namespace

TraitsOf traits_of_estimate(const Estimate& estimate) {
  bool is_of_images = false, has_names = false, has_plants = false, has_tree = false;
  for (const SpecimenTraits& specimen : estimate.traits) {
    is_of_images = is_of_images || specimen.frame >= 0;
    for (const Trait& trait : specimen.traits) {
      has_names = true;
      has_plants = has_plants || is_of_plants(trait.name);
      has_tree = has_tree || trait.name == "fruit_count";
    }
  }
  if (!is_of_images) return has_tree ? TraitsOf::trees : TraitsOf::specimens;
  if (has_names) return has_plants ? TraitsOf::plants : TraitsOf::boxes;
  return estimate.boxes.empty() && !estimate.fits.empty() ? TraitsOf::plants : TraitsOf::boxes;
}

SeedsScores score_estimate(TraitsOf traits_of, const SceneTruth& truth, const Estimate& estimate,
                           const SeedsScoreLabels& labels, TraitNames traits) {
  if (traits_of == TraitsOf::boxes) return score_boxes(truth, estimate, labels, traits);
  if (traits_of == TraitsOf::plants) return score_plants(truth, estimate, labels);
  if (traits_of == TraitsOf::trees) return score_trees(truth, estimate, labels);
  return score_run(truth, estimate, labels);
}

}  // namespace cousin
