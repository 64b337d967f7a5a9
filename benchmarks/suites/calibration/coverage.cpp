#include "benchmarks/suites/calibration/coverage.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <optional>

namespace cousin {
namespace {

struct Counts {
  bool ok = false;
  int within_68 = 0, within_95 = 0, intervals = 0;
};

/// The same poses, other noise.
CalibrationInput noisy(const CornerViews& clean, double noise_px, Rng rng) {
  CalibrationInput input = clean.input;
  for (TargetView& view : input.views) {
    for (TargetObservation& p : view.points) {
      p.pixel_px.x() += noise_px * normal(rng);
      p.pixel_px.y() += noise_px * normal(rng);
    }
  }
  return input;
}

/// Where the true camera sees what the calibrated one has at a pixel, when the frames' mean motion
/// between the two calibrations is taken out.
std::optional<Eigen::Vector2d> true_pixel_mean_frames(const CornerViews& clean,
                                                      const CalibrationResult& result,
                                                      const Eigen::Vector2d& pixel,
                                                      double distance_m) {
  const std::optional<Eigen::Vector3d> ray = unproject(result.cameras[0], pixel);
  if (!ray) return std::nullopt;
  const bool far = !std::isfinite(distance_m);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const CalibrationFrame& frame : result.frames) {
    const Pose& truth = clean.rig_from_target[static_cast<std::size_t>(frame.frame)];
    const Pose true_from_ours = truth * inverse(frame.rig_from_target);
    mean += far ? Eigen::Vector3d(true_from_ours.rotation * *ray)
                : Eigen::Vector3d(true_from_ours * (distance_m * *ray));
  }
  return project(clean.cameras[0], mean / static_cast<double>(result.frames.size()));
}

Counts one(const CornerViews& clean, const CoverageConfig& config, const Rng& rng) {
  Counts counts;
  CalibrationConfig solve;
  solve.tolerance = 1e-10;
  const CalibrationResult result =
      calibrate(noisy(clean, config.views.noise_px, rng.fork("noise")), solve);
  if (result.status != CalibrationStatus::ok) return counts;
  counts.ok = true;
  UncertaintyConfig uncertainty;
  uncertainty.gauge = config.gauge;
  uncertainty.distance_m = config.distance_m;
  const Camera& camera = result.cameras[0];
  const double w = camera.width_px, h = camera.height_px;
  const std::vector<Eigen::Vector2d> pixels = {{0.5 * w, 0.5 * h},
                                               {0.25 * w, 0.3 * h},
                                               {0.8 * w, 0.6 * h},
                                               {0.1 * w, 0.85 * h},
                                               {0.95 * w, 0.05 * h}};
  const std::vector<Eigen::Matrix2d> predicted =
      projection_uncertainty_at(result, 0, pixels, uncertainty);
  const ProjectionDifference best = projection_difference(camera, clean.cameras[0], uncertainty);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    std::optional<Eigen::Vector2d> truth;
    if (config.gauge == ProjectionGauge::mean_frames) {
      truth = true_pixel_mean_frames(clean, result, pixels[i], config.distance_m);
    } else if (const auto ray = unproject(camera, pixels[i])) {
      const bool far = !std::isfinite(config.distance_m);
      truth = project(clean.cameras[0],
                      best.b_from_a * (far ? *ray : Eigen::Vector3d(config.distance_m * *ray)));
    }
    for (int axis = 0; axis < 2; ++axis) {
      ++counts.intervals;
      if (!truth) continue;
      const double off = std::abs((*truth - pixels[i])(axis)) / std::sqrt(predicted[i](axis, axis));
      counts.within_68 += off <= 0.994457883209753 ? 1 : 0;  // quantiles of the normal
      counts.within_95 += off <= 1.959963984540054 ? 1 : 0;
    }
  }
  return counts;
}

}  // namespace

Coverage projection_coverage(const CoverageConfig& config, const Rng& rng) {
  CornerViewsConfig views = config.views;
  views.noise_px = 0;
  const CornerViews clean =
      make_corner_views({study_camera(config.model)}, {Pose{}}, views, rng.fork("views"));
  std::vector<Counts> all(static_cast<std::size_t>(config.calibrations));
  tbb::parallel_for(std::size_t{0}, all.size(), [&](std::size_t i) {
    all[i] = one(clean, config, rng.fork("calibration").fork(i));
  });
  Coverage coverage;
  for (const Counts& c : all) {
    coverage.calibrations += c.ok ? 1 : 0;
    coverage.failed += c.ok ? 0 : 1;
    coverage.intervals += c.intervals;
    coverage.within_68 += c.within_68;
    coverage.within_95 += c.within_95;
  }
  coverage.within_68 /= static_cast<double>(coverage.intervals);
  coverage.within_95 /= static_cast<double>(coverage.intervals);
  return coverage;
}

}  // namespace cousin
