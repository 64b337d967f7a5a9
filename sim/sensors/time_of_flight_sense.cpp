#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "sim/render/infrared_pass.h"
#include "sim/render/truth_pass.h"
#include "sim/sensors/fast_normal.h"
#include "sim/sensors/infrared_albedo.h"
#include "sim/sensors/time_of_flight.h"
#include "sim/truth/scene.h"
#include "sim/types/no_value.h"
#include "sim/types/pi.h"

namespace cousin {
namespace {

constexpr double kFlight_m_per_s = 299792458;

/// Phase per metre of the way there and back, for each frequency.
std::vector<float> wave_numbers(const TimeOfFlightConfig& config) {
  std::vector<float> result;
  for (const double hz : config.modulation_hz)
    result.push_back(static_cast<float>(2 * std::numbers::pi * hz / kFlight_m_per_s));
  return result;
}

/// The camera of the rays.
Camera ray_camera(const TimeOfFlightConfig& config) {
  Camera camera = depth_camera(config);
  camera.width_px *= config.side;
  camera.height_px *= config.side;
  camera.fx_px *= config.side;
  camera.fy_px *= config.side;
  camera.cx_px = 0.5 * (camera.width_px - 1);
  camera.cy_px = 0.5 * (camera.height_px - 1);
  return camera;
}

Eigen::Vector3f ray_at(const Camera& camera, int x, int y) {
  return {
      (static_cast<float>(x) - static_cast<float>(camera.cx_px)) / static_cast<float>(camera.fx_px),
      (static_cast<float>(y) - static_cast<float>(camera.cy_px)) / static_cast<float>(camera.fy_px),
      1};
}

/// Where a ray met a surface and what of the lamp's light it would throw back.
struct LitPoint {
  Eigen::Vector3f position_m, normal;
  float range_m = 0;
  float irradiance = 0;  ///< 1 = a surface that faces the lamp, 1 m away
  float albedo = 0;
};
LitPoint lit_point(const TimeOfFlightInputs& in, const Camera& camera, int x, int y) {
  LitPoint p;
  const float z = in.depth_m(x, y);
  if (!(z > 0)) return p;
  p.position_m = z * ray_at(camera, x, y);
  p.range_m = p.position_m.norm();
  p.normal = in.normal(x, y);
  p.albedo = in.albedo(x, y);
  p.irradiance = std::max(0.0F, -p.normal.dot(p.position_m) / p.range_m) / (p.range_m * p.range_m);
  return p;
}

/// A piece of the image's surfaces that lights the others.
struct Patch {
  LitPoint point;
  float area_m2 = 0;
};
std::vector<Patch> make_patches(const TimeOfFlightInputs& in, const Camera& camera, int columns) {
  std::vector<Patch> patches;
  if (columns <= 0) return patches;
  const int rows = std::max(1, columns * camera.height_px / camera.width_px);
  const auto pixels = static_cast<float>(camera.width_px) / static_cast<float>(columns) *
                      static_cast<float>(camera.height_px) / static_cast<float>(rows);
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const LitPoint p = lit_point(in, camera, (2 * i + 1) * camera.width_px / (2 * columns),
                                   (2 * j + 1) * camera.height_px / (2 * rows));
      const float cosine = p.range_m > 0 ? -p.normal.dot(p.position_m) / p.range_m : 0;
      if (!(p.irradiance * p.albedo > 0) || cosine < 0.02F) continue;
      // A pixel's solid angle is the cube of the ray's cosine to the axis over f^2.
      const float axis = p.position_m.z() / p.range_m;
      const auto focal_px = static_cast<float>(camera.fx_px);
      const float solid_angle = pixels * axis * axis * axis / (focal_px * focal_px);
      patches.push_back({p, p.range_m * p.range_m * solid_angle / cosine});
    }
  }
  return patches;
}

