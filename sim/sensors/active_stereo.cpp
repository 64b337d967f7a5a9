#include "sim/sensors/active_stereo.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "sim/config/limits.h"
#include "sim/sensors/active_stereo_presets.h"

namespace cousin {
namespace {

[[noreturn]] void reject_stereo(const std::string& what) {
  throw std::invalid_argument("active stereo: " + what);
}

Fields match_fields(StereoMatchConfig& c) {
  const TextField fit{
      [&c] { return std::string(c.fit == SubPixelFit::parabola ? "parabola" : "equiangular"); },
      [&c](const std::string& text) {
        if (text != "parabola" && text != "equiangular")
          throw std::invalid_argument("\"" + text + "\" is not parabola or equiangular");
        c.fit = text == "parabola" ? SubPixelFit::parabola : SubPixelFit::equiangular;
      }};
  return {
      {"census_width_px", &c.census_width_px, "census window, odd", 3, 9},
      {"census_height_px", &c.census_height_px, "census window, odd", 3, 9},
      {"margin", &c.margin, "differences of codes below are none", 0, 65535},
      {"block_px", &c.block_px, "block that costs are summed over, odd", 1, 15},
      {"shift_px", &c.shift_px, "disparity shift", 0, 1024},
      {"range_px", &c.range_px, "disparities above the shift", 1, 254},
      {"paths", &c.paths, "4 or 8", 4, 8},
      {"p1", &c.p1, "penalty of a step of one, over the largest cost", 0, 4},
      {"p2", &c.p2, "penalty of a larger step", 0, 4},
      {"worst_cost", &c.worst_cost, "over the cost of windows with nothing in common", 0.01, 1},
      {"uniqueness", &c.uniqueness, "least share by which other candidates cost more", 0, 0.99},
      {"left_right_px", &c.left_right_px, "left-right check; below 0: none", -1, 255},
      {"texture", &c.texture, "least share of a block's pairs that differ by the margin", 0, 1},
      {"fit", fit, "sub-pixel step: parabola or equiangular"},
  };
}

/// What of a colour camera the keys above do not say.
Fields color_fields(CameraSensorConfig& color) {
  constexpr std::array<std::string_view, 9> kLens = {
      "lens.vignetting_a", "lens.vignetting_b", "lens.vignetting_c",
      "lens.red_scale",    "lens.red_cubic",    "lens.blue_scale",
      "lens.blue_cubic",   "lens.focal_m",      "lens.blur_sigma_px"};
  Fields rows;
  for (Field& row : fields(color)) {
    const bool is_lens = std::find(kLens.begin(), kLens.end(), row.key) != kLens.end();
    if (is_lens || row.key.starts_with("photosites.") || row.key.starts_with("develop."))
      rows.push_back(std::move(row));
  }
  return rows;
}

std::size_t mode_index(const ActiveStereoConfig& config) {
  const auto& columns = config.mode_columns;
  const auto it = std::find(columns.begin(), columns.end(), config.columns);
  if (it == columns.end()) {
    std::string known;
    for (const double c : columns)
      known += (known.empty() ? "" : ", ") + std::to_string(static_cast<int>(c));
    reject_stereo("columns = " + std::to_string(config.columns) + " is not a mode; there are " +
                  known);
  }
  return static_cast<std::size_t>(it - columns.begin());
}

Camera pinhole(int width_px, int height_px, double focal_px) {
  Camera camera;
  camera.width_px = width_px;
  camera.height_px = height_px;
  camera.fx_px = camera.fy_px = focal_px;
  camera.cx_px = 0.5 * (width_px - 1);
  camera.cy_px = 0.5 * (height_px - 1);
  return camera;
}

/// Pose of a sensor that sits at `x_m` on the rig's x axis.
Pose on_axis(double x_m, const Eigen::Quaterniond& rotation = Eigen::Quaterniond::Identity()) {
  Pose sensor_from_rig;
  sensor_from_rig.rotation = rotation;
  sensor_from_rig.translation_m = rotation * Eigen::Vector3d(-x_m, 0, 0);
  return sensor_from_rig;
}

TrueView view_of(const Camera& camera, const Pose& camera_from_world) {
  TrueView view;
  view.camera = camera;
  view.camera_from_world = view.camera_from_world_end = camera_from_world;
  return view;
}

}  // namespace

Fields fields(ActiveStereoConfig& c) {
  return Fields{
             {"mode_columns", &c.mode_columns, "columns of each depth mode", 32, 4096},
             {"mode_rows", &c.mode_rows, "rows of each", 32, 4096},
             {"mode_focal_px", &c.mode_focal_px, "focal length of each", 10, 1e5},
             {"columns", &c.columns, "columns of the mode in use", 32, 4096},
             {"baseline_m", &c.baseline_m, "between the imagers", 1e-4, 10},
             {"depth_unit_m", &c.depth_unit_m, "of the 16-bit depth", 1e-6, 1},
             {"largest_depth_m", &c.largest_depth_m, "beyond, no depth is given", 1e-3, 1e4},
             {"disparity_step_px", &c.disparity_step_px, "disparities are multiples of this", 0, 1},
             {"has_projector", &c.has_projector, "whether it has a dot projector"},
             {"projector_x_m", &c.projector_x_m, "from the left towards the right imager", -10, 10},
             {"infrared_without_dots", &c.infrared_without_dots,
              "infrared images are taken with the projector off, depth with it on"},
             {"color_columns", &c.color_columns, "colour image", 32, 8192},
             {"color_rows", &c.color_rows, "colour image", 32, 8192},
             {"color_focal_px", &c.color_focal_px, "colour camera", 10, 1e5},
             {"color_distortion", &c.color_distortion, "k1 k2 p1 p2 k3", -100, 100},
             {"color_x_m", &c.color_x_m, "from the left imager towards the right", -10, 10},
             {"focal_error", &c.focal_error, "relative sigma between units", 0, 0.1},
             {"baseline_error", &c.baseline_error, "relative sigma between units", 0, 0.1},
             {"yaw_error_rad", &c.yaw_error_rad, "sigma of the right imager's yaw", 0, 0.1},
             {"color_focal_error", &c.color_focal_error, "relative sigma between units", 0, 0.1},
             {"color_rotation_error_rad", &c.color_rotation_error_rad,
              "sigma of the colour camera's rotation about each axis", 0, 0.1},
             {"sync_error_s", &c.sync_error_s, "sigma of the colour image's start", 0, 1},
             {"hand_speed_m_per_s", &c.hand_speed_m_per_s,
              "sigma of the body's velocity, each axis", 0, 10},
             {"hand_rate_rad_per_s", &c.hand_rate_rad_per_s,
              "sigma of the body's turning rate, each axis", 0, 10},
         } +
         nested("color", color_fields(c.color)) + nested("projector", fields(c.projector)) +
         nested("infrared", fields(c.infrared)) + nested("imager", fields(c.imager)) +
         nested("match", match_fields(c.match)) + nested("model", fields(c.model));
}

void validate(const ActiveStereoConfig& config) {
  ActiveStereoConfig copy = config;
  check_limits(fields(copy), "active stereo");
  if (config.mode_rows.size() != config.mode_columns.size() ||
      config.mode_focal_px.size() != config.mode_columns.size()) {
    reject_stereo("mode_columns, mode_rows and mode_focal_px have " +
                  std::to_string(config.mode_columns.size()) + ", " +
                  std::to_string(config.mode_rows.size()) + " and " +
                  std::to_string(config.mode_focal_px.size()) + " numbers; they must be as many");
  }
  validate(config.match);
  validate(config.model);
  validate(config.infrared);
  validate(depth_camera(config));
  validate(color_sensor(config), "colour camera");
}

Camera depth_camera(const ActiveStereoConfig& config) {
  const std::size_t mode = mode_index(config);
  return pinhole(config.columns, static_cast<int>(config.mode_rows[mode]),
                 config.mode_focal_px[mode]);
}

Camera color_camera(const ActiveStereoConfig& config) {
  Camera camera = pinhole(config.color_columns, config.color_rows, config.color_focal_px);
  if (config.color_distortion.size() > 5)
    reject_stereo("color_distortion has " + std::to_string(config.color_distortion.size()) +
                  " coefficients; opencv5 takes 5");
  if (!config.color_distortion.empty()) {
    camera.model = LensModel::opencv5;
    std::copy(config.color_distortion.begin(), config.color_distortion.end(),
              camera.distortion.begin());
  }
  return camera;
}

CameraSensorConfig color_sensor(const ActiveStereoConfig& config) {
  const Camera camera = color_camera(config);
  CameraSensorConfig color = config.color;
  color.width_px = config.color_columns;
  color.height_px = config.color_rows;
  color.lens.model = camera.model;
  color.lens.focal_px_per_width = config.color_focal_px / config.color_columns;
  color.lens.distortion = config.color_distortion;
  return color;
}

double least_depth_m(const ActiveStereoConfig& config) {
  return depth_camera(config).fx_px * config.baseline_m /
         (config.match.shift_px + config.match.range_px);
}

ActiveStereoUnit make_active_stereo(const ActiveStereoConfig& config, Rng rng) {
  validate(config);
  ActiveStereoUnit unit;
  Rng errors = rng.fork("errors");
  unit.reported = unit.imager = depth_camera(config);
  const double focal = 1 + truncated_normal(errors, 0, config.focal_error);
  unit.imager.fx_px *= focal;
  unit.imager.fy_px *= focal;
  unit.baseline_m = config.baseline_m * (1 + truncated_normal(errors, 0, config.baseline_error));
  const double yaw_rad = truncated_normal(errors, 0, config.yaw_error_rad);
  unit.right_from_rig = on_axis(
      unit.baseline_m, Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitY())));

  unit.color_reported = unit.color = color_camera(config);
  const double color_focal = 1 + truncated_normal(errors, 0, config.color_focal_error);
  unit.color.fx_px *= color_focal;
  unit.color.fy_px *= color_focal;
  unit.color_from_rig_reported = on_axis(config.color_x_m);
  Eigen::Vector3d turn_rad;
  for (double& a : turn_rad) a = truncated_normal(errors, 0, config.color_rotation_error_rad);
  const double angle = turn_rad.norm();
  unit.color_from_rig = on_axis(
      config.color_x_m, angle > 0 ? Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn_rad / angle))
                                  : Eigen::Quaterniond::Identity());
  if (config.has_projector) {
    unit.projector = make_dot_projector(config.projector, inverse(on_axis(config.projector_x_m)),
                                        rng.fork("dots"));
  }
  const Camera& c = unit.imager;
  unit.response_left =
      response_map(c.width_px, c.height_px, config.imager.prnu, rng.fork("response left"));
  unit.response_right =
      response_map(c.width_px, c.height_px, config.imager.prnu, rng.fork("response right"));
  return unit;
}

TrueView left_view(const ActiveStereoUnit& unit, const Pose& rig_from_world) {
  return view_of(unit.imager, rig_from_world);
}

TrueView right_view(const ActiveStereoUnit& unit, const Pose& rig_from_world) {
  return view_of(unit.imager, unit.right_from_rig * rig_from_world);
}

std::vector<std::string> active_stereo_preset_names() {
  return preset_names(active_stereo_preset_texts());
}

ActiveStereoConfig active_stereo_preset(const std::string& name) {
  return read_preset<ActiveStereoConfig>(name, active_stereo_preset_texts());
}

}  // namespace cousin
