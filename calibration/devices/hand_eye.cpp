#include "calibration/devices/hand_eye.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <optional>
#include <sstream>

#include "calibration/boards/planar_pose.h"
#include "calibration/solve/observation_cost.h"
#include "sim/config/limits.h"

namespace cousin {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// A stop whose view gave a pose.
struct Seen {
  Pose base_from_gripper;
  Pose camera_from_target;
  const TargetView* view = nullptr;
};

Vector6d log_of(const Pose& pose) { return pose_vector(pose); }

Pose exp_of(const Vector6d& twist) { return {exp_rotation(twist.head<3>()), twist.tail<3>()}; }

/// Takes a small motion (rotation, translation) in b to the same motion in a.
Matrix6d adjoint(const Pose& a_from_b) {
  const Eigen::Matrix3d r = a_from_b.rotation.toRotationMatrix();
  Matrix6d m = Matrix6d::Zero();
  m.topLeftCorner<3, 3>() = m.bottomRightCorner<3, 3>() = r;
  m.bottomLeftCorner<3, 3>() = cross_matrix(a_from_b.translation_m) * r;
  return m;
}

/// What the arm's turns leave open; empty if nothing.
std::string open_motion(const std::vector<Seen>& stops, const HandEyeConfig& config,
                        HandEyeResult& result) {
  Eigen::Matrix3d turns = Eigen::Matrix3d::Zero();
  int pairs = 0;
  for (std::size_t i = 0; i < stops.size(); ++i) {
    for (std::size_t j = i + 1; j < stops.size(); ++j, ++pairs) {
      const Pose motion = inverse(stops[i].base_from_gripper) * stops[j].base_from_gripper;
      const Eigen::Vector3d turn = log_of(motion).head<3>();
      turns += turn * turn.transpose();
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(turns / std::max(1, pairs));
  const double first = std::sqrt(std::max(0.0, axes.eigenvalues()(2)));
  const double second = std::sqrt(std::max(0.0, axes.eigenvalues()(1)));
  std::ostringstream text;
  if (first < config.least_turn_rad) {
    result.not_determined = {"translation"};
    text << "the arm only translates: its turns are " << first << " rad (at least "
         << config.least_turn_rad << ")";
  } else if (second < config.least_turn_rad) {
    const Eigen::Vector3d axis = axes.eigenvectors().col(2);
    text << "(" << axis.x() << ", " << axis.y() << ", " << axis.z() << ")";
    result.not_determined = {"translation along " + text.str()};
    text << " is the axis of all turns: about a second one they are " << second << " rad (at least "
         << config.least_turn_rad << ")";
  }
  return text.str();
}

cv::Mat rotation_of(const Pose& pose) {
  const Eigen::Matrix3d r = pose.rotation.toRotationMatrix();
  cv::Mat m(3, 3, CV_64F);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) m.at<double>(i, j) = r(i, j);
  }
  return m;
}

cv::Mat translation_of(const Pose& pose) {
  return (cv::Mat_<double>(3, 1) << pose.translation_m.x(), pose.translation_m.y(),
          pose.translation_m.z());
}

Pose closed_form(const std::vector<Seen>& stops) {
  std::vector<cv::Mat> arm_r, arm_t, target_r, target_t;
  for (const Seen& s : stops) {
    arm_r.push_back(rotation_of(s.base_from_gripper));
    arm_t.push_back(translation_of(s.base_from_gripper));
    target_r.push_back(rotation_of(s.camera_from_target));
    target_t.push_back(translation_of(s.camera_from_target));
  }
  cv::Mat r, t;
  cv::calibrateHandEye(arm_r, arm_t, target_r, target_t, r, t, cv::CALIB_HAND_EYE_PARK);
  Eigen::Matrix3d rotation;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) rotation(i, j) = r.at<double>(i, j);
  }
  return {Eigen::Quaterniond(rotation).normalized(),
          {t.at<double>(0), t.at<double>(1), t.at<double>(2)}};
}

struct HandEyeState {
  Pose camera_from_gripper, base_from_target;
  std::vector<Pose> gripper_from_base;  ///< true ones, of each stop
};

/// Normal equations with the stops' arm poses eliminated: first the camera on the gripper, then the
/// target in the base.
struct HandEyeSystem {
  Eigen::Matrix<double, 12, 12> normal = Eigen::Matrix<double, 12, 12>::Zero();
  Eigen::Matrix<double, 12, 1> right = Eigen::Matrix<double, 12, 1>::Zero();
  std::vector<Eigen::Matrix<double, 6, 12>> gain;  ///< of the arm's correction
  std::vector<Vector6d> own;
  double cost = 0, squares_px2 = 0, squares_m2 = 0;
  int coordinates = 0;
};

