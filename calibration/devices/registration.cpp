#include "calibration/devices/registration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>

#include "calibration/solve/lens_value.h"
#include "calibration/solve/observation_cost.h"
#include "sim/config/limits.h"

namespace cousin {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kRegistrationSigmas = 2;

void check_camera(const CalibrationResult& result, int camera) {
  if (camera < 0 || camera >= static_cast<int>(result.cameras.size()) ||
      result.camera_from_rig.size() != result.cameras.size())
    throw std::invalid_argument("registration: camera " + std::to_string(camera) + " of " +
                                std::to_string(result.cameras.size()) + " does not exist");
}

void check(const DepthRegistration& factory, const CalibrationResult& fresh, int depth_camera,
           int color_camera) {
  check_camera(fresh, depth_camera);
  check_camera(fresh, color_camera);
  const auto n = static_cast<Eigen::Index>(fresh.parameters.size());
  if (n == 0 || fresh.covariance.rows() != n || !fresh.covariance.allFinite())
    throw std::invalid_argument("registration: the fresh calibration has no covariance");
  const Camera& depth = fresh.cameras[static_cast<std::size_t>(depth_camera)];
  if (depth.width_px != factory.depth.width_px || depth.height_px != factory.depth.height_px)
    throw std::invalid_argument(
        "registration: the factory's depth image is of " + std::to_string(factory.depth.width_px) +
        " x " + std::to_string(factory.depth.height_px) + " pixels, the fresh one's of " +
        std::to_string(depth.width_px) + " x " + std::to_string(depth.height_px));
}

/// The result with one of its parameters changed: lenses that share it change together.
CalibrationResult changed(const CalibrationResult& result, std::size_t parameter, double by) {
  CalibrationResult other;
  other.cameras = result.cameras;
  other.camera_from_rig = result.camera_from_rig;
  const std::string& name = result.parameters[parameter];
  const std::size_t dot = name.find('.');
  if (dot == std::string::npos) return other;  // of the board
  const auto owner = static_cast<std::size_t>(std::stoi(name.substr(6, dot - 6)));
  const std::string what = name.substr(dot + 1);
  static constexpr std::array<std::string_view, 6> kPlace = {"r_x", "r_y", "r_z",
                                                             "t_x", "t_y", "t_z"};
  const auto place = std::find(kPlace.begin(), kPlace.end(), what);
  if (place != kPlace.end()) {
    Vector6d pose = pose_vector(result.camera_from_rig[owner]);
    pose(place - kPlace.begin()) += by;
    other.camera_from_rig[owner] = pose_of_vector(pose);
    return other;
  }
  const std::vector<std::string> names = lens_parameter_names(shape_of(result.cameras[owner]));
  const auto at = std::find(names.begin(), names.end(), what);
  if (at == names.end()) return other;
  for (std::size_t c = owner; c < result.cameras.size(); ++c) {
    if (!(result.cameras[c] == result.cameras[owner])) continue;
    const bool own =
        c > owner && parameter_index(result, "camera" + std::to_string(c) + "." + what) >= 0;
    if (own) continue;
    Eigen::VectorXd values = lens_parameters(result.cameras[c]);
    values(at - names.begin()) += by;
    other.cameras[c] = with_parameters(result.cameras[c], values);
  }
  return other;
}

/// Registration with its lenses made ready.
struct ReadyRegistration {
  Lens depth, color;
  Pose color_from_depth;
  explicit ReadyRegistration(const DepthRegistration& r)
      : depth(r.depth), color(r.color), color_from_depth(r.color_from_depth) {}

  Eigen::Vector2d operator()(const Eigen::Vector2d& depth_px, double depth_m) const {
    const std::optional<Eigen::Vector3d> ray = depth.unproject(depth_px);
    if (!ray || !(ray->z() > 0)) return {kNan, kNan};
    const auto seen = color.project(color_from_depth * (depth_m / ray->z() * *ray));
    return seen ? *seen : Eigen::Vector2d(kNan, kNan);
  }
};

/// Derivative of the fresh registration's pixels by a calibration's parameters over its deviations,
/// by central differences of a tenth of one: two rows a pixel, NaN where there is none.
Eigen::MatrixXd sensitivity(const CalibrationResult& fresh, int depth_camera, int color_camera,
                            const std::vector<Eigen::Vector2d>& pixels, double distance_m) {
  constexpr double kStep = 0.1;
  const auto n = static_cast<Eigen::Index>(fresh.parameters.size());
  Eigen::MatrixXd g(2 * static_cast<Eigen::Index>(pixels.size()), n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const double sigma = std::sqrt(std::max(0.0, fresh.covariance(k, k)));
    const auto at = [&](double by) {
      return ReadyRegistration(registration_of(
          changed(fresh, static_cast<std::size_t>(k), by * sigma), depth_camera, color_camera));
    };
    const ReadyRegistration ahead = at(kStep), behind = at(-kStep);
    for (std::size_t i = 0; i < pixels.size(); ++i)
      g.block<2, 1>(2 * static_cast<Eigen::Index>(i), k) =
          (ahead(pixels[i], distance_m) - behind(pixels[i], distance_m)) / (2 * kStep);
  }
  return g;
}

/// Correlation matrix: the covariance over its deviations.
Eigen::MatrixXd correlation(const Eigen::MatrixXd& covariance) {
  Eigen::VectorXd scale = covariance.diagonal().cwiseMax(0).cwiseSqrt();
  for (Eigen::Index i = 0; i < scale.size(); ++i) scale(i) = scale(i) > 0 ? 1 / scale(i) : 0;
  return scale.asDiagonal() * covariance * scale.asDiagonal();
}

/// Of all pixels that both registrations have: moments of the difference's square.
void judge(const Eigen::MatrixXd& g, const Eigen::MatrixXd& correlations,
           const Eigen::VectorXd& difference, const RegistrationConfig& config,
           RegistrationDifference& result) {
  const double count = static_cast<double>(difference.size()) / 2;
  if (!(count > 0)) return;
  const double square = difference.squaredNorm() / count;
  // d ~ N(mu, S), S = G C G': E d'd = mu'mu + tr S, Var d'd = 2 tr S^2 + 4 mu'S mu.
  const Eigen::MatrixXd gram_c = (g.transpose() * g) * correlations;
  const double fresh = gram_c.trace() / count;
  const double squared_trace = (gram_c * gram_c).trace();
  const Eigen::VectorXd pulled = g.transpose() * difference;
  const double along = std::max(0.0, pulled.dot(correlations * pulled) - squared_trace);
  const double sigma = std::sqrt(2 * squared_trace + 4 * along) / count;
  const double factory = square - fresh;
  result.rms_px = std::sqrt(square);
  result.fresh_rms_px = std::sqrt(fresh);
  result.factory_rms_px = std::sqrt(std::max(0.0, factory));
  result.factory_square_sigma_px2 = sigma;
  const double bar = std::max(fresh, config.least_gain_px * config.least_gain_px);
  result.verdict = factory - kRegistrationSigmas * sigma > bar   ? RegistrationVerdict::replace
                   : factory + kRegistrationSigmas * sigma < bar ? RegistrationVerdict::keep
                                                                 : RegistrationVerdict::cannot_tell;
}

}  // namespace

