#include "benchmarks/suites/calibration/corner_views.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>

namespace cousin {
namespace {

constexpr int kMostDraws = 10'000;
constexpr std::size_t kLeastCorners = 12;

/// As designed, or bent.
std::vector<Eigen::Vector3d> board_points(const CornerViewsConfig& config, const CornerFlaws& flaws,
                                          const Eigen::Vector2d& deformation_m) {
  std::vector<Eigen::Vector3d> points;
  for (int r = 0; r < config.rows; ++r) {
    for (int c = 0; c < config.columns; ++c) {
      const double x = 2.0 * c / (config.columns - 1) - 1, y = 2.0 * r / (config.rows - 1) - 1;
      const double across_m = (c - 0.5 * (config.columns - 1)) * config.pitch_m;
      const double up_m = (0.5 * (config.rows - 1) - r) * config.pitch_m;
      points.emplace_back(flaws.stretch_x * across_m + flaws.shear * up_m, up_m,
                          deformation_m.x() * (1 - x * x) + deformation_m.y() * (1 - y * y) +
                              0.25 * flaws.edge_m * (1 + y) * (1 + y) + flaws.twist_m * x * y);
    }
  }
  return points;
}

Pose draw_pose(const Lens& lens, const CornerViewsConfig& config, Rng rng) {
  const Camera& camera = lens.camera();
  for (int i = 0; i < kMostDraws; ++i) {
    const Eigen::Vector2d pixel(
        camera.width_px * uniform(rng, config.region(0), config.region(2)) - 0.5,
        camera.height_px * uniform(rng, config.region(1), config.region(3)) - 0.5);
    const double distance_m = uniform(rng, config.near_m, config.far_m);
    const double tilt_x = uniform(rng, -config.tilt_rad, config.tilt_rad);
    const double tilt_y = uniform(rng, -config.tilt_rad, config.tilt_rad);
    const double roll = uniform(rng, -config.roll_rad, config.roll_rad);
    const std::optional<Eigen::Vector3d> ray = lens.unproject(pixel);
    if (!ray) continue;
    // Upright before a camera whose y axis points down: half a turn about x.
    const Eigen::Quaterniond turn = Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ()) *
                                    Eigen::AngleAxisd(tilt_x, Eigen::Vector3d::UnitX()) *
                                    Eigen::AngleAxisd(tilt_y, Eigen::Vector3d::UnitY()) *
                                    Eigen::Quaterniond(0, 1, 0, 0);
    const Pose pose{turn.normalized(), distance_m * *ray};
    std::size_t seen = 0;
    const std::vector<Eigen::Vector3d> points =
        board_points(config, config.flaws, config.deformation_m);
    for (const Eigen::Vector3d& p : points) {
      const std::optional<Eigen::Vector2d> q = lens.project(pose * p);
      seen += q && q->x() > 0 && q->y() > 0 && q->x() < camera.width_px - 1 &&
                      q->y() < camera.height_px - 1
                  ? 1
                  : 0;
    }
    if (seen >= (config.whole ? points.size() : kLeastCorners)) return pose;
  }
  throw std::runtime_error("corner views: the board does not fit into the image in " +
                           std::to_string(kMostDraws) + " draws");
}

/// What is drawn of the flaws for one frame.
struct FrameFlaws {
  std::vector<Eigen::Vector3d> points;                 ///< of the board as it is then
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();  ///< from the first row to the last
};
FrameFlaws draw_flaws(const CornerViewsConfig& config, Rng rng) {
  const CornerFlaws& f = config.flaws;
  const double bend_x = f.flutter_m * normal(rng), bend_y = f.flutter_m * normal(rng);
  FrameFlaws drawn;
  drawn.points = board_points(config, f, config.deformation_m + Eigen::Vector2d(bend_x, bend_y));
  for (int k = 0; k < 3; ++k) drawn.turn_rad(k) = f.turn_rad * normal(rng);
  return drawn;
}

/// Where a point is seen by a camera that turns while its rows are read.
std::optional<Eigen::Vector2d> seen_at(const Lens& lens, const Eigen::Vector3d& in_camera_m,
                                       const Eigen::Vector3d& turn_rad) {
  std::optional<Eigen::Vector2d> pixel = lens.project(in_camera_m);
  if (turn_rad.isZero(0)) return pixel;
  // The row that sees the point depends on the turn by then: twice is enough for turns of
  // hundredths.
  for (int i = 0; i < 2 && pixel; ++i) {
    const double share = pixel->y() / (lens.camera().height_px - 1) - 0.5;
    pixel = lens.project(in_camera_m + share * turn_rad.cross(in_camera_m));
  }
  return pixel;
}

}  // namespace

