#include "benchmarks/loop/score_plants.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>
#include <tuple>

#include "benchmarks/loop/score_geometry.h"
#include "benchmarks/score/order_statistics.h"
#include "perception/pipelines/maize.h"
#include "perception/stem/stem_seam.h"
#include "sim/truth/specimens.h"

namespace cousin {
namespace {

constexpr double kPlant_px = 60, kNode_px = 40, kOne_px = 6;

/// A measured stem as the first image shows it.
struct SeenStem {
  const SpecimenTraits* traits = nullptr;
  FittedStem stem;
  std::vector<Eigen::Vector2d> pixels_px;
  int plant = -1;           ///< place of its true one
  std::vector<int> places;  ///< of the true points
};

std::vector<SeenStem> stems_of_view(const TrueView& view, std::size_t place,
                                    const Estimate& estimate) {
  std::vector<SeenStem> stems;
  for (const ObjectFit& fit : estimate.fits) {
    if (fit.status != FitStatus::ok || fit.instance / kPlantsOfFrame != static_cast<int>(place))
      continue;
    SeenStem seen;
    seen.stem = stem_of_fit(fit);
    for (const Eigen::Vector3d& node_m : seen.stem.nodes.nodes_m)
      seen.pixels_px.push_back(
          project(view.camera, node_m).value_or(Eigen::Vector2d::Constant(-1e6)));
    for (const SpecimenTraits& traits : estimate.traits) {
      if (traits.instance == fit.instance) seen.traits = &traits;
    }
    stems.push_back(std::move(seen));
  }
  return stems;
}

/// Mean distance of a stem's points from the nearest true ones.
double apart_px(const TruePlant& plant, const SeenStem& seen) {
  double sum = 0;
  for (const Eigen::Vector2d& pixel : seen.pixels_px) {
    double least = std::numeric_limits<double>::infinity();
    for (const TruePlant::Point& point : plant.points)
      least = std::min(least, (point.pixel_px - pixel).norm());
    sum += std::min(least, 1e4);
  }
  return sum / static_cast<double>(seen.pixels_px.size());
}

void match_plants(const std::vector<TruePlant>& plants, std::vector<SeenStem>& stems) {
  std::vector<std::tuple<double, std::size_t, std::size_t>> pairs;
  for (std::size_t p = 0; p < plants.size(); ++p) {
    for (std::size_t s = 0; s < stems.size(); ++s) {
      const double apart = apart_px(plants[p], stems[s]);
      if (apart < kPlant_px) pairs.emplace_back(apart, p, s);
    }
  }
  std::sort(pairs.begin(), pairs.end());
  std::vector<bool> taken(plants.size(), false);
  for (const auto& [apart, p, s] : pairs) {
    if (taken[p] || stems[s].plant >= 0) continue;
    taken[p] = true;
    stems[s].plant = static_cast<int>(p);
    stems[s].places = aligned_points(plants[p].points, stems[s].pixels_px);
  }
}

// ---- Rows
// ----------------------------------------------------------------------------------------

/// Sums over all frames.
struct PlantSums {
  std::int64_t plants = 0, plants_found = 0, plants_spurious = 0;
  std::int64_t nodes = 0, nodes_found = 0, nodes_spurious = 0;
  std::int64_t internodes = 0, internodes_measured = 0, internodes_false = 0;
  double error_m = 0, depth_m2 = 0, across_m2 = 0;
};

/// Value and deviation of a trait by its name in traits.json.
const Trait* trait_named(const SpecimenTraits* traits, const std::string& name) {
  if (!traits || traits->status != TraitStatus::ok) return nullptr;
  for (const Trait& trait : traits->traits) {
    if (trait.name == name) return &trait;
  }
  return nullptr;
}

SpecimenRow plant_row(const SeedsScoreLabels& labels, const Instance& object, int frame,
                      std::int64_t instance, const char* trait, double truth_m,
                      const Trait* measured) {
  SpecimenRow row;
  row.dataset = labels.suite;
  row.scene = labels.scene;
  row.frame = frame;
  row.instance = instance;
  row.cultivar = variety_of(object);
  row.run = labels.run;
  row.method = labels.method;
  row.trait = trait;
  row.unit = "m";
  row.truth = truth_m;
  row.status = ScoreStatus::not_solved;
  if (!measured) return row;
  if (measured->unit != "m")
    throw std::invalid_argument("traits.json: " + measured->name + " is in " + measured->unit +
                                ", and the true one in m");
  row.measured = measured->value;
  row.sigma = measured->sigma;
  row.status = ScoreStatus::ok;
  return row;
}

/// The place of the measured point whose next is the true upper end; -1 = none.
int measured_below(const SeenStem& seen, int upper) {
  for (std::size_t i = 1; i < seen.places.size(); ++i) {
    if (seen.places[i] == upper && seen.places[i - 1] == upper - 1) return static_cast<int>(i);
  }
  return -1;
}

void add_nodes(const TruePlant& plant, const SeenStem& seen, PlantSums& sums) {
  for (std::size_t i = 0; i < seen.places.size(); ++i) {
    if (seen.places[i] < 0) {
      ++sums.nodes_spurious;
      continue;
    }
    ++sums.nodes_found;
    const Eigen::Vector3d& truth =
        plant.points[static_cast<std::size_t>(seen.places[i])].in_camera_m;
    const Eigen::Vector3d off = seen.stem.nodes.nodes_m[i] - truth;
    const double along = off.dot(truth.normalized());
    sums.error_m += off.norm();
    sums.depth_m2 += along * along;
    sums.across_m2 += off.squaredNorm() - along * along;
  }
  for (std::size_t i = 1; i < seen.places.size(); ++i) {
    if (seen.places[i] < 0 || seen.places[i - 1] < 0 || seen.places[i] != seen.places[i - 1] + 1)
      ++sums.internodes_false;
  }
}

double true_height_m(const Instance& object) {
  for (const TrueTrait& trait : object.traits) {
    if (trait.name == "height") return trait.value;
  }
  throw std::invalid_argument("specimen " + std::to_string(object.id) + " has no trait height");
}

void add_plant(const TruePlant& plant, const Instance& object, const SeenStem* seen, int frame,
               const SeedsScoreLabels& labels, PlantSums& sums, std::vector<SpecimenRow>& rows) {
  ++sums.plants;
  sums.nodes += static_cast<std::int64_t>(plant.points.size());
  if (seen) {
    ++sums.plants_found;
    add_nodes(plant, *seen, sums);
  }
  for (std::size_t i = 1; i < plant.points.size(); ++i) {
    const double truth_m = (plant.points[i].in_object_m - plant.points[i - 1].in_object_m).norm();
    const std::int64_t instance = 100 * plant.instance + static_cast<std::int64_t>(i);
    const int at = seen ? measured_below(*seen, static_cast<int>(i)) : -1;
    ++sums.internodes;
    if (at > 0) ++sums.internodes_measured;
    const SpecimenTraits* traits = seen ? seen->traits : nullptr;
    // Inside one internode a stalk is straight: its chord is its length along the stalk.
    for (const char* trait : {"internode", "internode_geodesic"}) {
      const Trait* value =
          at > 0 ? trait_named(traits, std::string(trait) + "_" + std::to_string(at)) : nullptr;
      rows.push_back(plant_row(labels, object, frame, instance, trait, truth_m, value));
    }
  }
  rows.push_back(plant_row(labels, object, frame, plant.instance, "plant_height",
                           true_height_m(object),
                           trait_named(seen ? seen->traits : nullptr, "plant_height")));
}

/// Medians of the absolute errors of a trait's rows that are at least so long.
void add_medians(const std::vector<SpecimenRow>& specimens, const std::string& trait,
                 double least_m, const ScoreRow& base, std::vector<ScoreRow>& rows) {
  std::vector<double> errors, shares;
  for (const SpecimenRow& row : specimens) {
    if (row.trait != trait || row.status != ScoreStatus::ok || row.truth < least_m) continue;
    errors.push_back(std::abs(row.measured - row.truth));
    shares.push_back(errors.back() / row.truth);
  }
  if (errors.empty()) return;
  const auto n = static_cast<std::int64_t>(errors.size());
  rows.push_back(measured_row(base, trait + ".median_error", quantile(errors, 0.5), "m", n));
  rows.push_back(measured_row(base, trait + ".median_share", quantile(shares, 0.5), "1", n));
}

void add_sums(const PlantSums& sums, const ScoreRow& base, std::vector<ScoreRow>& rows) {
  const auto add = [&](const char* metric, std::int64_t value, std::int64_t of) {
    rows.push_back(measured_row(base, metric, static_cast<double>(value), "1", of));
  };
  add("plants.found", sums.plants_found, sums.plants);
  add("plants.missed", sums.plants - sums.plants_found, sums.plants);
  add("plants.spurious", sums.plants_spurious, sums.plants);
  add("nodes.found", sums.nodes_found, sums.nodes);
  add("nodes.missed", sums.nodes - sums.nodes_found, sums.nodes);
  add("nodes.spurious", sums.nodes_spurious, sums.nodes);
  add("internodes.measured", sums.internodes_measured, sums.internodes);
  add("internodes.false", sums.internodes_false, sums.internodes);
  if (sums.nodes_found == 0) return;
  const auto n = static_cast<double>(sums.nodes_found);
  rows.push_back(measured_row(base, "node.error_3d", sums.error_m / n, "m", sums.nodes_found));
  rows.push_back(
      measured_row(base, "node.depth_rms", std::sqrt(sums.depth_m2 / n), "m", sums.nodes_found));
  rows.push_back(
      measured_row(base, "node.across_rms", std::sqrt(sums.across_m2 / n), "m", sums.nodes_found));
}

}  // namespace

std::vector<TruePlant> true_plants(const SceneTruth& truth, std::size_t view) {
  if (view >= truth.images.size() || truth.images[view].keypoints.empty())
    throw std::invalid_argument(
        "scores of plants need true keypoints of every view: render "
        "--truth keypoints");
  std::vector<TruePlant> plants;
  for (const Instance* object : specimens_of(truth.scene)) {
    TruePlant plant;
    plant.instance = object->id;
    const auto& model = truth.scene.models[static_cast<std::size_t>(object->model)];
    for (const KeypointView& seen : truth.images[view].keypoints) {
      if (seen.instance != object->id ||
          (seen.state != PointState::visible && seen.state != PointState::occluded))
        continue;
      const Keypoint& point = model.keypoints.at(static_cast<std::size_t>(seen.keypoint));
      const bool is_root = point.name == "root";
      const auto way = unproject(truth.views[view].camera, seen.pixel_px);
      if ((!is_root && !point.name.starts_with("node ")) || !way) continue;
      const bool is_one = !plant.points.empty() && !plant.points.back().is_root &&
                          (plant.points.back().pixel_px - seen.pixel_px).norm() < kOne_px;
      if (is_one) continue;
      plant.points.push_back(
          {is_root, seen.pixel_px, seen.depth_m / way->z() * *way, point.in_object_m});
    }
    if (!plant.points.empty()) plants.push_back(std::move(plant));
  }
  return plants;
}

std::vector<int> aligned_points(const std::vector<TruePlant::Point>& truth,
                                const std::vector<Eigen::Vector2d>& measured_px) {
  const std::size_t rows = truth.size() + 1, columns = measured_px.size() + 1;
  const auto at = [columns](std::size_t i, std::size_t j) { return i * columns + j; };
  std::vector<double> gain(rows * columns, 0), own(rows * columns, -1);
  for (std::size_t i = 1; i < rows; ++i) {
    for (std::size_t j = 1; j < columns; ++j) {
      const double apart = (truth[i - 1].pixel_px - measured_px[j - 1]).norm();
      if (apart < kNode_px) own[at(i, j)] = gain[at(i - 1, j - 1)] + kNode_px - apart;
      gain[at(i, j)] = std::max({gain[at(i - 1, j)], gain[at(i, j - 1)], own[at(i, j)]});
    }
  }
  std::vector<int> places(measured_px.size(), -1);
  std::size_t i = rows - 1, j = columns - 1;
  while (i > 0 && j > 0) {
    if (own[at(i, j)] >= 0 && gain[at(i, j)] == own[at(i, j)]) {
      places[--j] = static_cast<int>(--i);
    } else if (gain[at(i, j)] == gain[at(i - 1, j)]) {
      --i;
    } else {
      --j;
    }
  }
  return places;
}

SeedsScores score_plants(const SceneTruth& truth, const Estimate& estimate,
                         const SeedsScoreLabels& labels) {
  SeedsScores scores;
  PlantSums sums;
  const auto objects = specimens_of(truth.scene);
  for (std::size_t v = 0; v < truth.views.size(); ++v) {
    const std::vector<TruePlant> plants = true_plants(truth, v);
    std::vector<SeenStem> stems = stems_of_view(truth.views[v], v, estimate);
    match_plants(plants, stems);
    for (std::size_t p = 0; p < plants.size(); ++p) {
      const auto own = std::find_if(stems.begin(), stems.end(), [&](const SeenStem& s) {
        return s.plant == static_cast<int>(p);
      });
      const auto object = std::find_if(objects.begin(), objects.end(), [&](const Instance* o) {
        return o->id == plants[p].instance;
      });
      add_plant(plants[p], **object, own == stems.end() ? nullptr : &*own, truth.views[v].frame,
                labels, sums, scores.specimens);
    }
    sums.plants_spurious +=
        std::count_if(stems.begin(), stems.end(), [](const SeenStem& s) { return s.plant < 0; });
  }
  const ScoreRow base = labelled_row(labels);
  add_sums(sums, base, scores.rows);
  ScoreRow longer = base;
  longer.case_name += ", of 20 mm or more";
  for (const char* trait : {"internode", "internode_geodesic"}) {
    add_medians(scores.specimens, trait, 0, base, scores.rows);
    add_medians(scores.specimens, trait, 0.02, longer, scores.rows);
  }
  add_medians(scores.specimens, "plant_height", 0, base, scores.rows);
  score_timings(estimate, base, scores.rows);
  return scores;
}

}  // namespace cousin