std::optional<HandEyeSystem> linearise(const HandEyeInput& input, const std::vector<Seen>& stops,
                                       const HandEyeState& state, const HandEyeConfig& config,
                                       double damping) {
  HandEyeSystem system;
  const Lens lens(input.camera);
  Vector6d arm_weight;
  arm_weight << Eigen::Vector3d::Constant(1 / (config.arm_rad * config.arm_rad)),
      Eigen::Vector3d::Constant(1 / (config.arm_m * config.arm_m));
  for (std::size_t s = 0; s < stops.size(); ++s) {
    const Pose& c = state.camera_from_gripper;
    const Pose camera_from_base = c * state.gripper_from_base[s];
    const Pose camera_from_target = camera_from_base * state.base_from_target;
    Eigen::Matrix<double, 6, 12> shared;  // of the twist of camera_from_target
    shared << Matrix6d::Identity(), adjoint(camera_from_base);
    const Matrix6d arm = adjoint(c);
    Matrix6d twist = Matrix6d::Zero();
    Vector6d pull = Vector6d::Zero();
    for (const TargetObservation& p : stops[s].view->points) {
      const Eigen::Vector3d x = camera_from_target * input.target_m[static_cast<std::size_t>(p.id)];
      const std::optional<Projection> seen = lens.project_with_jacobian(x);
      if (!seen) return std::nullopt;
      Eigen::Matrix<double, 2, 6> j;
      j << -seen->d_point * cross_matrix(x), seen->d_point;
      const Eigen::Vector2d r = (p.pixel_px - seen->pixel_px) / config.corner_px;
      j /= config.corner_px;
      twist += j.transpose() * j;
      pull += j.transpose() * r;
      system.cost += r.squaredNorm();
      system.squares_px2 += r.squaredNorm() * config.corner_px * config.corner_px;
      system.coordinates += 2;
    }
    // The arm's own report: gripper_from_base of the state, seen from the reported one.
    const Vector6d off = log_of(state.gripper_from_base[s] * stops[s].base_from_gripper);
    system.cost += off.cwiseAbs2().dot(arm_weight);
    system.squares_m2 += off.tail<3>().squaredNorm();
    Matrix6d own = arm.transpose() * twist * arm;
    own.diagonal() += arm_weight;
    own.diagonal() *= 1 + damping;
    const Vector6d own_right = arm.transpose() * pull - arm_weight.cwiseProduct(off);
    const Eigen::Matrix<double, 6, 12> mixed = arm.transpose() * twist * shared;
    const Eigen::LDLT<Matrix6d> factor(own);
    system.gain.emplace_back(factor.solve(mixed));
    system.own.emplace_back(factor.solve(own_right));
    system.normal += shared.transpose() * twist * shared - mixed.transpose() * system.gain.back();
    system.right += shared.transpose() * pull - mixed.transpose() * system.own.back();
  }
  return system;
}

HandEyeState moved(const HandEyeState& state, const HandEyeSystem& system,
                   const Eigen::Matrix<double, 12, 1>& step) {
  HandEyeState next;
  next.camera_from_gripper = exp_of(step.head<6>()) * state.camera_from_gripper;
  next.base_from_target = exp_of(step.tail<6>()) * state.base_from_target;
  for (std::size_t s = 0; s < state.gripper_from_base.size(); ++s)
    next.gripper_from_base.push_back(exp_of(system.own[s] - system.gain[s] * step) *
                                     state.gripper_from_base[s]);
  return next;
}

/// Levenberg-Marquardt. @return whether it converged
bool refine(const HandEyeInput& input, const std::vector<Seen>& stops, const HandEyeConfig& config,
            HandEyeState& state) {
  double damping = 1e-6;
  std::optional<HandEyeSystem> system = linearise(input, stops, state, config, 0);
  for (int i = 0; system && i < config.max_iterations; ++i) {
    const double cost = system->cost;
    const std::optional<HandEyeSystem> damped = linearise(input, stops, state, config, damping);
    Eigen::Matrix<double, 12, 12> normal = damped->normal;
    normal.diagonal() *= 1 + damping;
    const Eigen::Matrix<double, 12, 1> step = normal.ldlt().solve(damped->right);
    const HandEyeState next = moved(state, *damped, step);
    const std::optional<HandEyeSystem> after = linearise(input, stops, next, config, 0);
    if (after && after->cost <= cost) {
      state = next;
      system = after;
      damping = std::max(damping / 10, 1e-12);
      if (cost - after->cost <= 1e-12 * cost || step.norm() < 1e-13) return true;
    } else {
      damping *= 10;
      if (damping > 1e12) return true;  // no step helps: the minimum to rounding
    }
  }
  return false;
}

