#include "sim/dataset/capture_json.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "sim/dataset/json_interop.h"
#include "sim/types/calibration_target.h"

namespace cousin {
namespace {

constexpr std::size_t kMaxSensors = 64;
constexpr std::size_t kMaxFrames = 1'000'000;
constexpr std::size_t kMaxWarnings = 1'000'000;

bool is_sensor_name(const std::string& name) {
  return !name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
  });
}

std::string_view to_string(Shutter shutter) {
  return shutter == Shutter::global ? "global" : "rolling";
}

/// Row-major camera matrix of BOP.
Json camera_matrix(const Camera& c) {
  return {c.fx_px, 0.0, c.cx_px, 0.0, c.fy_px, c.cy_px, 0.0, 0.0, 1.0};
}

Pose first_sensor_from_world(const Capture& capture, const Frame& frame) {
  return capture.rig.front().sensor_from_rig * *frame.rig_from_world;
}

RawFormat read_raw_format(const JsonNode& node) {
  node.expect_keys({"mosaic", "bits", "black_level"});
  RawFormat format;
  format.mosaic =
      node["mosaic"].choice({Mosaic::grey, Mosaic::rggb, Mosaic::bggr, Mosaic::grbg, Mosaic::gbrg});
  format.bits = static_cast<int>(node["bits"].integer(1, 16));
  format.black_level = static_cast<int>(node["black_level"].integer(0, 65535));
  try {
    validate(format);
  } catch (const std::invalid_argument& error) {
    node.fail(error.what());
  }
  return format;
}

SensorReport read_sensor(const JsonNode& node, std::size_t index) {
  node.expect_keys(
      {"name", "camera", "sensor_from_rig", "exposure_s", "shutter", "readout_s", "linear_raw"},
      {"raw_format"});
  SensorReport sensor;
  sensor.name = node["name"].text(64);
  sensor.camera = read_camera(node["camera"], "sensor " + std::to_string(index));
  sensor.sensor_from_rig = read_pose(node["sensor_from_rig"]);
  sensor.exposure_s = node["exposure_s"].number(0, 1e6);
  const std::string shutter = node["shutter"].text(16);
  if (shutter != "global" && shutter != "rolling")
    node["shutter"].fail("is not one of global, rolling");
  sensor.shutter = shutter == "global" ? Shutter::global : Shutter::rolling;
  sensor.readout_s = node["readout_s"].number(0, 1e6);
  sensor.linear_raw = node["linear_raw"].boolean();
  if (node.has("raw_format")) sensor.raw_format = read_raw_format(node["raw_format"]);
  return sensor;
}

ImageKinds read_image_kinds(const JsonNode& node) {
  ImageKinds kinds;
  for (const JsonNode& image : node.elements(4)) {
    const std::string kind = image.text(16);
    if (kind == "color") {
      kinds.color = true;
    } else if (kind == "grey") {
      kinds.grey = true;
    } else if (kind == "raw") {
      kinds.raw = true;
    } else if (kind == "depth") {
      kinds.depth = true;
    } else {
      image.fail("is not one of color, grey, raw, depth");
    }
  }
  if (kinds.color && kinds.grey) node.fail("has both color and grey, which share a folder");
  return kinds;
}

/// cam_K, checked: no skew, last row 0 0 1.
void read_camera_matrix(const JsonNode& node, const std::string& context, Camera& camera) {
  const std::vector<double> k = node.numbers(9, 9);
  if (k[1] != 0 || k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1) {
    node.fail("is not fx 0 cx, 0 fy cy, 0 0 1 (" + context + ")");
  }
  camera.fx_px = k[0];
  camera.cx_px = k[2];
  camera.fy_px = k[4];
  camera.cy_px = k[5];
}

std::optional<Pose> read_bop_pose(const JsonNode& node) {
  if (!node.has("cam_R_w2c") && !node.has("cam_t_w2c")) return std::nullopt;
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = node["cam_R_w2c"].matrix<3, 3>();
  matrix.topRightCorner<3, 1>() = 1e-3 * node["cam_t_w2c"].vector<3>();
  try {
    return pose_from_matrix(matrix);
  } catch (const std::invalid_argument& error) {
    node["cam_R_w2c"].fail(error.what());
  }
}

