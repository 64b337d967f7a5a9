#include "calibration/solve/calibration_uncertainty.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "calibration/boards/planar_pose.h"
#include "calibration/solve/lens_value.h"
#include "calibration/solve/observation_cost.h"

namespace cousin {
namespace {

using Motion = Eigen::Matrix<double, 2, 6, Eigen::RowMajor>;

std::vector<Eigen::Vector2d> grid_pixels(const Camera& camera, const UncertaintyConfig& config) {
  if (config.columns < 2 || config.rows < 2) {
    throw std::invalid_argument("uncertainty: columns = " + std::to_string(config.columns) +
                                " and rows = " + std::to_string(config.rows) +
                                " must be at least 2");
  }
  std::vector<Eigen::Vector2d> pixels;
  for (int y = 0; y < config.rows; ++y) {
    for (int x = 0; x < config.columns; ++x) {
      pixels.emplace_back(x * (camera.width_px - 1.0) / (config.columns - 1),
                          y * (camera.height_px - 1.0) / (config.rows - 1));
    }
  }
  return pixels;
}

/// Of the pixel that sees a point: by all parameters of the lens, and by a motion (rotation rad,
/// translation) of the points about the camera. Points at infinity do not move by translation.
struct PixelDerivatives {
  bool ok = false;
  Eigen::Vector3d point;
  RowMatrix lens;
  Motion motion = Motion::Zero();
};

PixelDerivatives derivatives_at(const Lens& lens, const LensShape& shape,
                                const Eigen::VectorXd& parameters, const Eigen::Vector2d& pixel,
                                double distance_m) {
  PixelDerivatives d;
  const std::optional<Eigen::Vector3d> ray = lens.unproject(pixel);
  if (!ray) return d;
  const bool far = !std::isfinite(distance_m);
  d.point = far ? *ray : Eigen::Vector3d(distance_m * *ray);
  d.lens.resize(2, lens_parameter_count(shape));
  LensValue value;
  if (!lens_value(shape, parameters.data(), d.point, value, d.lens.data())) return d;
  d.motion.leftCols<3>() = -value.d_point * cross_matrix(d.point);
  if (!far) d.motion.rightCols<3>() = value.d_point;
  d.ok = true;
  return d;
}

/// Columns of the result's parameters that are of the camera's lens, and which of the lens'.
struct LensColumns {
  std::vector<int> of_result, of_lens;
};
LensColumns lens_columns(const CalibrationResult& result, int camera) {
  LensColumns columns;
  const Camera& lens = result.cameras[static_cast<std::size_t>(camera)];
  const std::vector<std::string> names = lens_parameter_names(shape_of(lens));
  // A lens that is shared goes by the name of the first camera that has it.
  for (int owner = camera; owner >= 0 && columns.of_result.empty(); --owner) {
    if (!(result.cameras[static_cast<std::size_t>(owner)] == lens)) continue;
    for (std::size_t k = 0; k < names.size(); ++k) {
      const int at = parameter_index(result, "camera" + std::to_string(owner) + "." + names[k]);
      if (at < 0) continue;
      columns.of_result.push_back(at);
      columns.of_lens.push_back(static_cast<int>(k));
    }
  }
  return columns;
}

/// Derivative of pixels by a motion, as the least-squares problem that finds it.
struct BestMotion {
  Eigen::MatrixXd motion;  ///< 2 M x 3 or 6
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver;
  Eigen::MatrixXd gain;  ///< of the motion, by the lens' parameters
};

BestMotion best_motion(const std::vector<PixelDerivatives>& grid, bool far) {
  Eigen::Index rows = 0;
  Eigen::Index n = 0;
  for (const PixelDerivatives& d : grid) {
    rows += d.ok ? 2 : 0;
    n = std::max(n, d.lens.cols());
  }
  BestMotion best;
  const Eigen::Index freedoms = far ? 3 : 6;
  best.motion.resize(rows, freedoms);
  Eigen::MatrixXd lens(rows, n);
  rows = 0;
  for (const PixelDerivatives& d : grid) {
    if (!d.ok) continue;
    best.motion.middleRows<2>(rows) = d.motion.leftCols(freedoms);
    lens.middleRows<2>(rows) = d.lens;
    rows += 2;
  }
  best.solver.setThreshold(1e-9);
  best.solver.compute(best.motion);
  best.gain = -best.solver.solve(lens);
  return best;
}

/// The change of a pixel by all of the result's parameters, and by the frames' own mean twist.
struct Sensitivity {
  Eigen::Matrix<double, 2, Eigen::Dynamic> parameters;
  Motion own = Motion::Zero();
};

Sensitivity mean_frames_sensitivity(const CalibrationResult& result, int camera,
                                    const PixelDerivatives& d, const LensColumns& columns,
                                    bool far) {
  const auto n = static_cast<Eigen::Index>(result.parameters.size());
  Sensitivity s;
  s.parameters.setZero(2, n);
  for (std::size_t k = 0; k < columns.of_result.size(); ++k)
    s.parameters.col(columns.of_result[k]) += d.lens.col(columns.of_lens[k]);
  // The point moves with the frames' mean twist in the rig; the camera's own pose errs as well.
  const Pose& camera_from_rig = result.camera_from_rig[static_cast<std::size_t>(camera)];
  const Eigen::Matrix3d rotation = camera_from_rig.rotation.toRotationMatrix();
  const Eigen::Vector3d at = far ? Eigen::Vector3d::Zero() : camera_from_rig.translation_m;
  Eigen::Matrix<double, 6, 6> to_camera = Eigen::Matrix<double, 6, 6>::Zero();
  to_camera.topLeftCorner<3, 3>() = to_camera.bottomRightCorner<3, 3>() = rotation;
  to_camera.bottomLeftCorner<3, 3>() = cross_matrix(at) * rotation;
  s.own = d.motion * to_camera;
  s.parameters += s.own * result.mean_frame_gain;
  const int pose = parameter_index(result, "camera" + std::to_string(camera) + ".r_x");
  if (pose < 0) return s;
  const PosedFrame frame(pose_vector(camera_from_rig).data());
  s.parameters.middleCols<3>(pose) +=
      (d.motion.leftCols<3>() + d.motion.rightCols<3>() * cross_matrix(at)) * frame.left_jacobian;
  s.parameters.middleCols<3>(pose + 3) += d.motion.rightCols<3>();
  return s;
}

/// Differences of the pixels that remain after the motion between the cameras.
/// @param points  seen by the first camera at each pixel
void measure_difference(const Lens& of_b, const std::vector<std::optional<Eigen::Vector3d>>& points,
                        ProjectionDifference& result) {
  double sum = 0, count = 0;
  result.max_px = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto seen = points[i] ? of_b.project(result.b_from_a * *points[i]) : std::nullopt;
    result.difference_px.emplace_back(
        seen ? Eigen::Vector2d(*seen - result.pixel_px[i])
             : Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN()));
    if (!seen) continue;
    sum += result.difference_px.back().squaredNorm();
    result.max_px = std::max(result.max_px, result.difference_px.back().norm());
    ++count;
  }
  result.rms_px = std::sqrt(sum / count);
}

}  // namespace