CornerViews make_corner_views(const std::vector<Camera>& cameras,
                              const std::vector<Pose>& camera_from_rig,
                              const CornerViewsConfig& config, const Rng& rng) {
  CornerViews views;
  views.cameras = cameras;
  views.camera_from_rig = camera_from_rig;
  views.input.target_m = board_points(config, {}, Eigen::Vector2d::Zero());
  std::vector<Lens> lenses(cameras.begin(), cameras.end());
  for (const Camera& camera : cameras) {
    Camera start = camera;
    start.fx_px = start.fy_px = start.cx_px = start.cy_px = 0;
    start.distortion = {};
    start.spline.delta_u.clear();
    views.input.cameras.push_back({start, -1});
  }
  for (int f = 0; f < config.frames; ++f) {
    const Rng frame = rng.fork("frame").fork(static_cast<std::uint64_t>(f));
    const Pose pose =
        inverse(camera_from_rig.front()) * draw_pose(lenses.front(), config, frame.fork("pose"));
    const FrameFlaws flaws = draw_flaws(config, frame.fork("flaws"));
    views.rig_from_target.push_back(pose);
    for (std::size_t c = 0; c < cameras.size(); ++c) {
      Rng noise = frame.fork("noise").fork(c), outlier = frame.fork("outlier").fork(c);
      TargetView view{f, static_cast<int>(c), TargetStatus::ok, "", {}};
      std::vector<bool> wrong;
      for (std::size_t i = 0; i < flaws.points.size(); ++i) {
        const auto q =
            seen_at(lenses[c], camera_from_rig[c] * (pose * flaws.points[i]), flaws.turn_rad);
        const double dx = normal(noise), dy = normal(noise);
        const bool out = uniform(outlier) < config.outlier_share;
        const double ox = uniform(outlier, -1, 1), oy = uniform(outlier, -1, 1);
        if (!q || !(q->x() > 0 && q->y() > 0 && q->x() < cameras[c].width_px - 1 &&
                    q->y() < cameras[c].height_px - 1))
          continue;
        const Eigen::Vector2d shift = (out ? config.outlier_px : 0) * Eigen::Vector2d(ox, oy);
        const Eigen::Vector2d last(cameras[c].width_px - 1, cameras[c].height_px - 1);
        const Eigen::Vector2d off =
            config.flaws.shift_px + config.noise_px * Eigen::Vector2d(dx, dy) + shift;
        TargetObservation seen{static_cast<int>(i),
                               (*q + off).cwiseMax(Eigen::Vector2d::Zero()).cwiseMin(last)};
        seen.covariance_px2 =
            std::max(1e-12, config.noise_px * config.noise_px) * Eigen::Matrix2d::Identity();
        view.points.push_back(seen);
        wrong.push_back(out);
      }
      if (view.points.size() < kLeastCorners) continue;
      views.input.views.push_back(std::move(view));
      views.outliers.push_back(std::move(wrong));
    }
  }
  return views;
}

Camera study_camera(LensModel model) {
  Camera camera{model, 640, 480, 390, 391, 322, 243, {}, {}};
  if (model == LensModel::pinhole) return camera;
  if (model == LensModel::kannala_brandt4) {
    camera.fx_px = 300, camera.fy_px = 301;
    camera.distortion = {-0.02, 0.005, -0.003, 0.0005};
    return camera;
  }
  if (model == LensModel::splined_stereographic) {
    camera.spline = {.order = 3,
                     .columns = 10,
                     .rows = 8,
                     .fov_x_rad = 100 * std::numbers::pi / 180,
                     .delta_u = {}};
    for (int j = 0; j < 8; ++j) {
      for (int i = 0; i < 10; ++i) {
        const double x = (i - 4.5) / 4.5, y = (j - 3.5) / 4.5, r2 = x * x + y * y;
        camera.spline.delta_u.push_back(0.02 * x * r2 + 0.003 * std::sin(3 * y));
        camera.spline.delta_u.push_back(0.02 * y * r2 + 0.002 * std::cos(2 * x));
      }
    }
    return camera;
  }
  camera.distortion = {-0.055, 0.06, 1e-3, -8e-4, -0.016};
  if (model == LensModel::opencv5) return camera;
  // Chosen so that 0.1 px of noise fixes each coefficient to a hundredth: where numerator and
  // denominator nearly cancel, a rational lens has a valley instead of a minimum.
  camera.fx_px = 260, camera.fy_px = 261;
  camera.distortion = {0.806, -0.594, 1e-3, -8e-4, 0.352, 0.077, 0.549, 0.032};
  if (model == LensModel::opencv8) return camera;
  camera.distortion[8] = 1e-3, camera.distortion[9] = -5e-4;
  camera.distortion[10] = -8e-4, camera.distortion[11] = 4e-4;
  return camera;
}

}  // namespace cousin
