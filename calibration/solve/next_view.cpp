#include "calibration/solve/next_view.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "calibration/boards/planar_pose.h"
#include "calibration/solve/lens_value.h"
#include "sim/types/pi.h"

namespace cousin {
namespace {

/// The lens and which of its parameters are free, by their number among all of them.
struct FreeParameters {
  LensShape shape;
  Eigen::VectorXd values;  ///< of all
  std::vector<int> columns;
  Eigen::MatrixXd information;
};

std::optional<FreeParameters> free_parameters(const CalibrationResult& result, int camera) {
  const Camera& lens = result.cameras[static_cast<std::size_t>(camera)];
  FreeParameters free;
  free.shape = shape_of(lens);
  free.values = lens_parameters(lens);
  const std::vector<std::string> names = lens_parameter_names(free.shape);
  std::vector<int> at;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const int index = parameter_index(result, "camera" + std::to_string(camera) + "." + names[i]);
    if (index < 0) continue;
    free.columns.push_back(static_cast<int>(i));
    at.push_back(index);
  }
  const auto n = static_cast<Eigen::Index>(at.size());
  if (n == 0 || result.covariance.rows() == 0) return std::nullopt;
  Eigen::MatrixXd covariance(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j)
      covariance(i, j) =
          result.covariance(at[static_cast<std::size_t>(i)], at[static_cast<std::size_t>(j)]);
  }
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(covariance);
  if (!covariance.allFinite() || ldlt.info() != Eigen::Success || !ldlt.isPositive())
    return std::nullopt;
  free.information = ldlt.solve(Eigen::MatrixXd::Identity(n, n));
  return free.information.allFinite() ? std::optional(free) : std::nullopt;
}

/// d(pixel)/d(free lens parameters) of a point in the camera; nothing if it has no pixel.
std::optional<Eigen::MatrixXd> lens_columns(const FreeParameters& free,
                                            const Eigen::Vector3d& point) {
  RowMatrix all(2, free.values.size());
  LensValue value;
  if (!lens_value(free.shape, free.values.data(), point, value, all.data())) return std::nullopt;
  Eigen::MatrixXd some(2, static_cast<Eigen::Index>(free.columns.size()));
  for (std::size_t i = 0; i < free.columns.size(); ++i)
    some.col(static_cast<Eigen::Index>(i)) = all.col(free.columns[i]);
  return some;
}

/// M with trace(M covariance) = mean variance of the projection over the image, what a rotation
/// can take up left out.
Eigen::MatrixXd projection_weight(const Camera& camera, const FreeParameters& free,
                                  double reach_px) {
  constexpr int kColumns = 13, kRows = 10;
  const Lens lens(camera);
  std::vector<Eigen::MatrixXd> lens_parts;
  std::vector<Eigen::Matrix<double, 2, 3>> turn_parts;
  for (int r = 0; r < kRows; ++r) {
    for (int c = 0; c < kColumns; ++c) {
      const Eigen::Vector2d pixel(c * (camera.width_px - 1.0) / (kColumns - 1),
                                  r * (camera.height_px - 1.0) / (kRows - 1));
      if ((pixel - Eigen::Vector2d(camera.cx_px, camera.cy_px)).norm() > reach_px) continue;
      const auto ray = lens.unproject(pixel);
      if (!ray) continue;
      const auto projection = lens.project_with_jacobian(*ray);
      if (!projection) continue;
      const auto columns = lens_columns(free, *ray);
      if (!columns) continue;
      lens_parts.push_back(*columns);
      turn_parts.push_back(-projection->d_point * cross_matrix(*ray));
    }
  }
  const auto count = static_cast<Eigen::Index>(lens_parts.size());
  const auto n = static_cast<Eigen::Index>(free.columns.size());
  Eigen::MatrixXd g(2 * count, n), turn(2 * count, 3);
  for (Eigen::Index i = 0; i < count; ++i) {
    g.middleRows(2 * i, 2) = lens_parts[static_cast<std::size_t>(i)];
    turn.middleRows(2 * i, 2) = turn_parts[static_cast<std::size_t>(i)];
  }
  const Eigen::MatrixXd fit = (turn.transpose() * turn).ldlt().solve(turn.transpose() * g);
  g -= turn * fit;
  return g.transpose() * g / static_cast<double>(std::max<Eigen::Index>(1, count));
}