std::vector<Eigen::Matrix2d> projection_uncertainty_at(const CalibrationResult& result, int camera,
                                                       const std::vector<Eigen::Vector2d>& pixels,
                                                       const UncertaintyConfig& config) {
  if (camera < 0 || camera >= static_cast<int>(result.cameras.size())) {
    throw std::invalid_argument("uncertainty: camera " + std::to_string(camera) +
                                " does not exist");
  }
  if (result.covariance.rows() != static_cast<Eigen::Index>(result.parameters.size()) ||
      result.parameters.empty()) {
    throw std::invalid_argument("uncertainty: the calibration has no covariance");
  }
  const Camera& of = result.cameras[static_cast<std::size_t>(camera)];
  const Lens lens(of);
  const LensShape shape = shape_of(of);
  const Eigen::VectorXd parameters = lens_parameters(of);
  const LensColumns columns = lens_columns(result, camera);
  const bool far = !std::isfinite(config.distance_m);
  const auto m = static_cast<Eigen::Index>(columns.of_result.size());
  Eigen::MatrixXd covariance(m, m);
  for (Eigen::Index i = 0; i < m; ++i) {
    for (Eigen::Index j = 0; j < m; ++j)
      covariance(i, j) = result.covariance(columns.of_result[static_cast<std::size_t>(i)],
                                           columns.of_result[static_cast<std::size_t>(j)]);
  }
  BestMotion best;
  if (config.gauge == ProjectionGauge::best_fit) {
    std::vector<PixelDerivatives> grid;
    for (const Eigen::Vector2d& p : grid_pixels(of, config))
      grid.push_back(derivatives_at(lens, shape, parameters, p, config.distance_m));
    best = best_motion(grid, far);
  }
  std::vector<Eigen::Matrix2d> result_px2;
  for (const Eigen::Vector2d& pixel : pixels) {
    const PixelDerivatives d = derivatives_at(lens, shape, parameters, pixel, config.distance_m);
    if (!d.ok) {
      result_px2.emplace_back(Eigen::Matrix2d::Constant(std::numeric_limits<double>::quiet_NaN()));
    } else if (config.gauge == ProjectionGauge::best_fit) {
      const Eigen::MatrixXd all = d.lens + d.motion.leftCols(best.motion.cols()) * best.gain;
      Eigen::MatrixXd j(2, m);
      for (Eigen::Index i = 0; i < m; ++i)
        j.col(i) = all.col(columns.of_lens[static_cast<std::size_t>(i)]);
      result_px2.emplace_back(j * covariance * j.transpose());
    } else {
      const Sensitivity s = mean_frames_sensitivity(result, camera, d, columns, far);
      result_px2.emplace_back(s.parameters * result.covariance * s.parameters.transpose() +
                              s.own * result.mean_frame_covariance * s.own.transpose());
    }
  }
  return result_px2;
}