void describe(const HandEyeInput& input, const std::vector<Seen>& stops,
              const HandEyeConfig& config, const HandEyeState& state, HandEyeResult& result) {
  const std::optional<HandEyeSystem> system = linearise(input, stops, state, config, 0);
  result.gripper_from_camera = inverse(state.camera_from_gripper);
  result.base_from_target = state.base_from_target;
  result.rms_px = std::sqrt(system->squares_px2 / system->coordinates);
  result.arm_rms_m = std::sqrt(system->squares_m2 / (3.0 * static_cast<double>(stops.size())));
  const double variance = std::max(1.0, system->cost / std::max(1, system->coordinates - 12));
  const Eigen::Matrix<double, 12, 12> covariance =
      variance * system->normal.ldlt().solve(Eigen::Matrix<double, 12, 12>::Identity());
  const Matrix6d to_gripper = adjoint(result.gripper_from_camera);
  result.covariance = to_gripper * covariance.topLeftCorner<6, 6>() * to_gripper.transpose();
  const double turn = std::sqrt(result.covariance.diagonal().head<3>().maxCoeff());
  const double place = std::sqrt(result.covariance.diagonal().tail<3>().maxCoeff());
  std::ostringstream text;
  if (!(turn <= config.max_deviation_rad)) {
    result.not_determined.push_back("rotation");
    text << "rotation has a deviation of " << turn << " rad (at most " << config.max_deviation_rad
         << "); ";
  }
  if (!(place <= config.max_deviation_m)) {
    result.not_determined.push_back("translation");
    text << "translation has a deviation of " << place << " (at most " << config.max_deviation_m
         << ")";
  }
  if (result.not_determined.empty()) return;
  result.status = CalibrationStatus::not_determined;
  result.reason = text.str();
}

}  // namespace

Fields fields(HandEyeConfig& config) {
  return {
      {"corner_px", &config.corner_px, "deviation of a corner's coordinate", 1e-6, 100},
      {"arm_m", &config.arm_m, "deviation of each coordinate of the arm's position", 1e-9, 1},
      {"arm_rad", &config.arm_rad, "deviation of the arm's rotation about each axis", 1e-9, 1},
      {"least_turn_rad", &config.least_turn_rad,
       "RMS turn about a second axis below which motions are refused", 1e-6, 3},
      {"max_deviation_m", &config.max_deviation_m, "of the camera's place on the gripper", 1e-9,
       10},
      {"max_deviation_rad", &config.max_deviation_rad, "of the camera's rotation", 1e-9, 3},
      {"max_iterations", &config.max_iterations, "of the refinement", 1, 10000},
  };
}

void validate(const HandEyeConfig& config) {
  HandEyeConfig copy = config;
  check_limits(fields(copy));
}

HandEyeResult calibrate_hand_eye(const HandEyeInput& input, const HandEyeConfig& config) {
  validate(config);
  HandEyeResult result;
  std::vector<Seen> stops;
  for (std::size_t i = 0; i < input.stops.size(); ++i) {
    const HandEyeInput::Stop& stop = input.stops[i];
    if (!is_usable(stop.view)) continue;
    std::vector<BoardPoint> points;
    for (const TargetObservation& p : stop.view.points) {
      if (p.id < 0 || p.id >= static_cast<int>(input.target_m.size())) {
        result.status = CalibrationStatus::bad_input;
        result.reason = "stop " + std::to_string(i) + ": point " + std::to_string(p.id) +
                        " is not one of the target's " + std::to_string(input.target_m.size());
        return result;
      }
      points.push_back({input.target_m[static_cast<std::size_t>(p.id)], p.pixel_px});
    }
    const PlanarPose pose = estimate_planar_pose(input.camera, points);
    if (pose.ok) stops.push_back({stop.base_from_gripper, pose.camera_from_board, &stop.view});
  }
  result.stops = static_cast<int>(stops.size());
  if (stops.size() < 3) {
    result.status = CalibrationStatus::not_determined;
    result.not_determined = {"rotation", "translation"};
    result.reason = std::to_string(stops.size()) + " stops with a pose, at least 3 are needed";
    return result;
  }
  result.reason = open_motion(stops, config, result);
  if (!result.reason.empty()) {
    result.status = CalibrationStatus::not_determined;
    return result;
  }
  HandEyeState state;
  const Pose start = closed_form(stops);
  state.camera_from_gripper = inverse(start);
  state.base_from_target =
      stops.front().base_from_gripper * start * stops.front().camera_from_target;
  for (const Seen& s : stops) state.gripper_from_base.push_back(inverse(s.base_from_gripper));
  if (!refine(input, stops, config, state)) {
    result.reason = "the refinement did not converge";
    return result;
  }
  result.status = CalibrationStatus::ok;
  describe(input, stops, config, state, result);
  return result;
}

}  // namespace cousin
