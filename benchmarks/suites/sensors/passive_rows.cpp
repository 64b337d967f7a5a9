#include "benchmarks/suites/sensors/passive_rows.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "benchmarks/suites/sensors/depth_wall.h"
#include "benchmarks/suites/sensors/sensor_row.h"
#include "perception/stereo/stereo_depth.h"
#include "sim/imaging/rectification.h"
#include "sim/render/path_tracer.h"
#include "sim/sensors/rig_capture.h"

namespace cousin {
namespace {

constexpr int kWidth = 640, kHeight = 360;

/// The preset at half its size, still, with or without errors of its reported calibration.
RigConfig small_zed(bool reports_truly) {
  RigConfig rig = rig_preset("zed_hd720");
  rig.sync_error_s = rig.hand_speed_m_per_s = rig.hand_rate_rad_per_s = 0;
  for (RigSensor& sensor : rig.sensors) {
    sensor.camera.width_px = kWidth;
    sensor.camera.height_px = kHeight;
    if (!reports_truly) continue;
    LensConfig& lens = sensor.camera.lens;
    lens.report_focal_error = lens.report_centre_error_px_per_width = 0;
    lens.report_distortion_error = lens.report_focus_error = 0;
  }
  return rig;
}

struct WallDepth {
  double bias_px = 0;       ///< mean error of the disparity, measured
  double predicted_px = 0;  ///< what the reported calibration makes of the true one
  double sigma_m = 0;       ///< of the depth about its mean error
  double fill = 0;
  std::int64_t pixels = 0;
};

/// Where the first camera's pixel would triangulate to through the reported calibration, if the
/// true disparity were found.
double triangulated_m(const Frame& frame, const std::vector<SensorReport>& rig,
                      const std::vector<SensorViews>& views, const Eigen::Vector2d& pixel_px,
                      const Eigen::Vector3d& in_world_m, const Rectification& r) {
  const TrueView& right = views[1].views.front();
  const auto there = project(right.camera, right.camera_from_world * in_world_m);
  const auto a = unproject(frame.sensors[0].reported, pixel_px);
  const auto b = there ? unproject(frame.sensors[1].reported, *there) : std::nullopt;
  if (!a || !b || rig.size() < 2) return kNaN;
  const auto left_px = project(r.camera, r.rectified_from_left * *a);
  const auto right_px = project(r.camera, r.rectified_from_right * *b);
  if (!left_px || !right_px) return kNaN;
  const double disparity_px = left_px->x() - right_px->x();
  const Eigen::Vector3d turned = r.rectified_from_left * *a;
  return r.camera.fx_px * r.baseline_m / disparity_px / turned.z() * a->z();
}

WallDepth measure_wall(double distance_m, bool reports_truly, std::uint64_t seed) {
  WallScene wall = make_wall({.distance_m = distance_m, .light = 1, .texture = 0.6});
  wall.scene.views.push_back({0, wall.rig_from_world, wall.rig_from_world});
  const RayScene rays(wall.scene);
  const PathTracer tracer(rays, wall.scene);
  const RigCapture rig(small_zed(reports_truly), {}, rays, wall.scene, Rng(seed));
  Capture capture;
  capture.rig = rig.reports();
  const auto radiance = [&](const TrueView& view, const Rng& rng) {
    return tracer.render(view, {.pixel_samples = 4, .max_bounces = 0}, rng).radiance;
  };
  capture.frames.push_back(rig.take(0, {.color = true}, radiance).frame);
  const FrameDepth depth = depth_of_stereo(capture, 0);
  const TrueView& left = rig.views()[0].views.front();
  const TruthImages truth = render_truth(rays, wall.scene, left, {.depth = true, .position = true});
  const Frame& frame = capture.frames.front();
  const Rectification r =
      rectify(frame.sensors[0].reported, frame.sensors[1].reported,
              capture.rig[1].sensor_from_rig * inverse(capture.rig[0].sensor_from_rig));
  const double focal_baseline = r.camera.fx_px * r.baseline_m;
  WallDepth result;
  double sum_px = 0, predicted_px = 0, sum_m = 0, squares_m2 = 0;
  std::int64_t asked = 0;
  for (int y = kHeight / 4; y < 3 * kHeight / 4; ++y) {
    for (int x = kWidth / 4; x < 3 * kWidth / 4; ++x) {
      ++asked;
      const auto z_m = static_cast<double>(depth.depth_m(x, y));
      const auto true_m = static_cast<double>(truth.depth_m(x, y));
      if (std::isnan(z_m)) continue;
      const double off_px = focal_baseline / z_m - focal_baseline / true_m;
      const double by_reports_m =
          triangulated_m(frame, capture.rig, rig.views(), Eigen::Vector2d(x, y),
                         truth.position_m(x, y).cast<double>(), r);
      const double predicted = focal_baseline / by_reports_m - focal_baseline / true_m;
      if (std::abs(off_px - predicted) > 1) continue;  // a wrong match
      ++result.pixels;
      sum_px += off_px;
      predicted_px += predicted;
      const double off_m = z_m - by_reports_m;
      sum_m += off_m;
      squares_m2 += off_m * off_m;
    }
  }
  const auto n = static_cast<double>(result.pixels);
  result.bias_px = sum_px / n;
  result.predicted_px = predicted_px / n;
  result.sigma_m = std::sqrt(std::max(0.0, squares_m2 / n - sum_m / n * (sum_m / n)));
  result.fill = n / static_cast<double>(asked);
  return result;
}

}  // namespace

std::vector<ScoreRow> passive_stereo_rows(std::uint64_t seed, bool quick) {
  const SensorRows of{"zed_hd720", seed};
  const std::vector<double> distances_m =
      quick ? std::vector<double>{0.8, 1.6} : std::vector<double>{0.7, 1.0, 1.4, 2.0};
  std::vector<ScoreRow> rows;
  double sum_x = 0, sum_y = 0, sum_xx = 0, sum_xy = 0;
  for (const double z_m : distances_m) {
    const WallDepth depth = measure_wall(z_m, true, seed);
    char name[64];
    std::snprintf(name, sizeof name, "passive stereo, wall at %.1f m", z_m);
    rows.push_back(sensor_row(of, name, "sigma_z", depth.sigma_m, "m", depth.pixels));
    rows.push_back(sensor_row(of, name, "fill", depth.fill, "1", depth.pixels));
    // Census costs pull disparities towards whole pixels by up to a tenth, with either sign.
    rows.push_back(limited(
        sensor_row(of, name, "disparity.bias", depth.bias_px, "px", depth.pixels), about(0, 0.1)));
    const double x = std::log(z_m), y = std::log(depth.sigma_m);
    sum_x += x;
    sum_y += y;
    sum_xx += x * x;
    sum_xy += x * y;
  }
  const auto n = static_cast<double>(distances_m.size());
  const double exponent = (n * sum_xy - sum_x * sum_y) / (n * sum_xx - sum_x * sum_x);
  rows.push_back(limited(sensor_row(of, "passive stereo, walls", "sigma_z.exponent", exponent, "1",
                                    static_cast<std::int64_t>(distances_m.size())),
                         about(2, 0.25)));
  const WallDepth wrong = measure_wall(1, false, seed);
  const std::string name = "passive stereo, wall at 1.0 m, reported calibration";
  rows.push_back(sensor_row(of, name, "disparity.bias", wrong.bias_px, "px", wrong.pixels));
  rows.push_back(
      sensor_row(of, name, "disparity.bias.predicted", wrong.predicted_px, "px", wrong.pixels));
  rows.push_back(limited(sensor_row(of, name, "disparity.bias.unexplained",
                                    wrong.bias_px - wrong.predicted_px, "px", wrong.pixels),
                         about(0, 0.1)));
  return rows;
}

}  // namespace cousin
