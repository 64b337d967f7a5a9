#include "sim/sensors/structured_light.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sim/config/limits.h"
#include "sim/render/truth_pass.h"
#include "sim/sensors/fast_normal.h"
#include "sim/sensors/row_occlusion.h"

namespace cousin {
namespace {

constexpr double kHalfPi = 0.5 * std::numbers::pi;

/// Senses the pixels of one image.
class PixelSensor {
 public:
  PixelSensor(const StructuredLightInputs& inputs, const StructuredLightConfig& config)
      : in_(inputs),
        config_(config),
        camera_(depth_camera(config)),
        hidden_(hidden_along_rows(inputs.depth_m, config.focal_px, config.baseline_m)) {}

  InvalidReason operator()(int x, int y, Rng& row, std::uint16_t& depth) const {
    // Each pixel takes its numbers, whatever becomes of it.
    const std::uint64_t first = row(), second = row();
    const auto normal = [](std::uint64_t bits) {
      return static_cast<double>(normal_table()(static_cast<std::uint32_t>(bits)));
    };
    const double across = normal(first), down = normal(first >> 32), along = normal(second);
    if (!(in_.depth_m(x, y) > 0)) return InvalidReason::out_of_range;
    const int half = config_.window_px / 2;
    if (x < half || y < half || x >= config_.columns - half || y >= config_.rows - half)
      return InvalidReason::band;
    const double lateral_px = lateral_sigma_px(config_, std::min(incidence_rad(x, y), 1.55));
    const auto [i, j] = beyond_edge(x, y, lateral_px * across, lateral_px * down);
    const auto z = static_cast<double>(in_.depth_m(i, j));
    if (hidden_(i, j)) return InvalidReason::no_projector;
    const double theta = incidence_rad(i, j);
    if (theta > config_.steepest_rad) return InvalidReason::low_signal;
    return measure(z, theta, along, depth);
  }

 private:
  struct Place {
    int x, y;
  };

  double incidence_rad(int x, int y) const {
    const Eigen::Vector3d ray((x - camera_.cx_px) / camera_.fx_px,
                              (y - camera_.cy_px) / camera_.fy_px, 1);
    const double cosine = -ray.normalized().dot(in_.normal(x, y).cast<double>());
    return std::acos(std::clamp(cosine, -1.0, 1.0));
  }

  /// The pixel itself, or the one that its noise reaches if that shows another surface: on one
  /// surface the axial noise has all of it.
  Place beyond_edge(int x, int y, double across_px, double down_px) const {
    constexpr double kJump_px = 1;  // of disparity
    const int i = std::clamp(x + static_cast<int>(std::lround(across_px)), 0, config_.columns - 1);
    const int j = std::clamp(y + static_cast<int>(std::lround(down_px)), 0, config_.rows - 1);
    const auto other = static_cast<double>(in_.depth_m(i, j));
    if (!(other > 0)) return {x, y};
    const double scale = config_.focal_px * config_.baseline_m;
    // The disparity of the own surface's plane there.
    const Eigen::Vector3d n = in_.normal(x, y).cast<double>();
    const auto along = [&](int u, int v) {
      return n.dot(Eigen::Vector3d((u - camera_.cx_px) / camera_.fx_px,
                                   (v - camera_.cy_px) / camera_.fy_px, 1));
    };
    const double here = along(x, y);
    const double own = here != 0
                           ? scale / static_cast<double>(in_.depth_m(x, y)) * along(i, j) / here
                           : scale / static_cast<double>(in_.depth_m(x, y));
    return std::abs(scale / other - own) > kJump_px ? Place{i, j} : Place{x, y};
  }

  InvalidReason measure(double z, double theta, double normal, std::uint16_t& depth) const {
    const double scale = config_.focal_px * config_.baseline_m / config_.disparity_step_px;
    double steps = config_.disparity_noise_steps;
    if (config_.axial == AxialNoise::nguyen) {
      const double sigma = axial_sigma_m(config_, z, theta) * scale / (z * z);
      steps = std::sqrt(std::max(0.0, sigma * sigma - 1 / 12.0));
    }
    const double code = std::round(scale / z + steps * normal);
    if (!(code >= 1)) return InvalidReason::out_of_range;
    const double found_m = scale / code;
    if (found_m < config_.least_depth_m || found_m > config_.largest_depth_m)
      return InvalidReason::out_of_range;
    depth = static_cast<std::uint16_t>(
        std::clamp(std::round(found_m / config_.depth_unit_m), 1.0, 65535.0));
    return InvalidReason::none;
  }