/// Light of one pixel, of every frequency.
class PixelLight {
 public:
  PixelLight(const std::vector<float>& waves, const std::vector<Patch>& patches)
      : waves_(waves), patches_(patches), sums_(waves.size()) {}

  void clear() {
    mean_ = 0;
    std::fill(sums_.begin(), sums_.end(), Eigen::Vector2f::Zero());
  }
  void add_direct(const LitPoint& p, float share) {
    add(p.albedo * p.irradiance * share, 2 * p.range_m);
  }
  /// By way of each patch: its radiosity times the form factor of a disk of its area.
  void add_bounced(const LitPoint& p) {
    for (const Patch& patch : patches_) {
      const Eigen::Vector3f way = patch.point.position_m - p.position_m;
      const float here = p.normal.dot(way), there = -patch.point.normal.dot(way);
      if (!(here > 0 && there > 0)) continue;
      const float squared = way.squaredNorm();
      const float factor =
          here * there * patch.area_m2 / (squared * (kPiF * squared + patch.area_m2));
      add(p.albedo * patch.point.albedo * patch.point.irradiance * factor,
          patch.point.range_m + std::sqrt(squared) + p.range_m);
    }
  }
  float mean() const { return mean_; }
  const Eigen::Vector2f& sum(std::size_t i) const { return sums_[i]; }

 private:
  void add(float light, float way_m) {
    mean_ += light;
    for (std::size_t i = 0; i < waves_.size(); ++i) {
      const float phase = waves_[i] * way_m;
      sums_[i] += light * Eigen::Vector2f(std::cos(phase), std::sin(phase));
    }
  }
  const std::vector<float>& waves_;
  const std::vector<Patch>& patches_;
  std::vector<Eigen::Vector2f> sums_;
  float mean_ = 0;
};

void check_sizes(const TimeOfFlightInputs& in, const TimeOfFlightConfig& config) {
  const Camera rays = ray_camera(config);
  const auto fits = [](const auto& image, int width, int height) {
    return image.width() == width && image.height() == height;
  };
  if (!fits(in.depth_m, rays.width_px, rays.height_px) ||
      !fits(in.normal, rays.width_px, rays.height_px) ||
      !fits(in.albedo, rays.width_px, rays.height_px) ||
      !fits(in.ambient, config.columns, config.rows) ||
      !fits(in.centre_depth_m, config.columns, config.rows)) {
    throw std::invalid_argument(
        "time of flight: an input is not of " + std::to_string(config.columns) + " x " +
        std::to_string(config.rows) + " pixels of " + std::to_string(config.side) + " x " +
        std::to_string(config.side) + " rays");
  }
}

/// What the four samples of each frequency tell.
struct Phases {
  std::array<float, 4> phase_rad{};  ///< in [0, 2 pi)
  std::array<float, 4> amplitude_e{};
  bool is_saturated = false;
};

/// The range on which the frequencies agree best, and how well.
struct Unwrapped {
  double range_m = 0, disagreement_m = 0;
};

class Decoder {
 public:
  explicit Decoder(const TimeOfFlightConfig& config)
      : most_m_(std::min(unambiguous_range_m(config), 2 * config.largest_depth_m + 1)) {
    for (const double hz : config.modulation_hz) periods_m_.push_back(0.5 * kFlight_m_per_s / hz);
  }

  /// Each multiple of the highest frequency's period is tried; ranges are averaged by the inverse
  /// of their variances, which go as (period / amplitude)^2.
  Unwrapped operator()(const Phases& p) const {
    const std::size_t last = periods_m_.size() - 1;
    Unwrapped best;
    double least = std::numeric_limits<double>::infinity();
    const double first = share(p, last) * periods_m_[last];
    for (double guess = first; guess < most_m_; guess += periods_m_[last]) {
      double sum = 0, squares = 0, weights = 0;
      for (std::size_t i = 0; i <= last; ++i) {
        const double own = share(p, i) * periods_m_[i];
        const double at = own + std::round((guess - own) / periods_m_[i]) * periods_m_[i];
        const double weight = std::pow(static_cast<double>(p.amplitude_e[i]) / periods_m_[i], 2);
        sum += weight * (at - guess);
        squares += weight * (at - guess) * (at - guess);
        weights += weight;
      }
      if (!(weights > 0)) return best;
      const double mean = sum / weights;
      const double spread = squares / weights - mean * mean;
      if (spread < least) {
        least = spread;
        best = {guess + mean, std::sqrt(std::max(0.0, spread))};
      }
    }
    return best;
  }