UncertaintyMap projection_uncertainty(const CalibrationResult& result, int camera,
                                      const UncertaintyConfig& config) {
  UncertaintyMap map;
  map.columns = config.columns;
  map.rows = config.rows;
  if (camera >= 0 && camera < static_cast<int>(result.cameras.size()))
    map.pixel_px = grid_pixels(result.cameras[static_cast<std::size_t>(camera)], config);
  map.covariance_px2 = projection_uncertainty_at(result, camera, map.pixel_px, config);
  return map;
}

double worst_deviation_px(const Eigen::Matrix2d& c) {
  const double half = 0.5 * (c(0, 0) + c(1, 1));
  return std::sqrt(half + std::hypot(0.5 * (c(0, 0) - c(1, 1)), c(0, 1)));
}

double rms_deviation_px(const UncertaintyMap& map) {
  double sum = 0;
  int count = 0;
  for (const Eigen::Matrix2d& c : map.covariance_px2) {
    const double worst = worst_deviation_px(c);
    if (std::isnan(worst)) continue;
    sum += worst * worst;
    ++count;
  }
  return std::sqrt(sum / count);
}

ProjectionDifference projection_difference(const Camera& a, const Camera& b,
                                           const UncertaintyConfig& config, double radius_px) {
  if (a.width_px != b.width_px || a.height_px != b.height_px) {
    throw std::invalid_argument("projection difference: images of " + std::to_string(a.width_px) +
                                " x " + std::to_string(a.height_px) + " and " +
                                std::to_string(b.width_px) + " x " + std::to_string(b.height_px));
  }
  ProjectionDifference result;
  result.columns = config.columns;
  result.rows = config.rows;
  result.pixel_px = grid_pixels(a, config);
  const bool far = !std::isfinite(config.distance_m);
  const Lens of_a(a), of_b(b);
  std::vector<std::optional<Eigen::Vector3d>> points;
  for (const Eigen::Vector2d& pixel : result.pixel_px) {
    points.push_back(of_a.unproject(pixel));
    if (points.back() && !far) *points.back() *= config.distance_m;
  }
  const Eigen::Vector2d middle(0.5 * (a.width_px - 1), 0.5 * (a.height_px - 1));
  const int freedoms = far ? 3 : 6;
  for (int iteration = 0; iteration < 30; ++iteration) {
    Eigen::MatrixXd rows(2 * static_cast<Eigen::Index>(points.size()), freedoms);
    Eigen::VectorXd right(rows.rows());
    Eigen::Index row = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!points[i]) continue;
      if (radius_px > 0 && (result.pixel_px[i] - middle).norm() > radius_px) continue;
      const Eigen::Vector3d p = result.b_from_a * *points[i];
      const std::optional<Projection> seen = of_b.project_with_jacobian(p);
      if (!seen) continue;
      Motion motion;
      motion << -seen->d_point * cross_matrix(p), seen->d_point;
      rows.middleRows<2>(row) = motion.leftCols(freedoms);
      right.segment<2>(row) = result.pixel_px[i] - seen->pixel_px;
      row += 2;
    }
    if (row < freedoms) return result;
    Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver;
    solver.setThreshold(1e-9);
    solver.compute(rows.topRows(row));
    const Eigen::VectorXd step = solver.solve(right.head(row));
    Pose move{exp_rotation(step.head<3>()), Eigen::Vector3d::Zero()};
    if (!far) move.translation_m = step.tail<3>();
    result.b_from_a = move * result.b_from_a;
    if (step.norm() < 1e-14) break;
  }
  measure_difference(of_b, points, result);
  return result;
}

}  // namespace cousin
