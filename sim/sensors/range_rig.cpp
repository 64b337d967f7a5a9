#include "sim/sensors/range_rig.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "sim/config/limits.h"
#include "sim/sensors/depth_presets.h"

namespace cousin {
namespace {

constexpr const char* kTimeOfFlight = "time_of_flight";
constexpr const char* kStructuredLight = "structured_light";

Fields depth_fields(RangeRigConfig& config) {
  const bool by_time = std::holds_alternative<TimeOfFlightConfig>(config.depth);
  return nested(by_time ? kTimeOfFlight : kStructuredLight,
                std::visit([](auto& depth) { return fields(depth); }, config.depth));
}

Fields unit_fields(RangeRigConfig& config) {
  return {{"focal_error", &config.focal_error, "relative sigma between units", 0, 0.1},
          {"color_rotation_error_rad", &config.color_rotation_error_rad,
           "sigma of the colour camera's rotation about each axis", 0, 0.1}};
}

std::vector<PresetText> preset_texts() {
  const auto by_time = time_of_flight_preset_texts(), by_code = structured_light_preset_texts();
  std::vector<PresetText> texts(by_time.begin(), by_time.end());
  texts.insert(texts.end(), by_code.begin(), by_code.end());
  return texts;
}

/// The preset's depth camera of one kind.
template <class Depth>
Depth depth_of_preset(const std::string& name, const char* kind) {
  RangeRigConfig config = range_rig_preset(name);
  if (Depth* depth = std::get_if<Depth>(&config.depth)) return std::move(*depth);
  throw std::invalid_argument("rig \"" + name + "\" has no table [" + kind + "]");
}

}  // namespace

Fields fields(RangeRigConfig& config) {
  return fields(config.body) + unit_fields(config) + depth_fields(config);
}

void validate(const RangeRigConfig& config) {
  RangeRigConfig copy = config;
  check_limits(unit_fields(copy), "range rig");
  validate(config.body);
  if (config.body.sensors.size() != 1) {
    throw std::invalid_argument("range rig: " + std::to_string(config.body.sensors.size()) +
                                " colour cameras; there must be one");
  }
  std::visit([](const auto& depth) { validate(depth); }, config.depth);
}

Camera depth_camera(const RangeRigConfig& config) {
  return std::visit([](const auto& depth) { return depth_camera(depth); }, config.depth);
}

double depth_unit_m(const RangeRigConfig& config) {
  return std::visit([](const auto& depth) { return depth.depth_unit_m; }, config.depth);
}

RangeRigUnit make_range_rig(const RangeRigConfig& config, const Rng& rng) {
  validate(config);
  RangeRigUnit unit{.truth = config,
                    .depth_reported = depth_camera(config),
                    .color = make_rig(config.body, rng.fork("color")),
                    .color_from_rig = {},
                    .color_from_rig_reported = sensor_from_rig(config.body.sensors.front())};
  Rng errors = rng.fork("errors");
  const double focal = 1 + truncated_normal(errors, 0, config.focal_error);
  std::visit([&](auto& depth) { depth.focal_px *= focal; }, unit.truth.depth);
  Eigen::Vector3d turn_rad;
  for (double& a : turn_rad) a = truncated_normal(errors, 0, config.color_rotation_error_rad);
  Pose turn;
  if (const double angle = turn_rad.norm(); angle > 0)
    turn.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn_rad / angle));
  unit.color_from_rig = turn * unit.color_from_rig_reported;
  return unit;
}

RangeDepth sense_range(const RayScene& rays, const Scene& scene, const Pose& camera_from_world,
                       const RangeRigConfig& config, const Rng& fixed, const Rng& exposure) {
  if (const auto* by_time = std::get_if<TimeOfFlightConfig>(&config.depth)) {
    const TimeOfFlightInputs inputs =
        time_of_flight_inputs(rays, scene, camera_from_world, *by_time, fixed);
    TimeOfFlightDepth sensed =
        sense_time_of_flight(inputs, time_of_flight_light(inputs, *by_time), *by_time, exposure);
    return {std::move(sensed.depth), std::move(sensed.noise_free_depth_m),
            std::move(sensed.reason)};
  }
  const auto& by_code = std::get<StructuredLightConfig>(config.depth);
  StructuredLightDepth sensed = sense_structured_light(
      structured_light_inputs(rays, scene, camera_from_world, by_code), by_code, exposure);
  return {std::move(sensed.depth), std::move(sensed.noise_free_depth_m), std::move(sensed.reason)};
}

RangeRigConfig range_rig_preset(const std::string& name) {
  const std::vector<PresetText> texts = preset_texts();
  const std::string text = preset_toml(name, texts), title = preset_title(name);
  const std::vector<std::string> tables = toml_tables(text, title);
  const auto has = [&](const char* table) {
    return std::find(tables.begin(), tables.end(), table) != tables.end();
  };
  if (has(kTimeOfFlight) == has(kStructuredLight)) {
    throw std::runtime_error(title + ": there must be one table [" + kTimeOfFlight + "] or [" +
                             kStructuredLight + "]");
  }
  RangeRigConfig config;
  if (has(kStructuredLight)) config.depth = StructuredLightConfig{};
  read_toml_text(text, title, fields(config), MissingKeys::error);
  try {
    validate(config);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(title + ": " + error.what());
  }
  return config;
}

std::vector<std::string> range_rig_preset_names() { return preset_names(preset_texts()); }

TimeOfFlightConfig time_of_flight_preset(const std::string& name) {
  return depth_of_preset<TimeOfFlightConfig>(name, kTimeOfFlight);
}

std::vector<std::string> time_of_flight_preset_names() {
  return preset_names(time_of_flight_preset_texts());
}

StructuredLightConfig structured_light_preset(const std::string& name) {
  return depth_of_preset<StructuredLightConfig>(name, kStructuredLight);
}

std::vector<std::string> structured_light_preset_names() {
  return preset_names(structured_light_preset_texts());
}

}  // namespace cousin
