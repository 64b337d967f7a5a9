#include "perception/pipelines/maize.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>

#include "perception/pipelines/pipeline_table.h"
#include "perception/stem/stem_seam.h"
#include "sim/config/changed_keys.h"
#include "sim/config/choice_field.h"
#include "sim/config/limits.h"

namespace cousin {
namespace {

constexpr std::array<Named<MaizeMethod>, 3> kMaizeMethods = {
    {{MaizeMethod::ours, "ours"},
     {MaizeMethod::triangulation, "triangulation"},
     {MaizeMethod::paper, "paper"}}};

// ---- One frame
// -----------------------------------------------------------------------------------

EyePair eyes_of(const Capture& capture, const Frame& frame) {
  const Pose right_from_left =
      capture.rig[1].sensor_from_rig * inverse(capture.rig[0].sensor_from_rig);
  return {frame.sensors[0].reported, frame.sensors[1].reported, right_from_left};
}

double apart_s(const Frame& frame) {
  return frame.sensors[1].time_s.value_or(frame.time_s) -
         frame.sensors[0].time_s.value_or(frame.time_s);
}

/// Why a frame's images are no pair; empty if they are.
std::string why_no_pair(const Capture& capture, const Frame& frame,
                        const MaizePipelineConfig& config) {
  char text[200];
  for (std::size_t s = 0; s < 2; ++s) {
    const Camera& camera = frame.sensors[s].reported;
    const Image<Rgb8>& image = frame.sensors[s].color;
    if (image.empty() || (image.width() == camera.width_px && image.height() == camera.height_px))
      continue;
    std::snprintf(text, sizeof text,
                  "the %s image has %d x %d pixels and its calibration is of %d x %d",
                  s == 0 ? "left" : "right", image.width(), image.height(), camera.width_px,
                  camera.height_px);
    return text;
  }
  const double wait_s = std::abs(apart_s(frame));
  if (wait_s > config.most_apart_s) {
    std::snprintf(text, sizeof text, "the exposures are %.3f s apart; most_apart_s = %.3f", wait_s,
                  config.most_apart_s);
    return text;
  }
  const Pose right_from_left =
      capture.rig[1].sensor_from_rig * inverse(capture.rig[0].sensor_from_rig);
  if (!(right_from_left.translation_m.norm() > 1e-6)) return "both eyes are at one place";
  const bool is_matched =
      config.method != MaizeMethod::paper &&
      (config.measure_height || (config.method == MaizeMethod::ours && config.match_images));
  // Images are rectified row by row: a baseline up to 45 degrees from their rows.
  if (is_matched && !(centre_in_world_m(right_from_left).normalized().x() > std::sqrt(0.5)))
    return "the second camera is not to the right of the first";
  return {};
}

/// Points of one image, whatever entry they are of.
EyeNodes nodes_of_image(const Keypoints& keypoints, int frame, int sensor,
                        const MaizePipelineConfig& config) {
  EyeNodes nodes;
  for (const KeypointDetection& entry : keypoints) {
    if (entry.frame != frame || entry.sensor != sensor) continue;
    for (std::size_t k = 0; k < entry.points.size(); ++k) {
      const DetectedKeypoint& point = entry.points[k];
      if (point.status == KeypointStatus::missing || !point.pixel_px.allFinite()) continue;
      const double told_px = std::isfinite(point.sigma_px) ? point.sigma_px : config.sigma_px;
      const EyeNode node{point.pixel_px, std::hypot(told_px, config.lens_px)};
      (k == 0 ? nodes.roots : nodes.nodes).push_back(node);
    }
  }
  return nodes;
}

/// A frame with what its stages share.
struct MaizeFrame {
  std::size_t place = 0;
  const Frame* frame = nullptr;
  EyeNodes left, right;
  std::vector<MatchedPlant> plants;
  std::string why_none;  ///< why it has no plants
};

/// Leaves out shifts that the points themselves speak against: a window may show a leaf before the
/// stem, at one node or at all.
void drop_unlikely(std::vector<StemSighting>& sightings) {
  constexpr double kMost = 2.5, kSlack_px = 0.5;
  double sum_px = 0, variance = 0;
  int count = 0;
  for (StemSighting& s : sightings) {
    if (!s.shifted_px) continue;
    const double off_px = s.shifted_px->x() - s.right.pixel_px.x();
    const double sigma_px = std::hypot(s.left.sigma_px, s.right.sigma_px);
    if (std::abs(off_px) > kMost * sigma_px + kSlack_px) {
      s.shifted_px.reset();
      continue;
    }
    sum_px += off_px;
    variance += sigma_px * sigma_px;
    ++count;
  }
  if (count == 0 || std::abs(sum_px) <= kMost * std::sqrt(variance) + kSlack_px * count) return;
  for (StemSighting& s : sightings) s.shifted_px.reset();
}

/// Adds shifts that the images themselves show.
void add_shifts(const EyePair& eyes, const Frame& frame, const EpipolarOffset& offset,
                const NodeShiftConfig& config, std::vector<StemSighting>& sightings) {
  const Image<Rgb8>&left = frame.sensors[0].color, &right = frame.sensors[1].color;
  if (left.empty() || right.empty()) return;
  const EyePicture pictures[2] = {eye_picture(left), eye_picture(right)};
  for (StemSighting& s : sightings) {
    const NodeShift shift =
        find_shift(eyes, pictures[0], pictures[1], s.left, s.right, offset.offset_px, config);
    if (!shift.why_none.empty()) continue;
    s.shifted_px = shift.right_px;
    s.shift_sigma_px = config.sigma_px;
  }
  drop_unlikely(sightings);
}

/// A frame's depth, found once it is asked for.
class FrameDepths {
 public:
  FrameDepths(const Capture& capture, const PlantHeightConfig& config)
      : capture_(capture), config_(config) {}
  const PairDepth& of(std::size_t place) {
    const auto known = known_.find(place);
    if (known != known_.end()) return known->second;
    const Frame& frame = capture_.frames[place];
    known_.clear();  // plants come frame by frame
    return known_
        .emplace(place, pair_depth(eyes_of(capture_, frame), frame.sensors[0].color,
                                   frame.sensors[1].color, config_))
        .first->second;
  }

