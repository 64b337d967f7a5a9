#include "benchmarks/suites/calibration/rig_rows.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "benchmarks/suites/calibration/calibration_row.h"
#include "benchmarks/suites/calibration/hand_eye_views.h"
#include "sim/types/stage_clock.h"

namespace cousin {

std::vector<ScoreRow> hand_eye_rows(std::uint64_t seed, bool quick) {
  std::vector<ScoreRow> rows;
  const int arms = quick ? 20 : 100;
  ScoreRow row =
      calibration_row("hand-eye", "20 poses, 0.1 px, 0.2 mm, 0.02 degrees", "ours", seed);
  row.n = arms;
  double place2 = 0, turn2 = 0, refused[2] = {0, 0};
  for (int i = 0; i < arms; ++i) {
    const Rng rng = Rng(seed).fork("hand-eye").fork(static_cast<std::uint64_t>(i));
    HandEyeViewsConfig config;
    const HandEyeViews views = make_hand_eye_views(config, rng);
    const HandEyeError error = hand_eye_error(views, calibrate_hand_eye(views.input));
    place2 += error.place_m * error.place_m;
    turn2 += error.turn_rad * error.turn_rad;
    for (int k = 0; k < 2; ++k) {
      config.motion = k == 0 ? ArmMotion::translation : ArmMotion::one_axis;
      refused[k] += calibrate_hand_eye(make_hand_eye_views(config, rng).input).status ==
                    CalibrationStatus::not_determined;
    }
  }
  rows.push_back(at_most(row, "place, RMS error", "m", std::sqrt(place2 / arms), 3e-4));
  rows.push_back(at_most(row, "rotation, RMS error", "rad", std::sqrt(turn2 / arms), 5.24e-4));
  for (int k = 0; k < 2; ++k) {
    row.case_name = k == 0 ? "pure translation" : "parallel axes";
    row.metric = "share refused (1)";
    row.unit = "1";
    row.value = refused[k] / arms;
    rows.push_back(limited(row, at_least(1)));
  }
  return rows;
}

std::vector<ScoreRow> joint_rows(std::uint64_t seed, bool quick) {
  std::vector<ScoreRow> rows;
  std::vector<Camera> cameras(8, study_camera(LensModel::opencv5));
  std::vector<Pose> poses;
  Rng rng = Rng(seed).fork("ring");
  for (int c = 0; c < 8; ++c) {
    cameras[static_cast<std::size_t>(c)].fx_px += uniform(rng, -5, 5);
    cameras[static_cast<std::size_t>(c)].cx_px += uniform(rng, -5, 5);
    const double x = 0.06 * (c % 4), y = 0.06 * (c / 4);
    poses.push_back(inverse(
        Pose{Eigen::Quaterniond(1, -0.03 * (c / 4), 0.03 * (c % 4), 0).normalized(), {x, y, 0}}));
  }
  poses.front() = Pose{};
  CornerViewsConfig config = close_views();
  config.columns = 10;
  config.rows = 6;
  config.pitch_m = 0.02;
  config.near_m = 0.35;
  config.far_m = 0.6;
  config.frames = quick ? 200 : 500;
  const CornerViews views = make_corner_views(cameras, poses, config, Rng(seed).fork("joint"));
  const StageClock clock("joint");
  const CalibrationResult result = calibrate(views.input);
  const StageTiming time = clock.finish();
  ScoreRow row =
      calibration_row("rig", "8 cameras, " + std::to_string(config.frames) + " frames, 60 corners",
                      "ceres, one thread", seed);
  row.n = result.observations;
  row.wall_s = time.wall_s;
  row.cpu_s = time.cpu_s;
  row.peak_rss_mb = peak_rss_mb();
  if (result.status == CalibrationStatus::not_built) {
    rows.push_back(not_built(row, result.reason));
    return rows;
  }
  rows.push_back(at_most(row, "seconds, corners to covariance", "s", time.wall_s, quick ? 12 : 30));
  rows.push_back(at_most(row, "peak memory of the process", "MB", row.peak_rss_mb, 1024));
  double worst_m = 0, worst = 0;
  for (std::size_t c = 1; c < result.camera_from_rig.size(); ++c) {
    const Eigen::Vector3d off =
        result.camera_from_rig[c].translation_m - views.camera_from_rig[c].translation_m;
    worst_m = std::max(worst_m, off.norm());
    for (int k = 0; k < 3; ++k) {
      const std::string name = "camera" + std::to_string(c) + ".t_" + "xyz"[k];
      worst = std::max(worst, std::abs(off(k)) / deviation(result, name));
    }
  }
  row.metric = "largest error of a camera's place";
  row.unit = "m";
  row.value = result.cameras.empty() ? std::nan("") : worst_m;
  rows.push_back(row);
  // 21 numbers: the largest of so many normals is below 4.2 in 99.9 of 100 cases.
  rows.push_back(at_most(row, "the same over its deviation, largest of 21", "1",
                         result.cameras.empty() ? std::nan("") : worst, 4.2));
  return rows;
}

}  // namespace cousin
