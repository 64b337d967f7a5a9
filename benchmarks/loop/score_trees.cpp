#include "benchmarks/loop/score_trees.h"

#include <algorithm>
#include <array>
#include <map>
#include <stdexcept>
#include <string>

#include "benchmarks/loop/box_truth.h"
#include "benchmarks/loop/score_geometry.h"
#include "benchmarks/score/specimens.h"
#include "sim/geometry/measure.h"
#include "sim/truth/specimens.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

constexpr double kGate_m = 0.04, kBeside_m = 0.08;
constexpr std::array<std::string_view, 4> kFruitTraits = {"diameter", "length", "volume", "mass"};
constexpr std::array<std::string_view, 2> kTreeTraits = {"fruit_count", "yield"};

double trait_of(const Instance& instance, std::string_view name) {
  for (const TrueTrait& trait : instance.traits) {
    if (trait.name == name) return trait.value;
  }
  throw std::invalid_argument("instance \"" + instance.name + "\" has no trait " +
                              std::string(name) + ": the scene does not say the tree's place");
}

const Instance& tree_of(const Scene& scene) {
  for (const Instance& instance : scene.instances) {
    if (instance.category == "tree") return instance;
  }
  throw std::invalid_argument("the scene has no instance \"tree\": fruits of trees are counted");
}

Vector3d middle_m(const Scene& scene, const Instance& object) {
  return mass_properties(mesh_in_world(scene, object)).centroid_m;
}

/// A fruit of the scene.
struct TrueFruit {
  const Instance* object = nullptr;
  Vector3d middle_m;
  bool is_in_place = false;
};
std::vector<TrueFruit> fruits_of(const Scene& scene) {
  const Instance& tree = tree_of(scene);
  const Vector3d at_m = tree.world_from_object.translation_m;
  const double along_m = 0.5 * trait_of(tree, "place_along"),
               across_m = 0.5 * trait_of(tree, "place_across");
  std::vector<TrueFruit> fruits;
  for (const Instance* object : specimens_of(scene)) {
    const Vector3d middle = middle_m(scene, *object), off_m = middle - at_m;
    fruits.push_back(
        {object, middle, std::abs(off_m.x()) < along_m && std::abs(off_m.y()) < across_m});
  }
  return fruits;
}

const Trait* find_trait_of(const SpecimenTraits* measured, std::string_view name) {
  if (!measured || measured->status != TraitStatus::ok) return nullptr;
  for (const Trait& trait : measured->traits) {
    if (trait.name == name) return &trait;
  }
  return nullptr;
}

bool is_tree(const SpecimenTraits& traits) { return find_trait_of(&traits, "fruit_count"); }

SpecimenRow row_of_trait(const Instance& object, const std::string& cultivar,
                         std::string_view trait, double truth, const std::string& unit,
                         const SpecimenTraits* measured, const SeedsScoreLabels& labels) {
  SpecimenRow row;
  row.dataset = labels.suite;
  row.scene = labels.scene;
  row.instance = object.id;
  row.cultivar = cultivar;
  row.run = labels.run;
  row.method = labels.method;
  row.trait = trait;
  row.unit = unit;
  row.truth = truth;
  row.status = ScoreStatus::not_solved;
  const Trait* own = find_trait_of(measured, trait);
  if (!own) return row;
  if (own->unit != unit)
    throw std::invalid_argument("traits.json: specimen " + std::to_string(measured->instance) +
                                ": " + own->name + " is in " + own->unit +
                                ", and the true one in " + unit);
  row.measured = own->value;
  row.sigma = own->sigma;
  row.status = ScoreStatus::ok;
  return row;
}

