#include "sim/sensors/rig.h"

#include <algorithm>
#include <array>
#include <set>
#include <stdexcept>
#include <utility>

#include "sim/config/limits.h"
#include "sim/sensors/hand_motion.h"
#include "sim/sensors/rig_presets.h"

namespace cousin {
namespace {

constexpr std::size_t kMostSensors = 16;
constexpr std::array<std::pair<Evidence, std::string_view>, 3> kEvidenceNames = {
    {{Evidence::verified, "verified"},
     {Evidence::cross_checked, "cross-checked"},
     {Evidence::validated, "validated"}}};

Fields body_fields(RigConfig& config) {
  const TextField evidence{
      [&config] { return std::string(to_string(config.evidence)); },
      [&config](const std::string& text) { config.evidence = evidence_from_string(text); }};
  return {{"title", &config.title, "for lists"},
          {"evidence", evidence, "verified, cross-checked or validated"},
          {"evidence_by", &config.evidence_by, "which theory, program or device"},
          {"sync_error_s", &config.sync_error_s, "sigma of each sensor's start", 0, 1},
          {"hand_speed_m_per_s", &config.hand_speed_m_per_s,
           "sigma of the body's velocity, each axis", 0, 10},
          {"hand_rate_rad_per_s", &config.hand_rate_rad_per_s,
           "sigma of the body's turning rate, each axis", 0, 10}};
}

Fields sensor_fields(RigSensor& sensor) {
  return Fields{{"centre_in_rig_m", &sensor.centre_in_rig_m, "x, y, z of its centre", -10, 10},
                {"rig_from_sensor_rad", &sensor.rig_from_sensor_rad,
                 "rotation vector: axis times angle", -3.15, 3.15},
                {"trigger_delay_s", &sensor.trigger_delay_s, "start after the rig's time", -1, 1}} +
         fields(sensor.camera);
}

/// A preset's table of one sensor: what it does not give is as for all.
Fields preset_fields(RigSensor& sensor) {
  Fields rows = sensor_fields(sensor);
  constexpr std::ptrdiff_t kOwn = 3;  // place and delay
  for (auto row = rows.begin() + kOwn; row != rows.end(); ++row) row->optional = true;
  return rows;
}

void check_placement(const RigSensor& sensor) {
  const auto check = [&](const char* key, const std::vector<double>& numbers) {
    if (numbers.size() == 3) return;
    throw std::invalid_argument(sensor.name + "." + key + " has " + std::to_string(numbers.size()) +
                                " numbers, not 3");
  };
  check("centre_in_rig_m", sensor.centre_in_rig_m);
  check("rig_from_sensor_rad", sensor.rig_from_sensor_rad);
}

bool is_sensor_name(const std::string& name) {
  const auto is_letter = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
  };
  return !name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), is_letter);
}

/// Where the body is `time_s` after the frame's time.
Pose rig_from_world(const View& seen, double span_s, const HandMotion& hand, double time_s) {
  const Pose by_scene =
      span_s > 0 ? interpolate(seen.rig_from_world, seen.rig_from_world_end, time_s / span_s)
                 : seen.rig_from_world;
  return moved_rig_from_rig(hand, time_s) * by_scene;
}

}  // namespace

Pose sensor_from_rig(const RigSensor& sensor) {
  check_placement(sensor);
  Pose rig_from_sensor;
  rig_from_sensor.translation_m = Eigen::Vector3d(sensor.centre_in_rig_m.data());
  const Eigen::Vector3d turn_rad(sensor.rig_from_sensor_rad.data());
  if (const double angle = turn_rad.norm(); angle > 0) {
    rig_from_sensor.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn_rad / angle));
  }
  return inverse(rig_from_sensor);
}

Fields fields(RigConfig& config) {
  Fields rows = body_fields(config);
  for (RigSensor& sensor : config.sensors) rows = rows + nested(sensor.name, sensor_fields(sensor));
  return rows;
}

std::string_view to_string(Evidence evidence) {
  return kEvidenceNames.at(static_cast<std::size_t>(evidence)).second;
}

Evidence evidence_from_string(std::string_view text) {
  for (const auto& [evidence, name] : kEvidenceNames) {
    if (name == text) return evidence;
  }
  throw std::invalid_argument("evidence \"" + std::string(text) +
                              "\" is not one of verified, cross-checked, validated");
}

void validate(const RigConfig& config) {
  RigConfig copy = config;
  check_limits(body_fields(copy), "rig");
  if (config.sensors.empty() || config.sensors.size() > kMostSensors) {
    throw std::invalid_argument("rig: " + std::to_string(config.sensors.size()) +
                                " sensors; there must be 1 to " + std::to_string(kMostSensors));
  }
  std::set<std::string> names;
  for (const RigSensor& sensor : config.sensors) {
    if (!is_sensor_name(sensor.name)) {
      throw std::invalid_argument("rig: sensor name \"" + sensor.name +
                                  "\" is not of 1 to 64 of a-z 0-9 _");
    }
    if (!names.insert(sensor.name).second) {
      throw std::invalid_argument("rig: two sensors are named \"" + sensor.name + "\"");
    }
    check_placement(sensor);
    validate(sensor.camera, sensor.name);
  }
}

