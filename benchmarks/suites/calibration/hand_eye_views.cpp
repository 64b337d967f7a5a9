#include "benchmarks/suites/calibration/hand_eye_views.h"

#include <Eigen/Geometry>

#include "benchmarks/suites/calibration/corner_views.h"
#include "calibration/boards/planar_pose.h"

namespace cousin {

HandEyeViews make_hand_eye_views(const HandEyeViewsConfig& config, const Rng& rng) {
  HandEyeViews views;
  views.input.camera = study_camera(LensModel::opencv5);
  const Lens lens(views.input.camera);
  CornerViewsConfig board;
  board.columns = 9;
  board.rows = 7;
  for (int r = 0; r < board.rows; ++r) {
    for (int c = 0; c < board.columns; ++c)
      views.input.target_m.emplace_back((c - 4) * 0.02, (3 - r) * 0.02, 0);
  }
  views.gripper_from_camera = {
      Eigen::Quaterniond(Eigen::AngleAxisd(0.4, Eigen::Vector3d(0.3, -0.5, 0.8).normalized())),
      {0.04, -0.06, 0.09}};
  const Pose base_from_target{
      Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d(0.1, 0.9, -0.2).normalized())),
      {0.5, 0.1, -0.2}};
  const auto vector = [](Rng& from, double size) {
    const double x = normal(from), y = normal(from), z = normal(from);
    return Eigen::Vector3d(size * x, size * y, size * z);
  };
  for (int s = 0; s < config.stops; ++s) {
    Rng pose = rng.fork("pose").fork(static_cast<std::uint64_t>(s));
    Rng noise = rng.fork("noise").fork(static_cast<std::uint64_t>(s));
    // A wrist that rolls far tells the camera's rotation from the target's.
    const double free = config.motion == ArmMotion::free ? 1 : 0;
    const double turn = config.motion == ArmMotion::translation ? 0 : 1;
    const double tilt_x = free * uniform(pose, -0.8, 0.8), tilt_y = free * uniform(pose, -0.8, 0.8);
    const double roll = turn * uniform(pose, -2.5, 2.5);
    const double x = uniform(pose, -0.03, 0.03), y = uniform(pose, -0.03, 0.03);
    const Eigen::Quaterniond tilt = Eigen::AngleAxisd(tilt_x, Eigen::Vector3d::UnitX()) *
                                    Eigen::AngleAxisd(tilt_y, Eigen::Vector3d::UnitY()) *
                                    Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ()) *
                                    Eigen::Quaterniond(0, 1, 0, 0);
    const Pose camera_from_target{tilt.normalized(), {x, y, uniform(pose, 0.22, 0.35)}};
    const Pose base_from_gripper =
        base_from_target * inverse(camera_from_target) * inverse(views.gripper_from_camera);
    HandEyeInput::Stop stop;
    stop.base_from_gripper.rotation =
        exp_rotation(vector(noise, config.arm_rad)) * base_from_gripper.rotation;
    stop.base_from_gripper.translation_m =
        base_from_gripper.translation_m + vector(noise, config.arm_m);
    stop.view = {s, 0, TargetStatus::ok, "", {}};
    for (std::size_t i = 0; i < views.input.target_m.size(); ++i) {
      const auto q = lens.project(camera_from_target * views.input.target_m[i]);
      const double dx = normal(noise), dy = normal(noise);
      if (!q || q->x() < 1 || q->y() < 1 || q->x() > 638 || q->y() > 478) continue;
      stop.view.points.push_back(
          {static_cast<int>(i), *q + config.corner_px * Eigen::Vector2d(dx, dy)});
    }
    views.input.stops.push_back(std::move(stop));
  }
  return views;
}

HandEyeError hand_eye_error(const HandEyeViews& views, const HandEyeResult& result) {
  const Pose off = inverse(views.gripper_from_camera) * result.gripper_from_camera;
  return {off.translation_m.norm(), angle_rad(off.rotation)};
}

}  // namespace cousin
