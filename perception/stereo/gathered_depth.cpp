#include "perception/stereo/gathered_depth.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string_view>

namespace cousin {
namespace {

constexpr float kNoDepth = std::numeric_limits<float>::quiet_NaN();

/// Rays at depth 1 of a lens, bilinear between every eighth pixel: within 1e-5 of a pixel for
/// lenses of some percent distortion.
class RayGrid {
 public:
  explicit RayGrid(const Camera& camera) {
    const Lens lens(camera);
    rays_ = Image<Eigen::Vector2f>(camera.width_px / kStep + 2, camera.height_px / kStep + 2);
    for (int y = 0; y < rays_.height(); ++y) {
      for (int x = 0; x < rays_.width(); ++x) {
        const auto ray = lens.unproject(Eigen::Vector2d(x * kStep, y * kStep));
        rays_(x, y) = ray && ray->z() > 0 ? Eigen::Vector2f(ray->hnormalized().cast<float>())
                                          : Eigen::Vector2f::Constant(kNoDepth);
      }
    }
  }
  Eigen::Vector3d at(double x, double y) const {
    const int ix = std::clamp(static_cast<int>(x / kStep), 0, rays_.width() - 2);
    const int iy = std::clamp(static_cast<int>(y / kStep), 0, rays_.height() - 2);
    const auto a = static_cast<float>(x / kStep - ix), b = static_cast<float>(y / kStep - iy);
    const Eigen::Vector2f ray = (1 - b) * ((1 - a) * rays_(ix, iy) + a * rays_(ix + 1, iy)) +
                                b * ((1 - a) * rays_(ix, iy + 1) + a * rays_(ix + 1, iy + 1));
    return {static_cast<double>(ray.x()), static_cast<double>(ray.y()), 1};
  }

