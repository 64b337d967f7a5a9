// corners.json
//   {"frames": [{"frame": 0, "status": "ok",
//                "corners": [{"column", "row", "pixel_px": [x, y],
//                             "covariance_px2": [xx, xy, yy]}]}]}
//   "sigma_px" instead where both axes have one sigma; neither: 0.1 px.
// poses.json
//   {"frames": [{"frame": 0, "status": "ok", "camera_from_world": POSE, "camera": CAMERA,
//                "covariance": [36, row-major], "rms_px": number or null, "corner_count"}]}
//   POSE and CAMERA as in rig.json. A frame that is not ok has frame and status, and maybe camera,
//   rms_px and corner_count.
// traits.json
//   {"specimens": [{"instance": 0, "frame": 12, "status": "ok", "reason": "",
//                   "centroid_in_world_m": [3] or null,
//                   "traits": [{"name": "length", "unit": "m", "value": number or null,
//                               "sigma": number or null}]}]}
//   "frame" only where one frame alone was measured: "instance" is then the id of its box.
//   Values of any unit that units.h knows are converted to its SI unit, others are refused.
// timings.json
//   {"stages": [{"stage": "poses", "wall_s", "cpu_s", "peak_rss_mb",
//                "peak_above_start_mb"}]}, the last may be absent or null

#include "sim/dataset/seam_json.h"

#include <set>
#include <stdexcept>
#include <utility>

#include "sim/dataset/json_interop.h"
#include "sim/dataset/units.h"