/// A frame of another program: the first sensor only.
void read_bop_frame(const JsonNode& node, const std::string& context, const Capture& capture,
                    Frame& frame, std::vector<ImageKinds>& kinds) {
  if (capture.rig.size() != 1)
    node.fail("lacks the key \"cousin\", which a rig of several sensors needs (" + context + ")");
  SensorFrame& sensor = frame.sensors.front();
  sensor.reported = capture.rig.front().camera;
  read_camera_matrix(node["cam_K"], context, sensor.reported);
  try {
    validate(sensor.reported);
  } catch (const std::invalid_argument& error) {
    node["cam_K"].fail("(" + context + "): " + error.what());
  }
  kinds.front() = {.color = true, .depth_if_there = true};
  kinds.front().depth_has_scale = node.has("depth_scale");
  if (node.has("depth_scale")) sensor.depth_unit_m = 1e-3 * node["depth_scale"].number(1e-9, 1e6);
  if (const std::optional<Pose> pose = read_bop_pose(node)) {
    frame.rig_from_world = inverse(capture.rig.front().sensor_from_rig) * *pose;
  }
}

void read_own_frame(const JsonNode& node, const std::string& context, const Capture& capture,
                    Frame& frame, std::vector<ImageKinds>& kinds) {
  const JsonNode own = node["cousin"];
  own.expect_keys({"time_s", "sensors"}, {"rig_from_world"});
  frame.time_s = own["time_s"].number();
  if (own.has("rig_from_world")) frame.rig_from_world = read_pose(own["rig_from_world"]);
  const std::size_t count = own["sensors"].size(kMaxSensors);
  if (count != capture.rig.size()) {
    own["sensors"].fail("does not have one entry for each of the rig's " +
                        std::to_string(capture.rig.size()) + " sensors");
  }
  for (std::size_t s = 0; s < count; ++s) {
    const JsonNode entry = own["sensors"][s];
    entry.expect_keys({"camera", "depth_unit_m", "images"}, {"time_s"});
    if (entry.has("time_s")) frame.sensors[s].time_s = entry["time_s"].number();
    frame.sensors[s].reported = read_camera(entry["camera"], context);
    frame.sensors[s].depth_unit_m = entry["depth_unit_m"].number(1e-12, 1e3);
    kinds[s] = read_image_kinds(entry["images"]);
  }

  // BOP's keys say the same in BOP's units. An edit of only one of the two is an error, not a
  // guess.
  const Camera& first = frame.sensors.front().reported;
  Camera bop = first;
  read_camera_matrix(node["cam_K"], context, bop);
  if (bop != first) node["cam_K"].fail("differs from cousin/sensors/0/camera (" + context + ")");
  if (node.has("depth_scale")) {
    const std::size_t depth = depth_sensor(capture.rig), scaled = depth < count ? depth : 0;
    const double unit_m = frame.sensors[scaled].depth_unit_m;
    const double excess_m = 1e-3 * node["depth_scale"].number(1e-9, 1e6) - unit_m;
    if (std::abs(excess_m) > 1e-9 * unit_m) {
      node["depth_scale"].fail("is not 1000 times cousin/sensors/" + std::to_string(scaled) +
                               "/depth_unit_m (" + context + ")");
    }
  }
  const std::optional<Pose> pose = read_bop_pose(node);
  if (pose.has_value() != frame.rig_from_world.has_value()) {
    node.fail("has only one of cam_R_w2c and cousin/rig_from_world (" + context + ")");
  }
  if (pose) {
    const Pose difference = inverse(first_sensor_from_world(capture, frame)) * *pose;
    if (angle_rad(difference.rotation) > 1e-6 ||
        difference.translation_m.norm() > 1e-6 * (1 + pose->translation_m.norm())) {
      node["cam_R_w2c"].fail("or cam_t_w2c differs from cousin/rig_from_world (" + context + ")");
    }
  }
}

}  // namespace

