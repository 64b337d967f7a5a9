#include "benchmarks/tools/calibrate/calibration_run.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <mutex>
#include <set>
#include <stdexcept>

#include "benchmarks/tools/calibrate/calibration_pictures.h"
#include "benchmarks/tools/calibrate/device_report.h"
#include "benchmarks/tools/calibrate/run_judgement.h"
#include "sim/config/limits.h"

namespace cousin {
namespace {

constexpr int kCoverageColumns = 10, kCoverageRows = 8;

std::string size_text(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

/// What one photo gave.
struct Found {
  TargetView view;
  int width = 0, height = 0;
  std::string error;
};

std::vector<Found> find_in_all(const CalibrationPhotos& photos, const CalibrateConfig& config,
                               const Progress& progress) {
  std::vector<Found> all(photos.photos.size());
  std::mutex mutex;
  int done = 0;
  tbb::parallel_for(std::size_t{0}, all.size(), [&](std::size_t i) {
    const CalibrationPhoto& photo = photos.photos[i];
    Found& found = all[i];
    try {
      const Image<float> light = read_light(photo);
      found.width = light.width();
      found.height = light.height();
      found.view = find_target(light, photos.target, config.detection, *photos.layout);
    } catch (const std::runtime_error& error) {
      found.error = error.what();
    }
    found.view.frame = photo.frame;
    found.view.camera = photo.camera;
    found.view.time_s =
        config.frame_rate_hz > 0 ? photo.frame / config.frame_rate_hz : photo.time_s;
    const std::lock_guard lock(mutex);
    if (progress) progress("finding the board", ++done, static_cast<int>(all.size()));
  });
  for (const Found& found : all) {
    if (!found.error.empty()) throw std::runtime_error(found.error);
  }
  return all;
}

/// One camera for each of the photos', of its images' size.
std::vector<Camera> cameras_of(const CalibrationPhotos& photos, const std::vector<Found>& found,
                               LensModel model) {
  std::vector<Camera> cameras(photos.cameras.size());
  std::vector<const CalibrationPhoto*> first(cameras.size(), nullptr);
  for (std::size_t i = 0; i < found.size(); ++i) {
    const CalibrationPhoto& photo = photos.photos[i];
    const auto c = static_cast<std::size_t>(photo.camera);
    if (first[c] == nullptr) {
      first[c] = &photo;
      cameras[c].model = model;
      cameras[c].width_px = found[i].width;
      cameras[c].height_px = found[i].height;
    } else if (cameras[c].width_px != found[i].width || cameras[c].height_px != found[i].height) {
      throw std::runtime_error(
          photo.file.string() + ": " + size_text(found[i].width, found[i].height) + " pixels; " +
          first[c]->name + " has " + size_text(cameras[c].width_px, cameras[c].height_px));
    }
  }
  return cameras;
}

/// Refuses a set that shows no board, or another one.
void check_views(const CalibrationPhotos& photos, const std::vector<TargetView>& views) {
  std::size_t usable = 0, wrong = 0;
  std::string first_reason, wrong_reason;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (is_usable(views[i])) {
      ++usable;
      continue;
    }
    const std::string reason = photos.photos[i].file.string() + ": " + views[i].reason;
    if (first_reason.empty()) first_reason = reason;
    if (views[i].status != TargetStatus::wrong_target) continue;
    ++wrong;
    if (wrong_reason.empty()) wrong_reason = reason;
  }
  if (wrong > usable) {
    throw std::runtime_error("a board of the wrong size or layout in " + std::to_string(wrong) +
                             " of " + std::to_string(views.size()) + " images: " + wrong_reason);
  }
  if (usable == 0) {
    throw std::runtime_error("no board found in any of " + std::to_string(views.size()) +
                             " images: " + first_reason);
  }
}

double coverage_of(const CalibrationInput& input, int camera) {
  const Camera& lens = input.cameras[static_cast<std::size_t>(camera)].start;
  std::set<int> cells;
  for (const TargetView& view : input.views) {
    if (view.camera != camera) continue;
    for (const TargetObservation& o : view.points) {
      const int c = static_cast<int>((o.pixel_px.x() + 0.5) / lens.width_px * kCoverageColumns);
      const int r = static_cast<int>((o.pixel_px.y() + 0.5) / lens.height_px * kCoverageRows);
      cells.insert(std::clamp(r, 0, kCoverageRows - 1) * kCoverageColumns +
                   std::clamp(c, 0, kCoverageColumns - 1));
    }
  }
  return static_cast<double>(cells.size()) / (kCoverageColumns * kCoverageRows);
}

double tilt_spread_of(const CalibrationResult& result, const std::set<int>& frames, int camera) {
  std::vector<Eigen::Vector3d> normals;
  const Pose& camera_from_rig = result.camera_from_rig[static_cast<std::size_t>(camera)];
  for (const CalibrationFrame& f : result.frames) {
    if (frames.count(f.frame) > 0)
      normals.push_back((camera_from_rig * f.rig_from_target).rotation * Eigen::Vector3d::UnitZ());
  }
  double widest = 0;
  for (const Eigen::Vector3d& a : normals) {
    for (const Eigen::Vector3d& b : normals)
      widest = std::max(widest, std::acos(std::clamp(a.dot(b), -1.0, 1.0)));
  }
  return widest;
}

double median_deviation_px(const UncertaintyMap& map) {
  std::vector<double> values;
  for (const Eigen::Matrix2d& covariance : map.covariance_px2) {
    if (covariance.allFinite()) values.push_back(worst_deviation_px(covariance));
  }
  if (values.empty()) return std::nan("");
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// A fisheye's dark corners, where nothing is known, would decide the rotation that fits best over
/// the image: its points are taken where the boards were.
UncertaintyConfig gauge_of(const CalibrationResult& result, const Camera& lens) {
  if (lens.model != LensModel::kannala_brandt4 || result.frames.empty()) return {};
  double sum_m = 0;
  for (const CalibrationFrame& f : result.frames) sum_m += f.rig_from_target.translation_m.norm();
  return {.gauge = ProjectionGauge::mean_frames,
          .distance_m = sum_m / static_cast<double>(result.frames.size())};
}

/// Of points from the principal point: a fisheye's picture hardly goes on beyond.
double reach_px(const CalibrationInput& input, int camera, const Camera& lens) {
  double reach = 0;
  for (const TargetView& view : input.views) {
    if (view.camera != camera) continue;
    for (const TargetObservation& o : view.points)
      reach = std::max(reach, (o.pixel_px - Eigen::Vector2d(lens.cx_px, lens.cy_px)).norm());
  }
  return 1.05 * reach;
}

CameraVerdict verdict_of(const CalibrationRun& run, int camera) {
  CameraVerdict v;
  v.deviation_px = std::nan("");
  double squares = 0, predicted = 0;
  int count = 0, points = 0;
  std::set<int> frames;
  for (const CalibrationResidual& r : run.result.residuals) {
    const TargetView& view = run.input.views[static_cast<std::size_t>(r.view)];
    if (view.camera != camera || r.rejected) continue;
    squares += r.residual_px.squaredNorm();
    ++count;
    frames.insert(view.frame);
  }
  for (const TargetView& view : run.input.views) {
    if (view.camera != camera || !is_usable(view)) continue;
    for (const TargetObservation& o : view.points) predicted += o.covariance_px2.trace(), ++points;
  }
  v.rms_px = std::sqrt(squares / std::max(1, 2 * count));
  v.predicted_px = std::sqrt(predicted / std::max(1, 2 * points));
  v.coverage = coverage_of(run.input, camera);
  v.tilt_spread_rad = tilt_spread_of(run.result, frames, camera);
  if (run.result.covariance.rows() > 0) {
    const Camera& lens = run.result.cameras[static_cast<std::size_t>(camera)];
    v.uncertainty = projection_uncertainty(run.result, camera, gauge_of(run.result, lens));
    constexpr double kValidShare = 0.001;  // of the width: 0.64 px at VGA
    v.valid_share =
        valid_region(run.result, run.input, camera, v.uncertainty, kValidShare * lens.width_px)
            .share;
    v.deviation_px = median_deviation_px(v.uncertainty);
    v.next = best_next_view(run.result, camera, run.input.target_m,
                            lens.model == LensModel::kannala_brandt4
                                ? reach_px(run.input, camera, lens)
                                : std::numeric_limits<double>::infinity());
  }
  return v;
}

}  // namespace

Fields fields(CalibrateConfig& config) {
  return Fields{{"model",
                 TextField{[&config] { return std::string(to_string(config.model)); },
                           [&config](const std::string& text) {
                             config.model = lens_model_from_string(text);
                           }},
                 "lens model of every camera"},
                {"most_rms_px", &config.most_rms_px, "RMS a coordinate above which no lens fits", 0,
                 1e6},
                {"most_rms_sigmas", &config.most_rms_sigmas,
                 "and times what detection predicts for it", 1, 1e6},
                {"warn_deviation_share", &config.warn_deviation_share,
                 "projection's median deviation over the width that is warned of", 0, 1},
                {"most_deviation_share", &config.most_deviation_share, "and that is refused", 0, 1},
                {"least_tilt_spread_rad", &config.least_tilt_spread_rad,
                 "below, boards count as parallel", 0, 1.5},
                {"rolling_shutter", &config.rolling_shutter,
                 "one camera: rows are read one after the other, the camera moves"},
                {"frame_rate_hz", &config.frame_rate_hz, "of a folder that is a video; 0 = none", 0,
                 1e5}} +
         nested("rolling", fields(config.rolling)) +
         nested("registration", fields(config.registration)) +
         nested("depth", fields(config.depth)) + nested("calibration", fields(config.calibration)) +
         nested("detection", fields(config.detection));
}

void validate(const CalibrateConfig& config) {
  CalibrateConfig copy = config;
  check_limits(fields(copy));
  validate(config.calibration);
  validate(config.detection);
  validate(config.rolling);
  validate(config.registration);
  validate(config.depth);
}

CalibrationRun run_calibration(CalibrationPhotos photos, const CalibrateConfig& config,
                               const Progress& progress) {
  validate(config);
  CalibrationRun run;
  run.photos = std::move(photos);
  run.config = config;
  const auto start = std::chrono::steady_clock::now();
  run.photos.layout = layout_seen(run.photos);
  std::vector<Found> found = find_in_all(run.photos, config, progress);
  run.detect_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const std::vector<Camera> cameras = cameras_of(run.photos, found, config.model);
  std::vector<TargetView> views;
  for (Found& f : found) views.push_back(std::move(f.view));
  check_views(run.photos, views);
  run.sample = sample_picture(run.photos, views);
  run.input = calibration_input(run.photos.target, std::move(views), cameras);
  agree_on_half_turns(run.input, config.calibration);
  if (progress) progress("solving", 0, 1);
  if (config.rolling_shutter) {
    run.rolling = calibrate_rolling_shutter(run.input, config.calibration, config.rolling);
    run.result = run.rolling->calibration;
  } else {
    run.result = calibrate(run.input, config.calibration);
  }
  if (progress) progress("solving", 1, 1);
  const bool has_lenses = run.result.status == CalibrationStatus::ok ||
                          run.result.status == CalibrationStatus::not_determined ||
                          run.result.status == CalibrationStatus::not_converged;
  if (has_lenses && run.result.cameras.size() == cameras.size()) {
    for (std::size_t c = 0; c < cameras.size(); ++c)
      run.verdicts.push_back(verdict_of(run, static_cast<int>(c)));
    if (run.result.status == CalibrationStatus::ok) {
      compare_with_reported(run);
      check_depth_on_boards(run);
    }
    if (run.result.status == CalibrationStatus::ok && run.result.frames.size() >= 6 &&
        !config.rolling_shutter)
      run.cross = cross_validate(run.input, config.calibration);
  }
  judge(run);
  warn_of_shutters(run);
  warn_of_turned_photos(run);
  return run;
}

}  // namespace cousin