/// Whether the whole print is in the picture: its points and, about them, half as much again as a
/// board has beyond its outer ones.
bool is_inside(const Camera& camera, const Lens& lens, const Pose& camera_from_target,
               const std::vector<Eigen::Vector3d>& target_m, double reach_px) {
  constexpr double kBeyond = 1.3;
  Eigen::Vector2d half = Eigen::Vector2d::Zero();
  for (const Eigen::Vector3d& p : target_m) half = half.cwiseMax(kBeyond * p.head<2>().cwiseAbs());
  for (const double x : {-1.0, 0.0, 1.0}) {
    for (const double y : {-1.0, 0.0, 1.0}) {
      const auto p =
          lens.project(camera_from_target * Eigen::Vector3d(x * half.x(), y * half.y(), 0));
      if (!p || !(p->minCoeff() > 0) || !(p->x() < camera.width_px - 1) ||
          !(p->y() < camera.height_px - 1) ||
          (*p - Eigen::Vector2d(camera.cx_px, camera.cy_px)).norm() > reach_px)
        return false;
    }
  }
  return true;
}

/// What one view of the target tells of the lens, its pose unknown, for corners of 1 px; nothing if
/// less than all of it is in the picture.
std::optional<Eigen::MatrixXd> view_information(const Camera& camera, const Lens& lens,
                                                const FreeParameters& free,
                                                const Pose& camera_from_target,
                                                const std::vector<Eigen::Vector3d>& target_m) {
  const auto n = static_cast<Eigen::Index>(free.columns.size());
  Eigen::MatrixXd aa = Eigen::MatrixXd::Zero(n, n), ab = Eigen::MatrixXd::Zero(n, 6);
  Eigen::Matrix<double, 6, 6> bb = Eigen::Matrix<double, 6, 6>::Zero();
  for (const Eigen::Vector3d& at_m : target_m) {
    const Eigen::Vector3d p = camera_from_target * at_m;
    const auto seen = lens.project_with_jacobian(p);
    if (!seen || !(seen->pixel_px.minCoeff() > 0) || !(seen->pixel_px.x() < camera.width_px - 1) ||
        !(seen->pixel_px.y() < camera.height_px - 1))
      return std::nullopt;
    const auto columns = lens_columns(free, p);
    if (!columns) return std::nullopt;
    const Eigen::MatrixXd& a = *columns;
    Eigen::Matrix<double, 2, 6> b;
    b << -seen->d_point * cross_matrix(p), seen->d_point;
    aa += a.transpose() * a;
    ab += a.transpose() * b;
    bb += b.transpose() * b;
  }
  return aa - ab * bb.ldlt().solve(ab.transpose());
}

struct ViewCandidate {
  double u, v;      ///< place in the picture, -1..1
  double fill;      ///< of the picture that the target spans
  double tilt_rad;  ///< about an axis in the picture
  double axis_rad;  ///< 0: the top leans away or near; a quarter turn: a side
};

std::vector<ViewCandidate> candidates() {
  std::vector<ViewCandidate> list;
  for (const double fill : {0.35, 0.6, 0.85}) {
    for (const double u : {-1.0, 0.0, 1.0}) {
      for (const double v : {-1.0, 0.0, 1.0}) {
        list.push_back({u, v, fill, 0, 0});
        for (const double tilt : {0.35, 0.6, 0.87}) {
          for (int k = 0; k < 4; ++k) list.push_back({u, v, fill, tilt, 0.5 * kPi * k});
        }
      }
    }
  }
  return list;
}