 private:
  static constexpr int kStep = 8;
  Image<Eigen::Vector2f> rays_;
};

/// One frame's sensors.
struct DepthPair {
  const SensorFrame& depth;
  const Camera& first;
  Pose first_from_depth;
};

/// Where each pixel of the first sensor may find its depth: the nearest of what lands there.
Image<float> first_guess_m(const DepthPair& pair, const RayGrid& rays) {
  Image<float> guess_m(pair.first.width_px, pair.first.height_px, kNoDepth);
  const Lens lens(pair.first);
  const Eigen::Matrix3d turn = pair.first_from_depth.rotation.toRotationMatrix();
  // Every second pixel is drawn, as wide as two of them are in the first sensor.
  const int reach =
      std::max(1, static_cast<int>(std::ceil(pair.first.fx_px / pair.depth.reported.fx_px)));
  for (int y = 0; y < pair.depth.depth.height(); y += 2) {
    for (int x = 0; x < pair.depth.depth.width(); x += 2) {
      if (pair.depth.depth(x, y) == 0) continue;
      const double z_m = pair.depth.depth(x, y) * pair.depth.depth_unit_m;
      const Eigen::Vector3d at_m =
          turn * (z_m * rays.at(x, y)) + pair.first_from_depth.translation_m;
      const auto pixel = lens.project(at_m);
      if (!pixel) continue;
      const auto px = static_cast<int>(std::lround(pixel->x())),
                 py = static_cast<int>(std::lround(pixel->y()));
      for (int j = py - reach; j <= py + reach; ++j) {
        for (int i = px - reach; i <= px + reach; ++i) {
          if (!guess_m.contains(i, j)) continue;
          float& own = guess_m(i, j);
          if (std::isnan(own) || at_m.z() < static_cast<double>(own))
            own = static_cast<float>(at_m.z());
        }
      }
    }
  }
  return guess_m;
}

/// Depth between pixels; nothing where some of four neighbours have none or stand on both sides of
/// a step.
std::optional<double> between_pixels(const SensorFrame& sensor, double x, double y) {
  constexpr double kStepOfDepth = 0.03;
  const auto ix = static_cast<int>(std::floor(x)), iy = static_cast<int>(std::floor(y));
  if (ix < 0 || iy < 0 || ix + 1 >= sensor.depth.width() || iy + 1 >= sensor.depth.height())
    return std::nullopt;
  const double a = x - ix, b = y - iy;
  const double z[4] = {static_cast<double>(sensor.depth(ix, iy)),
                       static_cast<double>(sensor.depth(ix + 1, iy)),
                       static_cast<double>(sensor.depth(ix, iy + 1)),
                       static_cast<double>(sensor.depth(ix + 1, iy + 1))};
  const auto [low, high] = std::minmax_element(std::begin(z), std::end(z));
  if (!(*low > 0) || *high - *low > kStepOfDepth * *low) return std::nullopt;
  return sensor.depth_unit_m *
         ((1 - b) * ((1 - a) * z[0] + a * z[1]) + b * ((1 - a) * z[2] + a * z[3]));
}

/// Depth along a ray of the first sensor, by steps from a guess: NaN where they do not agree.
float depth_on(const DepthPair& pair, const Eigen::Vector3d& ray, double guess_m,
               const Pose& depth_from_first, const Lens& depth_lens, const RayGrid& depth_rays) {
  constexpr int kSteps = 4;
  constexpr double kAgree_m = 2e-4;
  double z_m = guess_m;
  for (int step = 0; step < kSteps; ++step) {
    const auto pixel = depth_lens.project(depth_from_first * (z_m * ray).eval());
    if (!pixel) return kNoDepth;
    const auto there_m = between_pixels(pair.depth, pixel->x(), pixel->y());
    if (!there_m) return kNoDepth;
    const double next_m =
        (pair.first_from_depth * (*there_m * depth_rays.at(pixel->x(), pixel->y())).eval()).z();
    const bool agrees = std::abs(next_m - z_m) < kAgree_m;
    z_m = next_m;
    if (agrees) return static_cast<float>(z_m);
  }
  return kNoDepth;
}

FrameDepth gathered(const DepthPair& pair, int frame, double sigma_per_squared_m,
                    double max_sigma_m) {
  FrameDepth result;
  result.frame = frame;
  const RayGrid first_rays(pair.first), depth_rays(pair.depth.reported);
  const Image<float> guess_m = first_guess_m(pair, depth_rays);
  const Pose depth_from_first = inverse(pair.first_from_depth);
  const Lens depth_lens(pair.depth.reported);
  result.depth_m = Image<float>(guess_m.width(), guess_m.height(), kNoDepth);
  result.sigma_m = Image<float>(guess_m.width(), guess_m.height(), kNoDepth);
  tbb::parallel_for(0, guess_m.height(), [&](int y) {
    for (int x = 0; x < guess_m.width(); ++x) {
      if (std::isnan(guess_m(x, y))) continue;
      const float z_m = depth_on(pair, first_rays.at(x, y), static_cast<double>(guess_m(x, y)),
                                 depth_from_first, depth_lens, depth_rays);
      const double sigma_m =
          sigma_per_squared_m * static_cast<double>(z_m) * static_cast<double>(z_m);
      if (!(z_m > 0) || sigma_m > max_sigma_m) continue;
      result.depth_m(x, y) = z_m;
      result.sigma_m(x, y) = static_cast<float>(sigma_m);
    }
  });
  if (std::isnan(sigma_per_squared_m)) result.sigma_m = {};
  return result;
}

std::optional<std::size_t> place_named(const Capture& capture, std::string_view name) {
  for (std::size_t s = 0; s < capture.rig.size(); ++s) {
    if (capture.rig[s].name == name) return s;
  }
  return std::nullopt;
}

}  // namespace

Depths gathered_depths(const Capture& capture, const SensorDepthConfig& config) {
  validate(config);
  const auto left = place_named(capture, "ir_left"), right = place_named(capture, "ir_right");
  std::optional<std::size_t> place = place_named(capture, kDepthSensor);
  for (std::size_t s = 0; !place && s < capture.rig.size(); ++s) {
    if (std::any_of(capture.frames.begin(), capture.frames.end(), [&](const Frame& frame) {
          return frame.sensors.size() > s && !frame.sensors[s].depth.empty();
        }))
      place = s;
  }
  Depths depths;
  for (const Frame& frame : capture.frames) {
    depths.push_back({frame.id, {}, {}, {}});
    if (!place || frame.sensors.size() <= *place || frame.sensors[*place].depth.empty()) continue;
    const SensorFrame& sensor = frame.sensors[*place];
    const Pose from = inverse(capture.rig[*place].sensor_from_rig);
    double sigma_per_squared_m = kNaN;
    if (left && right) {
      const double baseline_m =
          (capture.rig[*right].sensor_from_rig * inverse(capture.rig[*left].sensor_from_rig))
              .translation_m.norm();
      sigma_per_squared_m = config.sigma_px / (sensor.reported.fx_px * baseline_m);
    }
    depths.back() = gathered(
        {sensor, frame.sensors.front().reported, capture.rig.front().sensor_from_rig * from},
        frame.id, sigma_per_squared_m, config.max_sigma_m);
  }
  return depths;
}

}  // namespace cousin