namespace cousin {
namespace {

constexpr std::size_t kMaxSeamFrames = 1'000'000;
constexpr std::size_t kMaxCorners = 100'000;  ///< of one frame
constexpr std::size_t kMaxSpecimens = 10'000'000;
constexpr std::size_t kMaxTraits = 1000;  ///< of one specimen
constexpr int kMaxInstance = 1'000'000'000;
constexpr double kMaxVariance = 1e12;        ///< px^2
constexpr double kLeastDeterminant = 1e-12;  ///< of a covariance, over the variances' product

int read_frame_number(const JsonNode& node, std::set<int>& seen) {
  const int frame = static_cast<int>(node.integer(0, 999'999));
  if (!seen.insert(frame).second) node.fail("is a frame that occurs twice");
  return frame;
}

Json one_key(const char* key, Json value) {
  Json root = Json::object();
  root[key] = std::move(value);
  return root;
}

FrameCorners read_frame_corners(const JsonNode& node, std::set<int>& seen) {
  node.expect_keys({"frame", "status", "corners"});
  FrameCorners frame;
  frame.frame = read_frame_number(node["frame"], seen);
  frame.status =
      node["status"].choice({BoardStatus::ok, BoardStatus::not_seen, BoardStatus::too_few_corners,
                             BoardStatus::ambiguous, BoardStatus::no_image});
  std::set<std::pair<int, int>> places;
  for (const JsonNode& entry : node["corners"].elements(kMaxCorners)) {
    entry.expect_keys({"column", "row", "pixel_px"}, {"covariance_px2", "sigma_px"});
    CornerObservation corner;
    corner.column = static_cast<int>(entry["column"].integer(0, 9999));
    corner.row = static_cast<int>(entry["row"].integer(0, 9999));
    if (!places.emplace(corner.column, corner.row).second)
      entry.fail("has a (column, row) that occurs twice");
    corner.pixel_px = entry["pixel_px"].vector<2>();
    if (entry.has("covariance_px2")) {
      const Eigen::Vector3d c = entry["covariance_px2"].vector<3>();
      corner.covariance_px2 << c[0], c[1], c[1], c[2];
      if (!(c[0] > 0 && c[2] > 0 && c[0] <= kMaxVariance && c[2] <= kMaxVariance &&
            c[0] * c[2] - c[1] * c[1] > kLeastDeterminant * c[0] * c[2])) {
        entry["covariance_px2"].fail(
            "is not a positive definite covariance [xx, xy, yy] up to 1e12 px^2");
      }
      if (entry.has("sigma_px")) entry["sigma_px"].fail("comes beside covariance_px2");
    } else if (entry.has("sigma_px")) {
      const double sigma_px = entry["sigma_px"].number(0, 1e6);
      if (!(sigma_px > 0)) entry["sigma_px"].fail("is not positive");
      corner.covariance_px2 = isotropic_px2(sigma_px);
    }
    frame.corners.push_back(corner);
  }
  return frame;
}

FramePose read_frame_pose(const JsonNode& node, std::set<int>& seen) {
  FramePose pose;
  node.expect_keys({"frame", "status"},
                   {"camera_from_world", "camera", "covariance", "rms_px", "corner_count"});
  pose.frame = read_frame_number(node["frame"], seen);
  pose.status = node["status"].choice(
      {PoseStatus::ok, PoseStatus::no_board, PoseStatus::degenerate, PoseStatus::not_converged});
  const bool ok = pose.status == PoseStatus::ok;
  if (ok || node.has("camera")) {
    pose.camera = read_camera(node["camera"], "frame " + std::to_string(pose.frame));
  }
  if (ok) pose.camera_from_world = read_pose(node["camera_from_world"]);
  if (node.has("covariance")) {
    pose.covariance = node["covariance"].matrix<6, 6>();
    for (int i = 0; i < 6; ++i) {
      if (pose.covariance(i, i) < 0) node["covariance"].fail("has a negative variance");
    }
  }
  if (node.has("rms_px")) pose.rms_px = node["rms_px"].number_or_nan();
  if (node.has("corner_count"))
    pose.corner_count = static_cast<int>(node["corner_count"].integer(0, 1'000'000));
  return pose;
}

SiUnit read_unit(const JsonNode& node) {
  const std::string unit = node.text(16);
  try {
    return si_unit(unit);
  } catch (const std::invalid_argument& error) {
    node.fail(error.what());
  }
}

/// A trait in SI: of a file in millimetres, value and sigma are converted.
Trait read_trait(const JsonNode& entry) {
  entry.expect_keys({"name", "unit", "value"}, {"sigma"});
  const SiUnit unit = read_unit(entry["unit"]);
  Trait trait{.name = entry["name"].text(64),
              .unit = std::string(unit.si_unit),
              .value = entry["value"].number_or_nan()};
  if (entry.has("sigma")) trait.sigma = entry["sigma"].number_or_nan();
  if (trait.sigma < 0) entry["sigma"].fail("is negative");
  trait.value *= unit.factor;
  trait.sigma *= unit.factor;
  return trait;
}

SpecimenTraits read_specimen(const JsonNode& node) {
  node.expect_keys({"instance", "status", "traits"}, {"frame", "reason", "centroid_in_world_m"});
  SpecimenTraits specimen;
  specimen.instance = static_cast<int>(node["instance"].integer(0, kMaxInstance));
  if (node.has("frame")) specimen.frame = static_cast<int>(node["frame"].integer(0, kMaxInstance));
  specimen.status = node["status"].choice({TraitStatus::ok, TraitStatus::not_solved});
  if (node.has("reason")) specimen.reason = node["reason"].text();
  if (node.has("centroid_in_world_m") && !node["centroid_in_world_m"].is_null()) {
    specimen.centroid_in_world_m = node["centroid_in_world_m"].vector<3>();
  }
  std::set<std::string> names;
  for (const JsonNode& entry : node["traits"].elements(kMaxTraits)) {
    Trait trait = read_trait(entry);
    if (!names.insert(trait.name).second) entry["name"].fail("is a trait that occurs twice");
    specimen.traits.push_back(std::move(trait));
  }
  return specimen;
}

}  // namespace

std::string corners_to_json(const Corners& corners) {
  Json frames = Json::array();
  for (const FrameCorners& frame : corners) {
    Json entries = Json::array();
    for (const CornerObservation& corner : frame.corners) {
      entries.push_back({{"column", corner.column},
                         {"row", corner.row},
                         {"pixel_px", to_json(corner.pixel_px)},
                         {"covariance_px2",
                          {corner.covariance_px2(0, 0), corner.covariance_px2(0, 1),
                           corner.covariance_px2(1, 1)}}});
    }
    frames.push_back(
        {{"frame", frame.frame}, {"status", to_string(frame.status)}, {"corners", entries}});
  }
  return to_text(one_key("frames", frames));
}

Corners corners_from_json(std::string_view text, const std::string& name) {
  const JsonDocument document(text, name);
  const JsonNode root = document.root();
  root.expect_keys({"frames"});
  Corners corners;
  std::set<int> seen;
  for (const JsonNode& node : root["frames"].elements(kMaxSeamFrames))
    corners.push_back(read_frame_corners(node, seen));
  return corners;
}

std::string poses_to_json(const Poses& poses) {
  Json frames = Json::array();
  for (const FramePose& pose : poses) {
    Json entry = {{"frame", pose.frame}, {"status", to_string(pose.status)}};
    if (pose.status == PoseStatus::ok) {
      entry["camera_from_world"] = to_json(pose.camera_from_world);
      entry["covariance"] = to_json(pose.covariance);
    }
    if (pose.status == PoseStatus::ok || pose.camera.width_px > 0)
      entry["camera"] = to_json(pose.camera);
    entry["rms_px"] = nan_to_null(pose.rms_px);
    entry["corner_count"] = pose.corner_count;
    frames.push_back(entry);
  }
  return to_text(one_key("frames", frames));
}

Poses poses_from_json(std::string_view text, const std::string& name) {
  const JsonDocument document(text, name);
  const JsonNode root = document.root();
  root.expect_keys({"frames"});
  Poses poses;
  std::set<int> seen;
  for (const JsonNode& node : root["frames"].elements(kMaxSeamFrames))
    poses.push_back(read_frame_pose(node, seen));
  return poses;
}

std::string traits_to_json(const Traits& traits) {
  Json specimens = Json::array();
  for (const SpecimenTraits& specimen : traits) {
    Json entries = Json::array();
    for (const Trait& trait : specimen.traits) {
      entries.push_back({{"name", trait.name},
                         {"unit", trait.unit},
                         {"value", nan_to_null(trait.value)},
                         {"sigma", nan_to_null(trait.sigma)}});
    }
    const bool known = specimen.centroid_in_world_m.allFinite();
    Json entry = {
        {"instance", specimen.instance},
        {"status", to_string(specimen.status)},
        {"reason", specimen.reason},
        {"centroid_in_world_m", known ? to_json(specimen.centroid_in_world_m) : Json(nullptr)},
        {"traits", entries}};
    if (specimen.frame >= 0) entry["frame"] = specimen.frame;
    specimens.push_back(std::move(entry));
  }
  return to_text(one_key("specimens", specimens));
}

Traits traits_from_json(std::string_view text, const std::string& name) {
  const JsonDocument document(text, name);
  const JsonNode root = document.root();
  root.expect_keys({"specimens"});
  Traits traits;
  std::set<std::pair<int, int>> seen;
  for (const JsonNode& node : root["specimens"].elements(kMaxSpecimens)) {
    traits.push_back(read_specimen(node));
    if (!seen.insert({traits.back().frame, traits.back().instance}).second)
      node["instance"].fail("is an instance that occurs twice");
  }
  return traits;
}

std::string timings_to_json(const std::vector<StageTiming>& timings) {
  Json stages = Json::array();
  for (const StageTiming& timing : timings) {
    stages.push_back({{"stage", timing.stage},
                      {"wall_s", timing.wall_s},
                      {"cpu_s", timing.cpu_s},
                      {"peak_rss_mb", timing.peak_rss_mb},
                      {"peak_above_start_mb", nan_to_null(timing.peak_above_start_mb)}});
  }
  return to_text(one_key("stages", stages));
}

std::vector<StageTiming> timings_from_json(std::string_view text, const std::string& name) {
  const JsonDocument document(text, name);
  const JsonNode root = document.root();
  root.expect_keys({"stages"});
  std::vector<StageTiming> timings;
  for (const JsonNode& node : root["stages"].elements(10'000)) {
    node.expect_keys({"stage", "wall_s", "cpu_s", "peak_rss_mb"}, {"peak_above_start_mb"});
    timings.push_back({.stage = node["stage"].text(256),
                       .wall_s = node["wall_s"].number(),
                       .cpu_s = node["cpu_s"].number(),
                       .peak_rss_mb = node["peak_rss_mb"].number()});
    if (node.has("peak_above_start_mb"))
      timings.back().peak_above_start_mb = node["peak_above_start_mb"].number_or_nan();
  }
  return timings;
}

}  // namespace cousin
