#include "perception/pipelines/tree.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

#include "perception/fruit/fruit_seam.h"
#include "perception/pipelines/pipeline_table.h"
#include "perception/pipelines/seen_boxes.h"
#include "sim/config/changed_keys.h"
#include "sim/config/choice_field.h"

namespace cousin {
namespace {

constexpr std::array<Named<TreeMethod>, 3> kTreeMethods = {
    {{TreeMethod::ours, "ours"}, {TreeMethod::tracks, "tracks"}, {TreeMethod::boxes, "boxes"}}};

constexpr std::pair<const char*, const char*> kFruitSizes[] = {
    {"diameter", "m"}, {"length", "m"}, {"volume", "m3"}};

// ---- Tracks -------------------------------------------------------------------------------------

std::map<int, const FramePose*> poses_by_frame(const Poses& poses) {
  std::map<int, const FramePose*> by_frame;
  for (const FramePose& pose : poses) {
    if (pose.status == PoseStatus::ok) by_frame[pose.frame] = &pose;
  }
  return by_frame;
}

/// Where a fit that is ok has the fruit, in its camera.
std::optional<LocatedPoint> place_of(const ObjectFit& fit) {
  if (fit.status != FitStatus::ok) return std::nullopt;
  const FruitShape shape = shape_of(fit);
  const FruitCovariance covariance = covariance_of(fit);
  const LocatedPoint place{shape.centre_m(), covariance.topLeftCorner<3, 3>()};
  const bool is_known = place.point_m.allFinite() && place.covariance_m2.allFinite() &&
                        place.covariance_m2.diagonal().minCoeff() > 0;
  return is_known ? std::optional(place) : std::nullopt;
}

/// Boxes that are large enough, of frames that have a pose, in the world.
std::vector<PlacedBox> placed_boxes(const std::vector<SeenBox>& boxes, const Estimate& so_far,
                                    const TreePipelineConfig& config) {
  const std::map<int, const ObjectFit*> fits = fits_by_box(so_far.fits);
  const std::map<int, const FramePose*> poses = poses_by_frame(so_far.poses);
  std::vector<PlacedBox> in_world;
  for (const SeenBox& seen : boxes) {
    const DetectedBox& box = *seen.box;
    if (!poses.contains(box.frame) || pixels_of(box) < config.tracks.least_px) continue;
    const Camera& camera = seen.image->reported;
    const auto fit = fits.find(box.id);
    std::optional<LocatedPoint> place;
    if (fit != fits.end()) place = place_of(*fit->second);
    if (!place) place = rough_place(box, camera, *seen.depth, config.fruit.prior);
    const bool has_depth = place.has_value();
    if (!has_depth) place = place_by_size(box, camera, config.fruit.prior);
    const PlacedBox one =
        placed(box, *place, poses.at(box.frame)->camera_from_world, config.tracks.pose_sigma_m);
    in_world.push_back(has_depth ? one : in_row(one, config.tracks.crown_sigma_m));
  }
  return in_world;
}

Tracks tracks_of(const Capture& capture, const Estimate& so_far, const TreePipelineConfig& config) {
  const std::vector<SeenBox> boxes = seen_boxes(capture, so_far, "tracks");
  const std::vector<PlacedBox> in_world = placed_boxes(boxes, so_far, config);
  const std::size_t left_out = boxes.size() - in_world.size();
  if (left_out > 0)
    so_far.notes->push_back(std::to_string(left_out) + " of " + std::to_string(boxes.size()) +
                            " boxes are not brought together with others: they have less than " +
                            std::to_string(config.tracks.least_px) +
                            " pixels (tracks.least_px), or their image has no pose");
  if (config.method != TreeMethod::boxes) {
    try {
      return join_boxes(in_world, config.tracks);
    } catch (const std::invalid_argument& error) {
      throw StageError("tracks", std::string("boxes.json: ") + error.what());
    }
  }
  Tracks tracks;
  for (const PlacedBox& box : in_world)
    tracks.push_back({static_cast<int>(tracks.size()),
                      {box.id},
                      box.in_world.point_m,
                      box.in_world.covariance_m2});
  return tracks;
}

// ---- Traits -------------------------------------------------------------------------------------

FruitMeasure fused_size(const std::vector<const ObjectFit*>& fits, std::string_view name,
                        const TreeYieldConfig& config) {
  std::vector<FruitMeasure> views;
  for (const ObjectFit* fit : fits) views.push_back(parameter_of(*fit, name));
  return fused(views, config.common_share);
}

/// A fruit over all its views.
SpecimenTraits traits_of_track(const Track& track, const std::map<int, const ObjectFit*>& fits,
                               const TreePipelineConfig& config) {
  SpecimenTraits traits;
  traits.instance = track.id;
  traits.centroid_in_world_m = track.centre_in_world_m;
  std::vector<const ObjectFit*> own;
  for (const int box : track.boxes) {
    const auto fit = fits.find(box);
    if (fit == fits.end()) continue;
    if (fit->second->status == FitStatus::ok)
      own.push_back(fit->second);
    else if (traits.reason.empty())
      traits.reason = fit->second->reason;
  }
  if (own.empty()) {
    if (traits.reason.empty()) traits.reason = "no fit is of it";
    return traits;
  }
  traits.status = TraitStatus::ok;
  traits.reason.clear();
  for (const auto& [name, unit] : kFruitSizes) {
    const FruitMeasure size = fused_size(own, name, config.yield);
    traits.traits.push_back({name, unit, size.value, size.sigma});
  }
  const Trait& volume = traits.traits.back();
  const FruitPrior& prior = config.fruit.prior;
  const double mass_kg = prior.density_kg_m3 * volume.value;
  traits.traits.push_back({"mass", "kg", mass_kg,
                           mass_kg * std::hypot(volume.sigma / volume.value,
                                                prior.sigma_density_kg_m3 / prior.density_kg_m3)});
  return traits;
}

FruitMeasure mass_of(const SpecimenTraits& fruit) {
  for (const Trait& trait : fruit.traits) {
    if (trait.name == "mass") return {trait.value, trait.sigma};
  }
  return {};
}

SpecimenTraits traits_of_tree(int instance, const TreeYield& tree) {
  SpecimenTraits traits;
  traits.instance = instance;
  traits.status = TraitStatus::ok;
  traits.traits.push_back({"fruit_count", "1", tree.count.value, tree.count.sigma});
  if (std::isfinite(tree.yield_kg.value))
    traits.traits.push_back({"yield", "kg", tree.yield_kg.value, tree.yield_kg.sigma});
  return traits;
}

/// How many images show a track. @throws StageError naming a box that there is not
int views_of(const Track& track, const std::map<int, int>& frame_of_box) {
  std::set<int> frames;
  for (const int box : track.boxes) {
    const auto frame = frame_of_box.find(box);
    if (frame == frame_of_box.end())
      throw StageError("traits", "tracks.json: track " + std::to_string(track.id) + " has box " +
                                     std::to_string(box) + ", which boxes.json has not");
    frames.insert(frame->second);
  }
  if (frames.empty())
    throw StageError("traits", "tracks.json: track " + std::to_string(track.id) + " has no box");
  return static_cast<int>(frames.size());
}

Traits traits_of(const Estimate& so_far, const TreePipelineConfig& config) {
  const std::map<int, const ObjectFit*> fits = fits_by_box(so_far.fits);
  std::map<int, int> frame_of_box;
  for (const DetectedBox& box : so_far.boxes) frame_of_box[box.id] = box.frame;
  int without_place = 0;
  Traits traits;
  std::vector<SeenFruit> seen;
  int next = 0;
  for (const Track& track : so_far.tracks) {
    next = std::max(next, track.id + 1);
    const int views = views_of(track, frame_of_box);
    if (!track.centre_in_world_m.allFinite()) {
      ++without_place;
      continue;
    }
    if (!is_in_place(track.centre_in_world_m, config.yield)) continue;
    traits.push_back(traits_of_track(track, fits, config));
    const double variance_m2 =
        track.covariance_m2.selfadjointView<Eigen::Upper>().eigenvalues().maxCoeff();
    seen.push_back({views, mass_of(traits.back()),
                    variance_m2 < config.yield.located_m * config.yield.located_m});
  }
  if (without_place > 0)
    so_far.notes->push_back(std::to_string(without_place) +
                            " tracks say no place and are not counted");
  const auto posed = static_cast<int>(poses_by_frame(so_far.poses).size());
  if (posed == 0) return traits;
  // Without more views than one, none of those that are not seen is counted.
  traits.push_back(traits_of_tree(
      next, yield_of(seen, config.method == TreeMethod::ours ? posed : 1, config.yield)));
  return traits;
}

}  // namespace

std::string_view to_string(TreeMethod method) { return name_in<TreeMethod>(kTreeMethods, method); }

Fields fields(TreePipelineConfig& c) {
  return Fields{{"method", choice_field<TreeMethod>("method", kTreeMethods, c.method),
                 "how the tree's fruits are counted"}} +
         nested("fruit", fields(c.fruit)) + nested("tracks", fields(c.tracks)) +
         nested("yield", fields(c.yield));
}

void validate(const TreePipelineConfig& config) {
  validate(config.fruit);
  validate(config.tracks);
  validate(config.yield);
}

PipelineNeeds needs(const TreePipelineConfig&) {
  return {.images = {"depth"},
          .stages = {"poses", "boxes", "depth", "fits", "tracks", "traits"},
          .left_out = {}};
}

std::vector<std::string> unused_settings(const TreePipelineConfig& config) {
  std::vector<std::string> unused;
  for (const std::string& of_fruit : unused_settings(config.fruit))
    unused.push_back("fruit." + of_fruit);
  const auto add = [&](std::initializer_list<std::string_view> keys) {
    for (std::string& sentence : keys_without_effect(config, to_string(config.method), keys))
      unused.push_back(std::move(sentence));
  };
  if (config.method == TreeMethod::tracks) add({"yield.located_m"});
  if (config.method == TreeMethod::boxes)
    add({"tracks.per_m3", "tracks.most_off", "yield.common_share", "yield.located_m"});
  return unused;
}

void check_capture(const Capture& capture, const TreePipelineConfig& config) {
  check_capture(capture, config.fruit);
}

Stages stages_for(const TreePipelineConfig& config, const Capture& capture, std::uint64_t seed,
                  const SplatWatch& watch) {
  Stages stages = stages_for(config.fruit, capture, seed, watch);
  stages.tracks = [config](const Capture& capture, const Estimate& so_far) {
    return tracks_of(capture, so_far, config);
  };
  stages.traits = [config](const Capture&, const Estimate& so_far) {
    return traits_of(so_far, config);
  };
  return stages;
}

const PipelineRow& tree_pipeline();
const PipelineRow& row_of(const TreePipelineConfig& /*config*/) { return tree_pipeline(); }

const PipelineRow& tree_pipeline() {
  static constexpr auto kOrder =
      std::to_array<std::string_view>({"poses", "boxes", "depth", "fits", "tracks", "traits"});
  static const PipelineRow kRow = {
      .name = "tree",
      .help = "count and yield of an apple tree from several views, each fruit once",
      .scenes = {"apples"},
      .order = kOrder,
      .from_outside = {"poses", "boxes"},
      .traits_of = TraitsOf::trees,
      .traits = {"fruit_count", "yield", "diameter", "length", "volume", "mass"},
      .methods =
          {{"ours",
            "boxes joined in 3D, fruits that no view shows counted by how many are seen once "
            "and twice"},
           {"tracks", "boxes joined in 3D, and no fruit that is not seen"},
           {"boxes", "each box of each view is a fruit"}},
      .defaults = [] { return PipelineConfig(TreePipelineConfig{}); }};
  return kRow;
}

}  // namespace cousin
