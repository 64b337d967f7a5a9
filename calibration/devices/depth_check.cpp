#include "calibration/devices/depth_check.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <stdexcept>

#include "calibration/boards/planar_pose.h"
#include "calibration/solve/observation_cost.h"
#include "sim/config/limits.h"

namespace cousin {
namespace {

constexpr double kSigmas = 2;

std::vector<Eigen::Vector2d> judged_pixels(const Camera& camera, const DepthCheckConfig& config) {
  std::vector<Eigen::Vector2d> pixels;
  for (int y = 0; y < config.rows; ++y) {
    for (int x = 0; x < config.columns; ++x)
      pixels.emplace_back(x * (camera.width_px - 1.0) / (config.columns - 1),
                          y * (camera.height_px - 1.0) / (config.rows - 1));
  }
  return pixels;
}

std::vector<DepthSample> samples_of(const std::vector<DepthView>& views, std::size_t but) {
  std::vector<DepthSample> samples;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (i != but) samples.insert(samples.end(), views[i].samples.begin(), views[i].samples.end());
  }
  return samples;
}

Eigen::VectorXd bias_over_image(const DepthBias& bias, const std::vector<Eigen::Vector2d>& pixels,
                                const Camera& camera, double distance_m) {
  Eigen::VectorXd result(static_cast<Eigen::Index>(pixels.size()));
  for (std::size_t i = 0; i < pixels.size(); ++i)
    result(static_cast<Eigen::Index>(i)) =
        biased_depth_m(bias, pixels[i], distance_m, camera.width_px, camera.height_px) - distance_m;
  return result;
}

/// Root of the covariance of bias_over_image by leaving out one view at a time: covariance = R R'.
/// Noise that neighbouring pixels share, and each board's own error of pose, are in it.
std::optional<Eigen::MatrixXd> spread_over_views(const std::vector<DepthView>& views,
                                                 const std::vector<Eigen::Vector2d>& pixels,
                                                 const Camera& camera,
                                                 const DepthCheckConfig& config) {
  const auto n = static_cast<Eigen::Index>(views.size());
  Eigen::MatrixXd left(static_cast<Eigen::Index>(pixels.size()), n);
  for (std::size_t i = 0; i < views.size(); ++i) {
    const DepthBias bias =
        fit_depth_bias(samples_of(views, i), camera.width_px, camera.height_px, config.bias);
    if (bias.status != CalibrationStatus::ok) return std::nullopt;
    left.col(static_cast<Eigen::Index>(i)) =
        bias_over_image(bias, pixels, camera, config.distance_m);
  }
  const Eigen::VectorXd mean = left.rowwise().mean();
  const double views_count = static_cast<double>(n);
  return std::sqrt((views_count - 1) / views_count) * (left.colwise() - mean);
}

/// The same of the depths at which the calibration has a plane that faces the depth camera: the
/// frames' mean twist, and the depth camera's own place in the rig.
Eigen::MatrixXd calibration_root(const CalibrationResult& fresh, int depth_camera,
                                 const std::vector<Eigen::Vector2d>& pixels, double distance_m) {
  const Pose& camera_from_rig = fresh.camera_from_rig[static_cast<std::size_t>(depth_camera)];
  const Pose rig_from_camera = inverse(camera_from_rig);
  const Eigen::RowVector3d axis_in_rig =
      camera_from_rig.rotation.toRotationMatrix().row(2);  // camera z of a step in the rig
  const auto n = static_cast<Eigen::Index>(fresh.parameters.size());
  const auto rows = static_cast<Eigen::Index>(pixels.size());
  Eigen::MatrixXd by_parameters = Eigen::MatrixXd::Zero(rows, n), by_twist(rows, 6);
  const int place = parameter_index(fresh, "camera" + std::to_string(depth_camera) + ".r_x");
  for (Eigen::Index i = 0; i < rows; ++i) {
    const auto ray = unproject(fresh.cameras[static_cast<std::size_t>(depth_camera)],
                               pixels[static_cast<std::size_t>(i)]);
    if (!ray || !(ray->z() > 0)) {  // no depth there
      by_twist.row(i).setZero();
      continue;
    }
    const Eigen::Vector3d in_rig_m = rig_from_camera * (distance_m / ray->z() * *ray);
    by_twist.row(i) << -axis_in_rig * cross_matrix(in_rig_m), axis_in_rig;
    if (place < 0) continue;
    for (int k = 0; k < 6; ++k) {
      constexpr double kStep = 1e-6;
      const auto depth_m = [&](double by) {
        Vector6d moved = pose_vector(camera_from_rig);
        moved(k) += by;
        return (pose_of_vector(moved) * in_rig_m).z();
      };
      by_parameters(i, place + k) = (depth_m(kStep) - depth_m(-kStep)) / (2 * kStep);
    }
  }
  by_parameters += by_twist * fresh.mean_frame_gain;
  // The eigenvalues' root: a covariance may be singular.
  const auto root = [](const Eigen::MatrixXd& covariance) -> Eigen::MatrixXd {
    const Eigen::VectorXd scale = covariance.diagonal().cwiseMax(0).cwiseSqrt();
    const Eigen::VectorXd over = scale.unaryExpr([](double s) { return s > 0 ? 1 / s : 0.0; });
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(
        Eigen::MatrixXd(over.asDiagonal() * covariance * over.asDiagonal()));
    return scale.asDiagonal() * solver.eigenvectors() *
           solver.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
  };
  Eigen::MatrixXd result(rows, n + 6);
  result << by_parameters * root(fresh.covariance), by_twist * root(fresh.mean_frame_covariance);
  return result;
}

std::string text_of(const char* format, auto... values) {
  char text[160];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

/// d ~ N(mu, S), S = R R': E d'd = mu'mu + tr S, Var d'd = 2 tr S^2 + 4 mu'S mu.
void judge(const Eigen::VectorXd& bias_m, const Eigen::MatrixXd& root,
           const DepthCheckConfig& config, DepthCheck& check) {
  const auto count = static_cast<double>(bias_m.size());
  const double expected = root.squaredNorm();
  const double squared_trace = (root.transpose() * root).squaredNorm();
  const double along = std::max(0.0, (root.transpose() * bias_m).squaredNorm() - squared_trace);
  const double square = (bias_m.squaredNorm() - expected) / count;
  const double sigma = std::sqrt(2 * squared_trace + 4 * along) / count;
  check.error_m = std::sqrt(std::max(0.0, square));
  check.error_square_sigma_m2 = sigma;
  const double bar = config.least_gain_m * config.least_gain_m;
  check.verdict = square - kSigmas * sigma > bar   ? DepthVerdict::correct
                  : square + kSigmas * sigma < bar ? DepthVerdict::keep
                                                   : DepthVerdict::cannot_tell;
  if (check.verdict == DepthVerdict::cannot_tell)
    check.reason = text_of(
        "an error of %.3g mm is sure to %.3g mm, which leaves the limit of %.3g "
        "mm open",
        1000 * check.rms_m, 1000 * std::sqrt(expected / count), 1000 * config.least_gain_m);
}

}  // namespace

std::string_view to_string(DepthVerdict verdict) {
  constexpr std::array<std::string_view, 3> kNames = {"keep", "correct", "cannot_tell"};
  return kNames.at(static_cast<std::size_t>(verdict));
}

Fields fields(DepthCheckConfig& config) {
  return Fields{
             {"distance_m", &config.distance_m, "working distance of the depth camera", 1e-3, 1e3},
             {"step_px", &config.step_px, "between samples, and of them from the print's border", 1,
              1000},
             {"columns", &config.columns, "of pixels that the bias is judged at", 2, 1000},
             {"rows", &config.rows, "the same", 2, 1000},
             {"least_gain_m", &config.least_gain_m, "of error that a correction is worth", 0, 10},
             {"least_views", &config.least_views, "boards below which nothing is judged", 3, 1000},
         } +
         nested("bias", fields(config.bias));
}

void validate(const DepthCheckConfig& config) {
  DepthCheckConfig copy = config;  // fields point into what they describe
  check_limits(fields(copy), "depth check");
  validate(config.bias);
}

std::vector<DepthSample> depth_on_target(const Image<float>& depth_m, const Camera& camera,
                                         const Pose& camera_from_target,
                                         const CalibrationTarget& target, int step_px) {
  if (depth_m.width() != camera.width_px || depth_m.height() != camera.height_px)
    throw std::invalid_argument("depth of " + std::to_string(depth_m.width()) + " x " +
                                std::to_string(depth_m.height()) + " pixels, its camera has " +
                                std::to_string(camera.width_px) + " x " +
                                std::to_string(camera.height_px));
  const Eigen::Vector2d half_m = 0.5 * print_size_m(target);
  const Pose target_from_camera = inverse(camera_from_target);
  const auto true_depth_m = [&](const Eigen::Vector2d& pixel) {
    const double z_m = plane_depth_m(camera, camera_from_target, pixel);
    const auto ray = unproject(camera, pixel);
    if (!ray || !std::isfinite(z_m)) return std::nan("");
    const Eigen::Vector3d at_m = target_from_camera * (z_m / ray->z() * *ray);
    return (at_m.head<2>().cwiseAbs().array() < half_m.array()).all() ? z_m : std::nan("");
  };
  std::vector<DepthSample> samples;
  for (int y = step_px; y + step_px < camera.height_px; y += step_px) {
    for (int x = step_px; x + step_px < camera.width_px; x += step_px) {
      if (!std::isfinite(depth_m(x, y))) continue;
      const Eigen::Vector2d pixel(x, y);
      const double true_m = true_depth_m(pixel);
      if (!std::isfinite(true_m)) continue;
      bool inside = true;
      for (const int dy : {-step_px, step_px}) {
        for (const int dx : {-step_px, step_px})
          inside = inside && std::isfinite(true_depth_m(pixel + Eigen::Vector2d(dx, dy)));
      }
      if (inside) samples.push_back({pixel, static_cast<double>(depth_m(x, y)), true_m});
    }
  }
  return samples;
}

DepthCheck check_depth(const std::vector<DepthView>& views, const CalibrationResult& fresh,
                       int depth_camera, const DepthCheckConfig& config) {
  validate(config);
  if (depth_camera < 0 || depth_camera >= static_cast<int>(fresh.cameras.size()) ||
      fresh.camera_from_rig.size() != fresh.cameras.size())
    throw std::invalid_argument("depth check: camera " + std::to_string(depth_camera) + " of " +
                                std::to_string(fresh.cameras.size()) + " does not exist");
  const auto n = static_cast<Eigen::Index>(fresh.parameters.size());
  if (n == 0 || fresh.covariance.rows() != n || !fresh.covariance.allFinite() ||
      fresh.mean_frame_gain.cols() != n)
    throw std::invalid_argument("depth check: the calibration has no covariance");

  DepthCheck check;
  std::vector<DepthView> seen;
  for (const DepthView& view : views) {
    if (view.samples.empty()) continue;
    seen.push_back(view);
    for (const DepthSample& s : view.samples) {
      check.nearest_m = std::fmin(check.nearest_m, s.true_m);
      check.farthest_m = std::fmax(check.farthest_m, s.true_m);
    }
  }
  check.views = static_cast<int>(seen.size());
  if (check.views < config.least_views) {
    check.reason = text_of("depth on %d boards; it takes %d", check.views, config.least_views);
    return check;
  }
  if (!(config.distance_m >= check.nearest_m && config.distance_m <= check.farthest_m)) {
    check.reason = text_of("boards have depth from %.3g to %.3g m; the working distance is %.3g m",
                           check.nearest_m, check.farthest_m, config.distance_m);
    return check;
  }
  const Camera& camera = fresh.cameras[static_cast<std::size_t>(depth_camera)];
  check.bias =
      fit_depth_bias(samples_of(seen, seen.size()), camera.width_px, camera.height_px, config.bias);
  if (check.bias.status != CalibrationStatus::ok) {
    check.reason = check.bias.reason;
    return check;
  }
  const std::vector<Eigen::Vector2d> pixels = judged_pixels(camera, config);
  const Eigen::VectorXd bias_m = bias_over_image(check.bias, pixels, camera, config.distance_m);
  const auto spread = spread_over_views(seen, pixels, camera, config);
  if (!spread) {
    check.reason = "without one of the boards the bias is not determined";
    return check;
  }
  const Eigen::MatrixXd made = calibration_root(fresh, depth_camera, pixels, config.distance_m);
  const auto count = static_cast<double>(pixels.size());
  check.bias_m.assign(bias_m.data(), bias_m.data() + bias_m.size());
  check.rms_m = std::sqrt(bias_m.squaredNorm() / count);
  check.mean_m = bias_m.mean();
  check.spread_m = std::sqrt(spread->squaredNorm() / count);
  check.fresh_m = std::sqrt(made.squaredNorm() / count);
  Eigen::MatrixXd root(spread->rows(), spread->cols() + made.cols());
  root << *spread, made;
  judge(bias_m, root, config, check);
  return check;
}

}  // namespace cousin