 private:
  static double share(const Phases& p, std::size_t i) {
    return static_cast<double>(p.phase_rad[i]) / (2 * std::numbers::pi);
  }
  std::vector<double> periods_m_;
  double most_m_;
};

/// Draws the samples of one pixel.
Phases sample_phases(const TimeOfFlightLight& light, const TimeOfFlightConfig& config, int x, int y,
                     Rng& row) {
  const NormalTable& table = normal_table();
  const auto read2 = static_cast<float>(config.read_noise_e * config.read_noise_e);
  const auto full_well = static_cast<float>(config.full_well_e);
  const auto wiggle = static_cast<float>(config.wiggle);
  Phases result;
  for (std::size_t i = 0; i < light.modulation.size(); ++i) {
    const Eigen::Vector2f& m = light.modulation[i](x, y);
    const float amplitude = m.norm(), phase = std::atan2(m.y(), m.x());
    std::array<float, 4> samples{};
    for (std::size_t k = 0; k < 4; ++k) {
      const float at = phase - 0.5F * kPiF * static_cast<float>(k);
      const float mean =
          light.mean_e(x, y) + amplitude * (std::cos(at) + wiggle * std::cos(3 * at));
      const float noise = std::sqrt(std::max(0.0F, mean) + read2);
      samples[k] = mean + noise * table(static_cast<std::uint32_t>(row() >> 32));
      result.is_saturated = result.is_saturated || samples[k] >= full_well;
    }
    const float in_phase = 0.5F * (samples[0] - samples[2]);
    const float quadrature = 0.5F * (samples[1] - samples[3]);
    const float found = std::atan2(quadrature, in_phase);
    result.phase_rad[i] = found < 0 ? found + 2 * kPiF : found;
    result.amplitude_e[i] = std::hypot(in_phase, quadrature);
  }
  return result;
}

InvalidReason reason_of(const Phases& p, const Unwrapped& found, double depth_m, float true_m,
                        std::size_t frequencies, const TimeOfFlightConfig& config) {
  if (!(true_m > 0)) return InvalidReason::out_of_range;
  if (p.is_saturated) return InvalidReason::saturated;
  for (std::size_t i = 0; i < frequencies; ++i) {
    if (static_cast<double>(p.amplitude_e[i]) < config.least_amplitude_e)
      return InvalidReason::low_signal;
  }
  if (found.disagreement_m > config.disagreement_m) return InvalidReason::mixed_pixel;
  if (depth_m < config.least_depth_m || depth_m > config.largest_depth_m)
    return InvalidReason::out_of_range;
  return InvalidReason::none;
}

}  // namespace

TimeOfFlightInputs time_of_flight_inputs(const RayScene& rays, const Scene& scene,
                                         const Pose& camera_from_world,
                                         const TimeOfFlightConfig& config, Rng rng) {
  validate(config);
  TrueView view;
  view.camera = depth_camera(config);
  view.camera_from_world = view.camera_from_world_end = camera_from_world;
  TimeOfFlightInputs inputs;
  InfraredConfig infrared;
  infrared.pixel_samples = 1;
  inputs.ambient = render_infrared(rays, scene, view, {}, infrared, rng.fork("ambient")).radiance;
  inputs.centre_depth_m = render_truth(rays, scene, view, {.depth = true}).depth_m;
  view.camera = ray_camera(config);
  TruthImages truth = render_truth(rays, scene, view,
                                   {.depth = true, .normal = true, .instance = true, .part = true});
  inputs.albedo = infrared_albedo(scene, truth.instance, truth.part);
  inputs.depth_m = std::move(truth.depth_m);
  inputs.normal = std::move(truth.normal);
  return inputs;
}