/// Counts of the fruits of the place and of the measured ones, by what each stands for.
void add_counts(const SpecimenMatching& matching, const std::vector<Vector3d>& measured_m,
                const std::vector<TrueFruit>& fruits, const ScoreRow& base,
                std::vector<ScoreRow>& rows) {
  std::int64_t there = 0, found = 0, beside = 0, doubled = 0;
  for (const TrueFruit& fruit : fruits) there += fruit.is_in_place ? 1 : 0;
  std::vector<Vector3d> taken_m;
  for (const SpecimenMatch& match : matching.matches) {
    const TrueFruit& fruit = fruits[static_cast<std::size_t>(match.truth)];
    ++(fruit.is_in_place ? found : beside);
    taken_m.push_back(fruit.middle_m);
  }
  for (const int i : matching.spurious) {
    const Vector3d& at_m = measured_m[static_cast<std::size_t>(i)];
    const bool is_double = std::any_of(taken_m.begin(), taken_m.end(), [&](const Vector3d& other) {
      return (other - at_m).norm() < kBeside_m;
    });
    doubled += is_double ? 1 : 0;
  }
  const auto add = [&](const char* metric, std::int64_t count) {
    rows.push_back(measured_row(base, metric, static_cast<double>(count), "1", there));
  };
  add("fruits.found", found);
  add("fruits.missed", there - found);
  add("fruits.beside", beside);
  add("fruits.doubled", doubled);
  add("fruits.spurious", static_cast<std::int64_t>(matching.spurious.size()) - doubled);
}

}  // namespace

SeedsScores score_trees(const SceneTruth& truth, const Estimate& estimate,
                        const SeedsScoreLabels& labels) {
  SeedsScores scores;
  const ScoreRow base = labelled_row(labels);
  const std::vector<TrueFruit> fruits = fruits_of(truth.scene);
  std::vector<Vector3d> true_m, measured_m;
  for (const TrueFruit& fruit : fruits) true_m.push_back(fruit.middle_m);
  std::vector<const SpecimenTraits*> measured;
  const SpecimenTraits* tree = nullptr;
  for (const SpecimenTraits& traits : estimate.traits) {
    if (is_tree(traits)) {
      tree = &traits;
    } else if (traits.centroid_in_world_m.allFinite()) {
      measured.push_back(&traits);
      measured_m.push_back(traits.centroid_in_world_m);
    }
  }
  const SpecimenMatching matching = match_specimens(measured_m, true_m, kGate_m);
  std::vector<const SpecimenTraits*> own(fruits.size(), nullptr);
  for (const SpecimenMatch& match : matching.matches)
    own[static_cast<std::size_t>(match.truth)] = measured[static_cast<std::size_t>(match.measured)];
  add_counts(matching, measured_m, fruits, base, scores.rows);
  double yield_kg = 0, there = 0;
  for (std::size_t i = 0; i < fruits.size(); ++i) {
    if (!fruits[i].is_in_place) continue;
    ++there;
    const Instance& object = *fruits[i].object;
    for (const TrueTrait& trait : object.traits) {
      if (trait.name == "mass") yield_kg += trait.value;
      if (std::find(kFruitTraits.begin(), kFruitTraits.end(), trait.name) != kFruitTraits.end())
        scores.specimens.push_back(row_of_trait(object, variety_of(object), trait.name, trait.value,
                                                trait.unit, own[i], labels));
    }
  }
  const Instance& wood = tree_of(truth.scene);
  scores.specimens.push_back(row_of_trait(wood, "tree", kTreeTraits[0], there, "1", tree, labels));
  scores.specimens.push_back(
      row_of_trait(wood, "tree", kTreeTraits[1], yield_kg, "kg", tree, labels));
  score_timings(estimate, base, scores.rows);
  return scores;
}

Tracks true_tracks(const SceneTruth& truth, const Boxes& boxes) {
  const auto objects = specimens_of(truth.scene);
  const std::vector<TrueBox> there = true_boxes_of(truth);
  const std::vector<int> match = match_boxes(there, boxes);
  std::map<int, Track> by_specimen;
  for (std::size_t t = 0; t < there.size(); ++t) {
    if (match[t] < 0) continue;
    Track& track = by_specimen[there[t].specimen];
    track.boxes.push_back(boxes[static_cast<std::size_t>(match[t])].id);
  }
  Tracks tracks;
  for (auto& [specimen, track] : by_specimen) {
    track.id = static_cast<int>(tracks.size());
    track.centre_in_world_m = middle_m(truth.scene, *objects[static_cast<std::size_t>(specimen)]);
    track.covariance_m2 = 1e-10 * Eigen::Matrix3d::Identity();
    tracks.push_back(std::move(track));
  }
  return tracks;
}

}  // namespace cousin