RigConfig rig_from_toml(std::string_view text, const std::string& name) {
  RigConfig config;
  CameraSensorConfig base;
  for (const std::string& table : toml_tables(text, name)) {
    if (table == "rig" || table == "camera") continue;
    config.sensors.push_back({.name = table, .camera = {}});
  }
  if (config.sensors.size() > kMostSensors) {
    throw std::runtime_error(name + ": " + std::to_string(config.sensors.size()) +
                             " sensors; there must be 1 to " + std::to_string(kMostSensors));
  }
  const auto read = [&] {
    Fields rows = nested("rig", body_fields(config)) + nested("camera", fields(base));
    for (RigSensor& sensor : config.sensors)
      rows = rows + nested(sensor.name, preset_fields(sensor));
    read_toml_text(text, name, rows, MissingKeys::error);
  };
  // Twice: what all sensors start from is known only after the first time.
  read();
  for (RigSensor& sensor : config.sensors) sensor.camera = base;
  read();
  try {
    validate(config);
  } catch (const std::exception& error) {
    throw std::runtime_error(name + ": " + error.what());
  }
  return config;
}

RigUnit make_rig(const RigConfig& config, const Rng& rng) {
  validate(config);
  RigUnit unit;
  for (const RigSensor& sensor : config.sensors) {
    unit.sensors.push_back(make_camera_unit(sensor.camera, rng.fork(sensor.name)));
  }
  return unit;
}

std::vector<TrueView> true_views(const RigConfig& config, const RigUnit& unit, const Scene& scene,
                                 int frame, const Rng& rng) {
  if (frame < 0 || frame >= static_cast<int>(scene.views.size())) {
    throw std::invalid_argument("rig: frame " + std::to_string(frame) +
                                " is not one of the scene's " + std::to_string(scene.views.size()) +
                                " views");
  }
  const View& seen = scene.views[static_cast<std::size_t>(frame)];
  const HandMotion hand =
      draw_hand_motion(config.hand_speed_m_per_s, config.hand_rate_rad_per_s, rng.fork("hand"));
  double span_s = 0;
  for (const RigSensor& s : config.sensors) {
    span_s = std::max(span_s, s.camera.photosites.readout_s);
  }
  std::vector<TrueView> views;
  for (std::size_t i = 0; i < config.sensors.size(); ++i) {
    const RigSensor& sensor = config.sensors[i];
    const PhotositesConfig& photosites = sensor.camera.photosites;
    const LensConfig& lens = sensor.camera.lens;
    const Rng own = rng.fork(sensor.name);
    Rng sync = own.fork("sync");
    const double start_s = sensor.trigger_delay_s + config.sync_error_s * normal(sync);
    const Pose from_rig = sensor_from_rig(sensor);
    const auto pose_at = [&](double time_s) {
      return from_rig * rig_from_world(seen, span_s, hand, time_s);
    };
    TrueView view;
    view.frame = frame;
    view.time_s = seen.time_s + start_s;
    view.exposure_s = photosites.exposure_s;
    view.readout_s = photosites.readout_s;
    view.camera_from_world = pose_at(start_s);
    view.camera_from_world_end = pose_at(start_s + photosites.readout_s);
    const double distance_m =
        (centre_in_world_m(view.camera_from_world) - seen.focus_in_world_m).norm();
    const FocusedLens focused = focused_lens(sensor.camera, unit.sensors.at(i), distance_m, own);
    view.camera = focused.camera;
    view.focus_m = focused.focus_m;
    if (lens.f_number > 0) view.aperture_radius_m = lens.focal_m / (2 * lens.f_number);
    views.push_back(view);
  }
  return views;
}

std::vector<SensorFrame> sense(const std::vector<Image<Rgbf>>& radiances, const RigConfig& config,
                               const RigUnit& unit, const std::vector<TrueView>& views,
                               const Rng& rng) {
  const std::size_t count = config.sensors.size();
  if (radiances.size() != count || views.size() != count || unit.sensors.size() != count) {
    throw std::invalid_argument("rig: " + std::to_string(radiances.size()) + " radiance images, " +
                                std::to_string(views.size()) + " views and " +
                                std::to_string(unit.sensors.size()) + " units for " +
                                std::to_string(count) + " sensors");
  }
  std::vector<SensorFrame> frames;
  for (std::size_t i = 0; i < count; ++i) {
    const RigSensor& sensor = config.sensors[i];
    frames.push_back(sense(radiances[i], sensor.camera, unit.sensors[i], views[i],
                           rng.fork(sensor.name).fork("sense")));
  }
  return frames;
}

std::vector<SensorReport> report_of(const RigConfig& config, const RigUnit& unit) {
  std::vector<SensorReport> reports;
  for (std::size_t i = 0; i < config.sensors.size(); ++i) {
    const RigSensor& sensor = config.sensors[i];
    reports.push_back(
        report_of(sensor.camera, unit.sensors.at(i), sensor.name, sensor_from_rig(sensor)));
  }
  return reports;
}

std::vector<std::string> rig_preset_names() { return preset_names(rig_preset_texts()); }

RigConfig rig_preset(const std::string& name) {
  return rig_from_toml(preset_toml(name, rig_preset_texts()), preset_title(name));
}

}  // namespace cousin