TimeOfFlightLight time_of_flight_light(const TimeOfFlightInputs& inputs,
                                       const TimeOfFlightConfig& config) {
  validate(config);
  check_sizes(inputs, config);
  const Camera camera = ray_camera(config);
  const std::vector<float> waves = wave_numbers(config);
  const std::vector<Patch> patches = make_patches(inputs, camera, config.multipath_columns);
  const int side = config.side;
  const auto scale = static_cast<float>(config.signal_e_at_1m);
  const auto contrast = static_cast<float>(config.contrast);
  TimeOfFlightLight light;
  light.mean_e = Image<float>(config.columns, config.rows);
  light.modulation.assign(waves.size(), Image<Eigen::Vector2f>(config.columns, config.rows));
  tbb::parallel_for(tbb::blocked_range<int>(0, config.rows, 8), [&](const auto& range) {
    PixelLight pixel(waves, patches);
    for (int y = range.begin(); y < range.end(); ++y) {
      for (int x = 0; x < config.columns; ++x) {
        pixel.clear();
        for (int k = 0; k < side * side; ++k) {
          const LitPoint p = lit_point(inputs, camera, x * side + k % side, y * side + k / side);
          if (!(p.range_m > 0)) continue;
          pixel.add_direct(p, 1.0F / static_cast<float>(side * side));
          if (k == side * side / 2) pixel.add_bounced(p);
        }
        light.mean_e(x, y) =
            scale * pixel.mean() + static_cast<float>(config.ambient_e) * inputs.ambient(x, y);
        for (std::size_t i = 0; i < waves.size(); ++i)
          light.modulation[i](x, y) = scale * contrast * pixel.sum(i);
      }
    }
  });
  return light;
}

TimeOfFlightDepth sense_time_of_flight(const TimeOfFlightInputs& inputs,
                                       const TimeOfFlightLight& light,
                                       const TimeOfFlightConfig& config, const Rng& rng) {
  validate(config);
  check_sizes(inputs, config);
  const Camera camera = depth_camera(config);
  const int width = config.columns, height = config.rows;
  const Decoder decode(config);
  TimeOfFlightDepth out{Image<std::uint16_t>(width, height, std::uint16_t{0}),
                        Image<float>(width, height, kNone), Image<float>(width, height),
                        inputs.centre_depth_m, Image<InvalidReason>(width, height)};
  tbb::parallel_for(tbb::blocked_range<int>(0, height, 8), [&](const auto& range) {
    for (int y = range.begin(); y < range.end(); ++y) {
      Rng row = rng.fork(static_cast<std::uint64_t>(y));
      for (int x = 0; x < width; ++x) {
        const Phases phases = sample_phases(light, config, x, y, row);
        const Unwrapped found = decode(phases);
        const double depth_m = found.range_m / static_cast<double>(ray_at(camera, x, y).norm());
        out.amplitude_e(x, y) = phases.amplitude_e[light.modulation.size() - 1];
        out.reason(x, y) = reason_of(phases, found, depth_m, inputs.centre_depth_m(x, y),
                                     light.modulation.size(), config);
        const double code = std::round(depth_m / config.depth_unit_m);
        if (out.reason(x, y) != InvalidReason::none) continue;
        if (!(code >= 1 && code <= 65535)) {
          out.reason(x, y) = InvalidReason::out_of_range;
          continue;
        }
        out.range_m(x, y) = static_cast<float>(found.range_m);
        out.depth(x, y) = static_cast<std::uint16_t>(code);
      }
    }
  });
  return out;
}

}  // namespace cousin