std::size_t depth_sensor(const std::vector<SensorReport>& rig) {
  const auto found = std::find_if(rig.begin(), rig.end(), [](const SensorReport& sensor) {
    return sensor.name == kDepthSensor;
  });
  return static_cast<std::size_t>(found - rig.begin());
}

std::string image_folder(const std::vector<SensorReport>& rig, std::size_t sensor, ImageKind kind) {
  const std::string& name = rig.at(sensor).name;
  if (kind == ImageKind::color || kind == ImageKind::grey) return name;
  if (kind == ImageKind::depth && name == kDepthSensor) return name;
  const std::string suffix = kind == ImageKind::raw ? "raw" : "depth";
  const bool is_taken = kind == ImageKind::depth && depth_sensor(rig) < rig.size();
  return sensor == 0 && !is_taken ? suffix : name + "_" + suffix;
}

void check_rig(const std::vector<SensorReport>& rig) {
  if (rig.empty() || rig.size() > kMaxSensors) {
    throw std::invalid_argument("rig: " + std::to_string(rig.size()) +
                                " sensors; there must be 1 to 64");
  }
  std::set<std::string> folders = {"truth"};
  for (std::size_t s = 0; s < rig.size(); ++s) {
    if (!is_sensor_name(rig[s].name)) {
      throw std::invalid_argument("rig: sensor name \"" + rig[s].name +
                                  "\" is not of 1 to 64 of a-z 0-9 _");
    }
    for (const ImageKind kind : {ImageKind::color, ImageKind::raw, ImageKind::depth}) {
      if (kind == ImageKind::color && rig[s].name == kDepthSensor) continue;  // it has none
      const std::string folder = image_folder(rig, s, kind);
      if (!folders.insert(folder).second) {
        throw std::invalid_argument("rig: two kinds of files would share the folder \"" + folder +
                                    "\"");
      }
    }
  }
}

std::string rig_to_json(const Capture& capture) {
  Json sensors = Json::array();
  for (const SensorReport& sensor : capture.rig) {
    Json entry = {{"name", sensor.name},
                  {"camera", to_json(sensor.camera)},
                  {"sensor_from_rig", to_json(sensor.sensor_from_rig)},
                  {"exposure_s", sensor.exposure_s},
                  {"shutter", to_string(sensor.shutter)},
                  {"readout_s", sensor.readout_s},
                  {"linear_raw", sensor.linear_raw}};
    const RawFormat& format = sensor.raw_format;
    if (format != RawFormat{}) {
      entry["raw_format"] = {{"mosaic", to_string(format.mosaic)},
                             {"bits", format.bits},
                             {"black_level", format.black_level}};
    }
    sensors.push_back(entry);
  }
  return to_text(Json{{"schema", 1},
                      {"pipeline", capture.pipeline},
                      {"board", capture.board},
                      {"warnings", capture.warnings},
                      {"sensors", sensors}});
}

std::string scene_camera_to_json(const Capture& capture,
                                 const std::vector<std::vector<ImageKinds>>& kinds) {
  Json root = Json::object();
  for (std::size_t f = 0; f < capture.frames.size(); ++f) {
    const Frame& frame = capture.frames[f];
    Json sensors = Json::array();
    for (std::size_t s = 0; s < frame.sensors.size(); ++s) {
      const SensorFrame& sensor = frame.sensors[s];
      Json images = Json::array();
      if (kinds[f][s].color) images.push_back("color");
      if (kinds[f][s].grey) images.push_back("grey");
      if (kinds[f][s].raw) images.push_back("raw");
      if (kinds[f][s].depth) images.push_back("depth");
      Json own = {{"camera", to_json(sensor.reported)},
                  {"depth_unit_m", sensor.depth_unit_m},
                  {"images", images}};
      if (sensor.time_s) own["time_s"] = *sensor.time_s;
      sensors.push_back(own);
    }
    const std::size_t depth = depth_sensor(capture.rig);
    const SensorFrame& scaled = frame.sensors[depth < frame.sensors.size() ? depth : 0];
    Json entry = {{"cam_K", camera_matrix(frame.sensors.front().reported)},
                  {"depth_scale", 1000 * scaled.depth_unit_m}};
    Json own = {{"time_s", frame.time_s}};
    if (frame.rig_from_world) {
      const Pose pose = first_sensor_from_world(capture, frame);
      entry["cam_R_w2c"] = to_json(pose.rotation.toRotationMatrix());
      entry["cam_t_w2c"] = to_json(1000 * pose.translation_m);
      own["rig_from_world"] = to_json(*frame.rig_from_world);
    }
    own["sensors"] = sensors;
    entry["cousin"] = own;
    root[std::to_string(frame.id)] = entry;
  }
  return to_text(root);
}