  const StructuredLightInputs& in_;
  const StructuredLightConfig& config_;
  Camera camera_;
  Image<std::uint8_t> hidden_;
};

}  // namespace

Fields fields(StructuredLightConfig& c) {
  const TextField axial{
      [&c] { return std::string(c.axial == AxialNoise::nguyen ? "nguyen" : "barron_malik"); },
      [&c](const std::string& text) {
        if (text != "nguyen" && text != "barron_malik")
          throw std::invalid_argument("\"" + text + "\" is not nguyen or barron_malik");
        c.axial = text == "nguyen" ? AxialNoise::nguyen : AxialNoise::barron_malik;
      }};
  return {
      {"columns", &c.columns, "columns of the image", 16, 4096},
      {"rows", &c.rows, "rows of the image", 16, 4096},
      {"focal_px", &c.focal_px, "focal length", 10, 1e5},
      {"baseline_m", &c.baseline_m, "from the imager to the projector", 1e-4, 10},
      {"depth_unit_m", &c.depth_unit_m, "of the 16-bit depth", 1e-6, 1},
      {"least_depth_m", &c.least_depth_m, "nearer, no depth is given", 0, 1e3},
      {"largest_depth_m", &c.largest_depth_m, "farther, no depth is given", 1e-3, 1e4},
      {"disparity_step_px", &c.disparity_step_px, "of the disparity's codes", 1e-4, 1},
      {"disparity_noise_steps", &c.disparity_noise_steps, "sigma of a code", 0, 100},
      {"axial", axial, "axial noise: nguyen or barron_malik"},
      {"axial_floor_m", &c.axial_floor_m, "sigma at the best depth", 0, 1},
      {"axial_growth_per_m", &c.axial_growth_per_m, "its growth with (z - best)^2", 0, 10},
      {"axial_best_m", &c.axial_best_m, "the best depth", 0, 100},
      {"axial_tilt", &c.axial_tilt, "its growth with incidence", 0, 1},
      {"lateral_px", &c.lateral_px, "sigma of an edge's place", 0, 32},
      {"lateral_tilt_px", &c.lateral_tilt_px, "its growth with incidence", 0, 32},
      {"steepest_rad", &c.steepest_rad, "incidence beyond which nothing is found", 0.1, 1.57},
      {"window_px", &c.window_px, "of the correlation, odd", 1, 65},
  };
}

void validate(const StructuredLightConfig& config) {
  StructuredLightConfig copy = config;
  check_limits(fields(copy), "structured light");
  if (!(config.least_depth_m < config.largest_depth_m)) {
    throw std::invalid_argument(
        "structured light: least_depth_m = " + std::to_string(config.least_depth_m) +
        " is not below largest_depth_m = " + std::to_string(config.largest_depth_m));
  }
}

Camera depth_camera(const StructuredLightConfig& config) {
  Camera camera;
  camera.width_px = config.columns;
  camera.height_px = config.rows;
  camera.fx_px = camera.fy_px = config.focal_px;
  camera.cx_px = 0.5 * (config.columns - 1);
  camera.cy_px = 0.5 * (config.rows - 1);
  return camera;
}

double axial_sigma_m(const StructuredLightConfig& config, double depth_m, double incidence_rad) {
  const double t = incidence_rad / (kHalfPi - incidence_rad);
  const double away_m = depth_m - config.axial_best_m;
  return config.axial_floor_m + config.axial_growth_per_m * away_m * away_m +
         config.axial_tilt * t * t / std::sqrt(depth_m);
}

double lateral_sigma_px(const StructuredLightConfig& config, double incidence_rad) {
  return config.lateral_px + config.lateral_tilt_px * incidence_rad / (kHalfPi - incidence_rad);
}

double code_sigma_m(const StructuredLightConfig& config, double depth_m) {
  const double step_m =
      depth_m * depth_m * config.disparity_step_px / (config.focal_px * config.baseline_m);
  return step_m * std::sqrt(config.disparity_noise_steps * config.disparity_noise_steps + 1 / 12.0);
}

StructuredLightInputs structured_light_inputs(const RayScene& rays, const Scene& scene,
                                              const Pose& camera_from_world,
                                              const StructuredLightConfig& config) {
  validate(config);
  TrueView view;
  view.camera = depth_camera(config);
  view.camera_from_world = view.camera_from_world_end = camera_from_world;
  TruthImages truth = render_truth(rays, scene, view, {.depth = true, .normal = true});
  return {std::move(truth.depth_m), std::move(truth.normal)};
}

StructuredLightDepth sense_structured_light(const StructuredLightInputs& inputs,
                                            const StructuredLightConfig& config, const Rng& rng) {
  validate(config);
  const int width = config.columns, height = config.rows;
  if (inputs.depth_m.width() != width || inputs.depth_m.height() != height ||
      inputs.normal.width() != width || inputs.normal.height() != height) {
    throw std::invalid_argument("structured light: an input is not of " + std::to_string(width) +
                                " x " + std::to_string(height) + " pixels");
  }
  const PixelSensor sense(inputs, config);
  StructuredLightDepth out{Image<std::uint16_t>(width, height, std::uint16_t{0}), inputs.depth_m,
                           Image<InvalidReason>(width, height)};
  tbb::parallel_for(tbb::blocked_range<int>(0, height, 8), [&](const auto& range) {
    for (int y = range.begin(); y < range.end(); ++y) {
      Rng row = rng.fork(static_cast<std::uint64_t>(y));
      for (int x = 0; x < width; ++x) out.reason(x, y) = sense(x, y, row, out.depth(x, y));
    }
  });
  return out;
}

}  // namespace cousin