std::string_view to_string(RegistrationVerdict verdict) {
  constexpr std::array<std::string_view, 3> kNames = {"keep", "replace", "cannot_tell"};
  return kNames.at(static_cast<std::size_t>(verdict));
}

Fields fields(RegistrationConfig& config) {
  return {
      {"distance_m", &config.distance_m, "working distance of the depth camera", 1e-3, 1e3},
      {"columns", &config.columns, "of depth pixels that are compared", 2, 1000},
      {"rows", &config.rows, "the same", 2, 1000},
      {"least_gain_px", &config.least_gain_px, "of error that is worth a new calibration", 0, 1e3},
  };
}

void validate(const RegistrationConfig& config) {
  RegistrationConfig copy = config;  // fields point into what they describe
  check_limits(fields(copy), "registration");
}

DepthRegistration registration_of(const CalibrationResult& result, int depth_camera,
                                  int color_camera) {
  check_camera(result, depth_camera);
  check_camera(result, color_camera);
  const auto d = static_cast<std::size_t>(depth_camera), c = static_cast<std::size_t>(color_camera);
  return {result.cameras[d], result.cameras[c],
          result.camera_from_rig[c] * inverse(result.camera_from_rig[d])};
}

Eigen::Vector2d registered_px(const DepthRegistration& registration,
                              const Eigen::Vector2d& depth_px, double depth_m) {
  return ReadyRegistration(registration)(depth_px, depth_m);
}

RegistrationDifference registration_difference(const DepthRegistration& factory,
                                               const CalibrationResult& fresh, int depth_camera,
                                               int color_camera, const RegistrationConfig& config) {
  validate(config);
  check(factory, fresh, depth_camera, color_camera);
  RegistrationDifference result;
  result.columns = config.columns;
  result.rows = config.rows;
  for (int y = 0; y < config.rows; ++y) {
    for (int x = 0; x < config.columns; ++x)
      result.depth_px.emplace_back(x * (factory.depth.width_px - 1.0) / (config.columns - 1),
                                   y * (factory.depth.height_px - 1.0) / (config.rows - 1));
  }
  const ReadyRegistration old(factory), made(registration_of(fresh, depth_camera, color_camera));
  const Eigen::MatrixXd g =
      sensitivity(fresh, depth_camera, color_camera, result.depth_px, config.distance_m);
  const Eigen::MatrixXd correlations = correlation(fresh.covariance);
  Eigen::MatrixXd counted(g.rows(), g.cols());
  Eigen::VectorXd differences(g.rows());
  Eigen::Index rows = 0;
  result.max_px = 0;
  for (std::size_t i = 0; i < result.depth_px.size(); ++i) {
    const Eigen::MatrixXd here = g.middleRows<2>(2 * static_cast<Eigen::Index>(i));
    Eigen::Vector2d d =
        old(result.depth_px[i], config.distance_m) - made(result.depth_px[i], config.distance_m);
    const bool has = d.allFinite() && here.allFinite();
    if (!has) d.setConstant(kNan);
    result.difference_px.push_back(d);
    result.covariance_px2.emplace_back(has ? Eigen::Matrix2d(here * correlations * here.transpose())
                                           : Eigen::Matrix2d(Eigen::Matrix2d::Constant(kNan)));
    if (!has) continue;
    counted.middleRows<2>(rows) = here;
    differences.segment<2>(rows) = d;
    rows += 2;
    result.max_px = std::max(result.max_px, d.norm());
  }
  if (rows == 0) result.max_px = kNan;
  judge(counted.topRows(rows), correlations, differences.head(rows), config, result);
  return result;
}

}  // namespace cousin