 private:
  const Capture& capture_;
  const PlantHeightConfig& config_;
  std::map<std::size_t, PairDepth> known_;
};

/// Where a plant grows to, by the soil about its root.
StemUp up_of(const EyePair& eyes, const MaizeFrame& frame, const MatchedPlant& plant,
             FrameDepths& depths, const MaizePipelineConfig& config) {
  const Frame& images = *frame.frame;
  if (!plant.has_root || images.sensors[0].color.empty() || images.sensors[1].color.empty())
    return {};
  const NodePair& root = plant.pairs.front();
  const auto foot = middle_of_rays(eyes, root.left.pixel_px, root.right.pixel_px);
  if (!foot) return {};
  const auto up = ground_up(depths.of(frame.place), *foot, config.height);
  return up ? StemUp{*up, true} : StemUp{};
}

StemNodes nodes_of(const EyePair& eyes, const MaizeFrame& frame, const MatchedPlant& plant,
                   const EpipolarOffset& offset, FrameDepths& depths,
                   const MaizePipelineConfig& config) {
  std::vector<StemSighting> sightings;
  for (const NodePair& pair : plant.pairs)
    sightings.push_back({.left = pair.left, .right = pair.right});
  if (config.method == MaizeMethod::paper) return nodes_by_middle(eyes, sightings);
  const double wait_s = apart_s(*frame.frame);
  if (config.method == MaizeMethod::triangulation)
    return nodes_by_pixels(eyes, sightings, config.stem, wait_s);
  if (!config.match_images) return nodes_on_stem(eyes, sightings, config.stem, wait_s);
  add_shifts(eyes, *frame.frame, offset, config.shift, sightings);
  return nodes_on_stem(eyes, sightings, config.stem, wait_s,
                       up_of(eyes, frame, plant, depths, config));
}

/// How unlike two roots look.
Unlikeness root_likeness(const EyePair& eyes, const Frame& frame) {
  const Image<Rgb8>&left = frame.sensors[0].color, &right = frame.sensors[1].color;
  if (left.empty() || right.empty()) return {};
  const auto pictures = std::make_shared<std::array<EyePicture, 2>>(
      std::array<EyePicture, 2>{eye_picture(left), eye_picture(right)});
  const NodeShiftConfig windows{
      .half_width_px = 20, .half_height_px = 20, .search_px = 4, .least_likeness = 0};
  return [&eyes, pictures, windows](const Eigen::Vector2d& l, const Eigen::Vector2d& r) {
    const NodeShift shift =
        find_shift(eyes, (*pictures)[0], (*pictures)[1], {l, 1}, {r, 1}, 0, windows);
    return shift.why_none.empty() ? 1 - std::max(0.0, shift.likeness) : 1;
  };
}

// ---- Stages
// --------------------------------------------------------------------------------------

std::vector<MaizeFrame> matched_frames(const Capture& capture, const Keypoints& keypoints,
                                       const MaizePipelineConfig& config,
                                       const EpipolarOffset& offset) {
  std::vector<MaizeFrame> frames;
  for (std::size_t f = 0; f < capture.frames.size(); ++f) {
    MaizeFrame here;
    here.place = f;
    here.frame = &capture.frames[f];
    here.why_none = why_no_pair(capture, *here.frame, config);
    if (here.why_none.empty()) {
      const EyePair eyes = eyes_of(capture, *here.frame);
      here.left = nodes_of_image(keypoints, here.frame->id, 0, config);
      here.right = nodes_of_image(keypoints, here.frame->id, 1, config);
      const std::size_t most = std::max(here.left.roots.size() + here.left.nodes.size(),
                                        here.right.roots.size() + here.right.nodes.size());
      if (most > static_cast<std::size_t>(config.most_points)) {
        here.why_none = "an image has " + std::to_string(most) +
                        " keypoints; most_points = " + std::to_string(config.most_points);
        frames.push_back(std::move(here));
        continue;
      }
      const bool is_row = here.left.roots.size() > 1 || here.right.roots.size() > 1;
      here.plants = config.method == MaizeMethod::paper
                        ? match_by_paper(eyes, here.left, here.right, config.match)
                        : match_in_order(eyes, here.left, here.right, config.match, offset,
                                         is_row ? root_likeness(eyes, *here.frame) : Unlikeness{});
      if (here.plants.empty()) {
        here.why_none = here.left.nodes.empty() && here.left.roots.empty()
                            ? "the left image has no keypoints"
                            : "no keypoint of the left image has its like on the epipolar line of "
                              "the right one before both eyes";
      }
    }
    frames.push_back(std::move(here));
  }
  return frames;
}

Fits stems_of(const Capture& capture, const Keypoints& keypoints,
              const MaizePipelineConfig& config) {
  std::vector<MaizeFrame> frames = matched_frames(capture, keypoints, config, {});
  EpipolarOffset offset;
  if (config.method != MaizeMethod::paper) {
    std::vector<MatchedPlant> all;
    for (const MaizeFrame& frame : frames)
      all.insert(all.end(), frame.plants.begin(), frame.plants.end());
    offset = epipolar_offset(all, config.match);
    frames = matched_frames(capture, keypoints, config, offset);
  }
  Fits fits;
  FrameDepths depths(capture, config.height);
  for (const MaizeFrame& frame : frames) {
    int number = static_cast<int>(frame.place) * kPlantsOfFrame;
    if (frame.plants.empty()) {
      ObjectFit none = stem_as_fit({}, number, false);
      none.reason = frame.why_none;
      fits.push_back(std::move(none));
    }
    const EyePair eyes = frame.plants.empty()
                             ? EyePair(capture.rig[0].camera, capture.rig[1].camera, Pose{})
                             : eyes_of(capture, *frame.frame);
    for (const MatchedPlant& plant : frame.plants)
      fits.push_back(stem_as_fit(nodes_of(eyes, frame, plant, offset, depths, config), number++,
                                 plant.has_root));
  }
  return fits;
}

PlantHeight height_by_paper(const EyePair& eyes, const Frame& frame, const FittedStem& stem,
                            const PlantHeightConfig& config) {
  EyeNode root[2], node[2];
  for (int eye = 0; eye < 2; ++eye) {
    for (int k = 0; k < 2; ++k) {
      const Eigen::Vector3d& at_m = stem.nodes.nodes_m[static_cast<std::size_t>(k)];
      const auto seen =
          eye == 0 ? eyes.left.project(at_m) : eyes.right.project(eyes.right_from_left * at_m);
      PlantHeight none;
      none.why_none = "a node is behind an eye";
      if (!seen) return none;
      (k == 0 ? root : node)[eye].pixel_px = *seen;
    }
  }
  return height_by_green(eyes, frame.sensors[0].color, frame.sensors[1].color, root, node, config);
}

/// Deviation of the scale of lengths at a depth: of the disparity's offset, and of the rest.
double scale_sigma(const EyePair& eyes, const StemFitConfig& config, double depth_m) {
  const double disparity_px = eyes.baseline_m * eyes.left.camera().fx_px / depth_m;
  return std::hypot(config.calibration_px / disparity_px, config.calibration_share);
}

PlantHeight height_of(const EyePair& eyes, const Frame& frame, std::size_t place,
                      const FittedStem& stem, FrameDepths& depths,
                      const MaizePipelineConfig& config) {
  PlantHeight none;
  none.why_none = !stem.has_root ? "the root is not matched" : "the frame has no colour";
  if (!stem.has_root || frame.sensors[0].color.empty() || frame.sensors[1].color.empty())
    return none;
  if (config.method == MaizeMethod::paper) {
    none.why_none = "no node is matched beside the root";
    if (stem.nodes.nodes_m.size() < 2) return none;
    return height_by_paper(eyes, frame, stem, config.height);
  }
  const Eigen::Vector3d& root_m = stem.nodes.nodes_m.front();
  // The root's height alone counts; what its depth is off is the scale's.
  const Eigen::MatrixXd& covariance_m2 = stem.nodes.covariance_m2;  // the root is first
  const double root_sigma_m = covariance_m2.size() > 0
                                  ? std::sqrt(covariance_m2(1, 1))
                                  : root_m.z() / eyes.left.camera().fy_px * config.sigma_px;
  return height_above_ground(depths.of(place), root_m, root_sigma_m,
                             scale_sigma(eyes, config.stem, root_m.z()), config.height);
}

SpecimenTraits traits_of_stem(const Capture& capture, const ObjectFit& fit, FrameDepths& depths,
                              const MaizePipelineConfig& config) {
  SpecimenTraits traits;
  traits.instance = fit.instance;
  const std::size_t place = static_cast<std::size_t>(fit.instance / kPlantsOfFrame);
  if (fit.instance < 0 || place >= capture.frames.size())
    throw StageError("traits", "fits.json: stem " + std::to_string(fit.instance) + " is of frame " +
                                   std::to_string(place) + ", and the capture has " +
                                   std::to_string(capture.frames.size()));
  const Frame& frame = capture.frames[place];
  traits.frame = frame.id;
  const FittedStem stem = stem_of_fit(fit);
  traits.reason = fit.reason;
  if (fit.status != FitStatus::ok) return traits;
  const auto add = [&](const std::string& name, double value_m, double sigma_m) {
    traits.traits.push_back({name, "m", value_m, sigma_m});
  };
  for (std::size_t i = 1; i < stem.nodes.nodes_m.size(); ++i) {
    const StemLength straight = chord(stem.nodes, i - 1, i), bent = along(stem.nodes, i - 1, i);
    add("internode_" + std::to_string(i), straight.value_m, straight.sigma_m);
    add("internode_geodesic_" + std::to_string(i), bent.value_m, bent.sigma_m);
  }
  PlantHeight height;
  height.why_none = "it is not asked for";
  if (config.measure_height)
    height = height_of(eyes_of(capture, frame), frame, place, stem, depths, config);
  if (height.why_none.empty()) add("plant_height", height.height_m, height.sigma_m);
  traits.reason = height.why_none.empty() ? "" : "no height: " + height.why_none;
  if (traits.traits.empty()) {
    traits.reason = "one node is no internode; " + traits.reason;
  } else {
    traits.status = TraitStatus::ok;
  }
  return traits;
}

Traits traits_of_stems(const Capture& capture, const Fits& fits,
                       const MaizePipelineConfig& config) {
  FrameDepths depths(capture, config.height);
  Traits traits;
  for (const ObjectFit& fit : fits) traits.push_back(traits_of_stem(capture, fit, depths, config));
  return traits;
}

}  // namespace

std::string_view to_string(MaizeMethod method) {
  return name_in<MaizeMethod>(kMaizeMethods, method);
}

Fields fields(MaizePipelineConfig& c) {
  return Fields{{"method", choice_field<MaizeMethod>("method", kMaizeMethods, c.method),
                 "ours: a smooth stem through nodes matched in order; triangulation: each by "
                 "itself; paper: epipolar test and mid-points"},
                {"sigma_px", &c.sigma_px, "deviation of a keypoint whose detector gives none", 0.01,
                 1000},
                {"lens_px", &c.lens_px, "deviation of what the reported lens is off in one place",
                 0, 100},
                {"most_apart_s", &c.most_apart_s, "exposures farther apart are no pair", 0, 1000},
                {"match_images", &c.match_images,
                 "ours: the images themselves say how far nodes are apart in them, and the soil "
                 "what is up"},
                {"measure_height", &c.measure_height, "of plants, too"},
                {"most_points", &c.most_points,
                 "keypoints of an image; a frame with more is not solved", 2, 250}} +
         nested("match", fields(c.match)) + nested("shift", fields(c.shift)) +
         nested("stem", fields(c.stem)) + nested("height", fields(c.height));
}

void validate(const MaizePipelineConfig& config) {
  MaizePipelineConfig copy = config;
  check_limits(fields(copy));
}

PipelineNeeds needs(const MaizePipelineConfig&) {
  return {.images = {"color"}, .stages = {"keypoints", "fits", "traits"}, .left_out = {}};
}

std::vector<std::string> unused_settings(const MaizePipelineConfig& config) {
  const std::string_view method = to_string(config.method);
  if (config.method == MaizeMethod::paper)
    return keys_without_effect(config, method, {"stem.", "shift.", "match_images"});
  if (config.method == MaizeMethod::triangulation)
    return keys_without_effect(config, method, {"shift.", "match_images"});
  return {};
}

void check_capture(const Capture& capture, const MaizePipelineConfig& config) {
  const bool is_pair = capture.rig.size() >= 2 && capture.rig[1].name != kDepthSensor;
  if (is_pair) return;
  throw std::invalid_argument("method " + std::string(to_string(config.method)) +
                              " of maize reads a stereo pair, and the capture has " +
                              std::to_string(capture.rig.size()) + " sensors, of which two are " +
                              "to be cameras (rig=zed_hd720)");
}

Stages stages_for(const MaizePipelineConfig& config, const Capture& /*capture*/,
                  std::uint64_t /*seed*/, const SplatWatch& /*watch*/) {
  Stages stages;
  stages.fits = [config](const Capture& capture, const Estimate& so_far) {
    return stems_of(capture, so_far.keypoints, config);
  };
  stages.traits = [config](const Capture& capture, const Estimate& so_far) {
    return traits_of_stems(capture, so_far.fits, config);
  };
  return stages;
}

const PipelineRow& maize_pipeline();
const PipelineRow& row_of(const MaizePipelineConfig& /*config*/) { return maize_pipeline(); }

const PipelineRow& maize_pipeline() {
  static constexpr auto kOrder = std::to_array<std::string_view>({"keypoints", "fits", "traits"});
  static const PipelineRow kRow = {
      .name = "maize",
      .help = "nodes, internodes and height of plants, from keypoints in a stereo pair",
      .scenes = {"maize"},
      .order = kOrder,
      .from_outside = {"keypoints"},
      .keypoints = {"root", "node"},
      .traits_of = TraitsOf::plants,
      .traits = {"internode", "internode_geodesic", "plant_height"},
      .methods = {{"ours",
                   "nodes matched in their order along the stem, shifts from the images, a smooth "
                   "stem, with its uncertainty"},
                  {"triangulation", "the same matches, each node placed by its own pixels"},
                  {"paper",
                   "the paper's rule: epipolar test both ways, mid-points, chords, the farthest "
                   "green pixel"}},
      .defaults = [] { return PipelineConfig(MaizePipelineConfig{}); }};
  return kRow;
}

}  // namespace cousin