Capture rig_from_json(std::string_view text, const std::string& name) {
  const JsonDocument document(text, name);
  const JsonNode root = document.root();
  root.expect_keys({"schema", "sensors"}, {"pipeline", "board", "warnings"});
  root["schema"].integer(1, 1);
  Capture capture;
  if (root.has("pipeline")) capture.pipeline = root["pipeline"].text(64);
  if (root.has("board")) {
    capture.board = root["board"].text(200);
    if (capture.board != "" && capture.board != "markers" && capture.board != "plain" &&
        capture.board != "none") {
      try {
        target_from_text(capture.board);
      } catch (const std::invalid_argument& error) {
        root["board"].fail("is not one of markers, plain, none or empty, nor a target: " +
                           std::string(error.what()));
      }
    }
  }
  if (root.has("warnings")) {
    for (const JsonNode& warning : root["warnings"].elements(kMaxWarnings))
      capture.warnings.push_back(warning.text(65536));
  }
  const std::vector<JsonNode> sensors = root["sensors"].elements(kMaxSensors);
  for (std::size_t i = 0; i < sensors.size(); ++i)
    capture.rig.push_back(read_sensor(sensors[i], i));
  try {
    check_rig(capture.rig);
  } catch (const std::invalid_argument& error) {
    root["sensors"].fail(error.what());
  }
  return capture;
}

std::vector<std::vector<ImageKinds>> frames_from_json(std::string_view text,
                                                      const std::string& name, Capture& capture) {
  const JsonDocument document(text, name);
  capture.frames.clear();
  std::vector<std::pair<Frame, std::vector<ImageKinds>>> frames;
  std::set<int> ids;
  for (const auto& [key, node] : document.root().members(kMaxFrames)) {
    const bool is_number =
        !key.empty() && key.size() <= 6 && key.find_first_not_of("0123456789") == std::string::npos;
    if (!is_number) node.fail("is not under a frame number 0..999999");
    Frame frame;
    frame.id = std::stoi(key);
    if (!ids.insert(frame.id).second)
      node.fail("is a second entry of frame " + std::to_string(frame.id));
    frame.sensors.resize(capture.rig.size());
    std::vector<ImageKinds> kinds(capture.rig.size());
    const std::string context = "frame " + std::to_string(frame.id);
    // The last ones say of some BOP datasets how an image was made, not what it shows.
    node.expect_keys({"cam_K"}, {"depth_scale", "cam_R_w2c", "cam_t_w2c", "cousin", "view_level",
                                 "elev", "azimuth", "mode"});
    if (node.has("cousin")) {
      read_own_frame(node, context, capture, frame, kinds);
    } else {
      read_bop_frame(node, context, capture, frame, kinds);
    }
    frames.emplace_back(std::move(frame), std::move(kinds));
  }
  std::sort(frames.begin(), frames.end(),
            [](const auto& a, const auto& b) { return a.first.id < b.first.id; });
  std::vector<std::vector<ImageKinds>> all_kinds;
  for (auto& [frame, kinds] : frames) {
    capture.frames.push_back(std::move(frame));
    all_kinds.push_back(std::move(kinds));
  }
  return all_kinds;
}

}  // namespace cousin