/// Where the target is then; nothing where the lens has no direction there.
std::optional<Pose> pose_of(const ViewCandidate& c, const Camera& camera, const Lens& lens,
                            const std::vector<Eigen::Vector3d>& target_m) {
  Eigen::Vector2d half = Eigen::Vector2d::Zero();
  for (const Eigen::Vector3d& p : target_m) half = half.cwiseMax(p.head<2>().cwiseAbs());
  // Its middle keeps the whole of it in the picture.
  const double room = 1 - c.fill;
  const Eigen::Vector2d middle(0.5 * (camera.width_px - 1) * (1 + 0.9 * room * c.u),
                               0.5 * (camera.height_px - 1) * (1 + 0.9 * room * c.v));
  const auto ray = lens.unproject(middle);
  if (!ray) return std::nullopt;
  const double distance_m = std::max(2 * half.x() * camera.fx_px / (c.fill * camera.width_px),
                                     2 * half.y() * camera.fy_px / (c.fill * camera.height_px));
  const Eigen::Quaterniond facing(Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX()));
  const Eigen::Quaterniond sight =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), *ray);
  const Eigen::AngleAxisd tilt(c.tilt_rad,
                               Eigen::Vector3d(std::cos(c.axis_rad), std::sin(c.axis_rad), 0));
  return Pose{(sight * tilt * facing).normalized(), distance_m * *ray};
}

std::string words_of(const ViewCandidate& c) {
  const std::string row = c.v < 0 ? "upper" : c.v > 0 ? "lower" : "middle";
  const std::string column = c.u < 0 ? "left" : c.u > 0 ? "right" : "middle";
  std::string words = "the board in the " +
                      (row == column        ? "middle"
                       : row == "middle"    ? column + " middle"
                       : column == "middle" ? row + " middle"
                                            : row + " " + column) +
                      " of the picture, spanning " +
                      std::to_string(static_cast<int>(std::lround(100 * c.fill))) + " % of it, ";
  if (c.tilt_rad == 0) return words + "face on";
  static constexpr std::array<const char*, 4> kSides = {"upper", "left", "lower", "right"};
  // Turned by +t about x (down is y, away is z), what is above comes nearer: sin has y < 0 to z <
  // 0.
  const auto k = static_cast<std::size_t>(std::lround(c.axis_rad / (0.5 * kPi))) % 4;
  return words + "its " + kSides.at(k) + " side tilted towards the camera by " +
         std::to_string(static_cast<int>(std::lround(c.tilt_rad * 180 / kPi))) + " degrees";
}

}  // namespace

std::optional<NextView> best_next_view(const CalibrationResult& result, int camera,
                                       const std::vector<Eigen::Vector3d>& target_m,
                                       double reach_px) {
  if (camera < 0 || camera >= static_cast<int>(result.cameras.size()) || target_m.empty())
    return std::nullopt;
  const Camera& lens = result.cameras[static_cast<std::size_t>(camera)];
  if (!(result.rms_px > 0)) return std::nullopt;
  const auto free = free_parameters(result, camera);
  if (!free) return std::nullopt;
  const Lens ready(lens);
  const Eigen::MatrixXd weight = projection_weight(lens, *free, reach_px);
  const auto rms_px = [&](const Eigen::MatrixXd& information) {
    return std::sqrt(std::max(0.0, information.ldlt().solve(weight).trace()));
  };
  // Weighed residuals have no unit, so that sigma_px is not a corner's deviation in pixels.
  const double per_corner = 1 / (result.rms_px * result.rms_px);
  std::optional<NextView> best;
  const double now_px = rms_px(free->information);
  for (const ViewCandidate& c : candidates()) {
    const auto pose = pose_of(c, lens, ready, target_m);
    if (!pose || !is_inside(lens, ready, *pose, target_m, reach_px)) continue;
    const auto added = view_information(lens, ready, *free, *pose, target_m);
    if (!added) continue;
    const double then_px = rms_px(free->information + per_corner * *added);
    if (!std::isfinite(then_px) || (best && then_px >= best->then_px)) continue;
    best = NextView{*pose, words_of(c), now_px, then_px};
  }
  return best;
}

}  // namespace cousin
