#include "perception/sfm/self_calibration.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "perception/sfm/track_bundle.h"
#include "sim/config/limits.h"

namespace cousin {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

struct Spread {
  Vector3d mean = Vector3d::Zero();
  Matrix3d squares = Matrix3d::Zero();  ///< mean of the outer products about the mean
};
Spread spread_of(const std::vector<Vector3d>& points) {
  Spread spread;
  const auto n = static_cast<double>(points.size());
  for (const Vector3d& point : points) spread.mean += point / n;
  for (const Vector3d& point : points)
    spread.squares += (point - spread.mean) * (point - spread.mean).transpose() / n;
  return spread;
}

Vector3d axis_of(const Pose& camera_from_world) {
  return camera_from_world.rotation.conjugate() * Vector3d::UnitZ();
}

double angle_between(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Largest angle between two rays, of each point; in one pass over the sightings.
std::vector<double> parallaxes(const BundleAdjustmentInput& input) {
  std::vector<std::vector<Vector3d>> rays(input.points_in_world_m.size());
  for (const BundleObservation& seen : input.observations) {
    const Vector3d centre =
        centre_in_world_m(input.camera_from_world.at(static_cast<std::size_t>(seen.image)));
    const auto point = static_cast<std::size_t>(seen.point);
    rays.at(point).push_back((input.points_in_world_m[point] - centre).normalized());
  }
  std::vector<double> result;
  for (const std::vector<Vector3d>& own : rays) {
    double widest = 0;
    for (std::size_t a = 0; a < own.size(); ++a) {
      for (std::size_t b = a + 1; b < own.size(); ++b)
        widest = std::max(widest, angle_between(own[a], own[b]));
    }
    if (own.size() > 1) result.push_back(widest);
  }
  return result;
}

/// RMS angle of unit vectors to their mean direction; pi/2 if they have none.
double spread_rad(const std::vector<Vector3d>& directions) {
  Vector3d sum = Vector3d::Zero();
  for (const Vector3d& direction : directions) sum += direction;
  if (sum.norm() < 1e-9) return M_PI / 2;
  double squares = 0;
  for (const Vector3d& direction : directions)
    squares += std::pow(angle_between(direction, sum.normalized()), 2);
  return std::sqrt(squares / static_cast<double>(directions.size()));
}

/// RMS turn of the images about their lines of sight. Upright images of any tilt have their x axes
/// in one plane, whose normal is the up direction: turns are against that, from their mean on the
/// circle. Images in one vertical plane have the same x axis, and no such plane: their turns are at
/// most what their x axes part by.
double roll_spread_rad(const BundleAdjustmentInput& input) {
  Matrix3d squares = Matrix3d::Zero();
  std::vector<Vector3d> x_axes;
  for (const Pose& pose : input.camera_from_world) {
    x_axes.push_back(pose.rotation.conjugate() * Vector3d::UnitX());
    squares += x_axes.back() * x_axes.back().transpose();
  }
  const Vector3d up = Eigen::SelfAdjointEigenSolver<Matrix3d>(squares).eigenvectors().col(0);
  std::vector<double> turns;
  double sine = 0, cosine = 0;
  for (const Pose& pose : input.camera_from_world) {
    const Vector3d in_camera = pose.rotation * up;
    if (in_camera.head<2>().norm() < 0.05) continue;  // looks along it: no turn to speak of
    turns.push_back(std::atan2(in_camera.x(), -in_camera.y()));
    sine += std::sin(turns.back());
    cosine += std::cos(turns.back());
  }
  const double mean = std::atan2(sine, cosine);
  double sum = 0;
  for (const double turn : turns) {
    const double off = std::remainder(turn - mean, 2 * M_PI);
    sum += off * off / static_cast<double>(turns.size());
  }
  return std::min(std::sqrt(sum), spread_rad(x_axes));
}

std::vector<CalibrationWeakness> weaknesses_of(const ViewGeometry& geometry,
                                               const SelfCalibrationConfig& config) {
  std::vector<CalibrationWeakness> result;
  const auto add = [&](bool holds, CalibrationWeakness weakness) {
    if (holds) result.push_back(weakness);
  };
  add(geometry.flatness < config.min_flatness, CalibrationWeakness::flat_scene);
  add(geometry.axes_rad < config.min_axes_rad, CalibrationWeakness::parallel_views);
  add(geometry.forward > config.max_forward, CalibrationWeakness::forward_motion);
  add(geometry.parallax_rad < config.min_parallax_rad, CalibrationWeakness::little_parallax);
  add(geometry.roll_rad < config.min_roll_rad, CalibrationWeakness::no_roll);
  return result;
}

std::string joined_reason(const BundleAdjustmentResult& bundle, const SelfCalibration& result) {
  std::string text = bundle.reason;
  const char* between = ": ";
  for (const std::string& name : result.not_determined) {
    text += between + name;
    between = ", ";
  }
  between = " (";
  for (const CalibrationWeakness weakness : result.weaknesses) {
    text += between + std::string(to_string(weakness));
    between = ", ";
  }
  return result.weaknesses.empty() ? text : text + ")";
}

}  // namespace

std::string_view to_string(CalibrationWeakness weakness) {
  switch (weakness) {
    case CalibrationWeakness::flat_scene:
      return "flat_scene";
    case CalibrationWeakness::parallel_views:
      return "parallel_views";
    case CalibrationWeakness::forward_motion:
      return "forward_motion";
    case CalibrationWeakness::little_parallax:
      return "little_parallax";
    case CalibrationWeakness::no_roll:
      return "no_roll";
  }
  throw std::invalid_argument("weakness " + std::to_string(static_cast<int>(weakness)) +
                              " does not exist");
}

ViewGeometry view_geometry(const BundleAdjustmentInput& input) {
  ViewGeometry geometry;
  std::vector<Vector3d> points, centres;
  for (const Vector3d& point : input.points_in_world_m) {
    if (point.allFinite()) points.push_back(point);
  }
  Vector3d axes = Vector3d::Zero();
  for (const Pose& pose : input.camera_from_world) {
    centres.push_back(centre_in_world_m(pose));
    axes += axis_of(pose);
  }
  if (points.empty() || centres.empty()) return geometry;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> scene(spread_of(points).squares);
  const Vector3d sizes = scene.eigenvalues().cwiseMax(0).cwiseSqrt();
  geometry.flatness = sizes.y() > 0 ? sizes.x() / sizes.y() : 0;
  const Vector3d mean_axis = axes.norm() > 0 ? axes.normalized() : Vector3d::UnitZ();
  double squares = 0;
  for (const Pose& pose : input.camera_from_world) {
    const double angle = angle_between(axis_of(pose), mean_axis);
    squares += angle * angle / static_cast<double>(centres.size());
  }
  geometry.axes_rad = std::sqrt(squares);
  const Matrix3d cameras = spread_of(centres).squares;
  if (cameras.trace() > 0)
    geometry.forward = std::sqrt(mean_axis.dot(cameras * mean_axis) / cameras.trace());
  geometry.parallax_rad = median(parallaxes(input));
  geometry.roll_rad = roll_spread_rad(input);
  return geometry;
}

Fields fields(SelfCalibrationConfig& config) {
  return nested("adjust", fields(config.adjust)) +
         Fields{{"min_flatness", &config.min_flatness, "thinner scenes are flat_scene", 0, 1},
                {"min_axes_rad", &config.min_axes_rad, "axes that spread less are parallel_views",
                 0, 3.2},
                {"max_forward", &config.max_forward, "more along the axis is forward_motion", 0, 1},
                {"min_parallax_rad", &config.min_parallax_rad, "less is little_parallax", 0, 3.2},
                {"min_roll_rad", &config.min_roll_rad, "less is no_roll", 0, 3.2}};
}

void validate(const SelfCalibrationConfig& config) {
  SelfCalibrationConfig copy = config;  // fields point into what they describe
  check_limits(fields(copy));
}

SelfCalibration self_calibrate(const BundleAdjustmentInput& input,
                               const SelfCalibrationConfig& config) {
  validate(config);
  SelfCalibration result;
  const BundleAdjustmentResult bundle = adjust_bundle(input, config.adjust);
  result.status = bundle.status;
  result.sigma_px = bundle.sigma_px;
  for (const std::string& name : bundle.not_determined)
    result.not_determined.push_back(name.substr(name.find('.') + 1));
  if (bundle.lenses.empty()) {
    result.reason = bundle.reason;
    return result;
  }
  BundleAdjustmentInput adjusted = input;
  adjusted.camera_from_world = bundle.camera_from_world;
  for (std::size_t p = 0; p < adjusted.points_in_world_m.size(); ++p)
    adjusted.points_in_world_m[p] = bundle.points_in_world_m[p];
  adjusted.observations.clear();
  for (std::size_t i = 0; i < input.observations.size(); ++i) {
    const auto point = static_cast<std::size_t>(input.observations[i].point);
    if (!bundle.rejected[i] && bundle.points_in_world_m[point].allFinite())
      adjusted.observations.push_back(input.observations[i]);
  }
  result.observations = static_cast<int>(adjusted.observations.size());
  result.geometry = view_geometry(adjusted);
  result.weaknesses = weaknesses_of(result.geometry, config);
  result.lens = bundle.lenses.front();
  for (const std::string& name : bundle.parameters)
    result.parameters.push_back(name.substr(name.find('.') + 1));
  result.values = bundle.values;
  result.covariance = bundle.covariance;
  result.deviations =
      Eigen::VectorXd::Constant(bundle.values.size(), std::numeric_limits<double>::quiet_NaN());
  if (bundle.covariance.size() > 0) result.deviations = bundle.covariance.diagonal().cwiseSqrt();
  if (result.status != CalibrationStatus::ok) result.reason = joined_reason(bundle, result);
  return result;
}

SelfCalibration self_calibrate(const SfmModel& model, const std::optional<Camera>& start,
                               const SelfCalibrationConfig& config) {
  return self_calibrate(track_bundle(model, start, 1), config);
}

double deviation(const SelfCalibration& result, std::string_view name) {
  const auto found = std::find(result.parameters.begin(), result.parameters.end(), name);
  if (found == result.parameters.end()) return std::numeric_limits<double>::quiet_NaN();
  return result.deviations[found - result.parameters.begin()];
}

}  // namespace cousin
