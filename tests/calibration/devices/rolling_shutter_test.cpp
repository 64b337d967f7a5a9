#include "calibration/devices/rolling_shutter.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <stdexcept>

#include "benchmarks/suites/calibration/corner_views.h"
#include "calibration/solve/calibration_uncertainty.h"

namespace cousin {
namespace {

constexpr double kReadout_s = 0.02, kStep_s = 1.0 / 30;
constexpr int kRows = 480;

/// Any solver gives the start.
CalibrationConfig start() { return {.solver = default_calibration_solver()}; }

/// The same where a lens that is known to two pixels will do: its deviations are tested, not how
/// small they are.
CalibrationConfig any_lens() {
  CalibrationConfig config = start();
  config.max_deviation_share = config.max_focal_share = config.max_centre_share = 1;
  return config;
}

/// Where the target is at a time, in the camera's axes.
using Motion = std::function<Pose(double)>;

/// Corners as rows are read one after the other, each at its own time: found by going back and
/// forth between the row and the time at which it is read.
TargetView rolled_view(const std::vector<Eigen::Vector3d>& target_m, const Lens& lens,
                       const Motion& motion, double time_s, double readout_s, double noise_px,
                       int frame, Rng rng) {
  TargetView view{frame, 0, TargetStatus::ok, "", {}};
  view.time_s = time_s;
  for (std::size_t i = 0; i < target_m.size(); ++i) {
    const double dx = normal(rng), dy = normal(rng);
    double row = 0.5 * (kRows - 1);
    std::optional<Eigen::Vector2d> q;
    for (int k = 0; k < 30; ++k) {
      const double t = time_s + (row - 0.5 * (kRows - 1)) / (kRows - 1) * readout_s;
      q = lens.project(motion(t) * target_m[i]);
      if (!q) break;
      row = q->y();
    }
    if (!q || !(q->minCoeff() > 1) || q->x() > 638 || q->y() > 478) continue;
    TargetObservation seen{static_cast<int>(i), *q + noise_px * Eigen::Vector2d(dx, dy)};
    seen.covariance_px2 = std::max(1e-12, noise_px * noise_px) * Eigen::Matrix2d::Identity();
    view.points.push_back(seen);
  }
  return view;
}

/// A hand: each coordinate a sum of two sines, about a pose that `make_corner_views` drew.
Motion hand(const Pose& about, double speed_m_per_s, double rate_rad_per_s, Rng rng) {
  Eigen::Matrix<double, 6, 4> wave;
  for (Eigen::Index k = 0; k < 6; ++k) {
    for (Eigen::Index j = 0; j < 2; ++j) {
      const double omega = 2 * std::numbers::pi * uniform(rng, 0.5, 1.5);
      wave(k, 2 * j) = omega;
      wave(k, 2 * j + 1) = uniform(rng, 0, 2 * std::numbers::pi);
    }
  }
  return [=](double t) {
    Eigen::Matrix<double, 6, 1> x;
    for (Eigen::Index k = 0; k < 6; ++k) {
      x(k) = 0;
      for (Eigen::Index j = 0; j < 2; ++j)
        x(k) += std::sin(wave(k, 2 * j) * t + wave(k, 2 * j + 1)) / wave(k, 2 * j);
      x(k) *= k < 3 ? rate_rad_per_s : speed_m_per_s;
    }
    const double angle = x.head<3>().norm();
    const Eigen::Quaterniond turn(
        Eigen::AngleAxisd(angle, angle > 0 ? Eigen::Vector3d(x.head<3>() / angle)
                                           : Eigen::Vector3d(Eigen::Vector3d::UnitX())));
    return Pose{turn * about.rotation, about.translation_m + x.tail<3>()};
  };
}

struct Video {
  CalibrationInput input;
  Camera camera;
};

/// Clips of a board, each of consecutive frames, a second apart.
Video video(int clips, int frames, double readout_s, double noise_px, std::uint64_t seed,
            double speed_m_per_s = 0.2) {
  CornerViewsConfig config;
  config.frames = clips;
  config.near_m = 0.3;
  config.far_m = 0.5;
  config.region = {0.25, 0.25, 0.75, 0.75};
  Video v;
  v.camera = study_camera(LensModel::opencv5);
  const CornerViews still = make_corner_views({v.camera}, {Pose{}}, config, Rng(seed));
  v.input = still.input;
  v.input.views.clear();
  const Lens lens(v.camera);
  for (int c = 0; c < clips; ++c) {
    const Rng rng = Rng(seed).fork("clip").fork(static_cast<std::uint64_t>(c));
    const Motion motion = hand(still.rig_from_target[static_cast<std::size_t>(c)], speed_m_per_s,
                               4 * speed_m_per_s, rng.fork("hand"));
    for (int f = 0; f < frames; ++f) {
      const int number = 100 * c + f;
      v.input.views.push_back(rolled_view(v.input.target_m, lens, motion, c + f * kStep_s,
                                          readout_s, noise_px, number,
                                          rng.fork("noise").fork(static_cast<std::uint64_t>(f))));
    }
  }
  return v;
}

TEST(RollingShutter, AVideoTellsTheLineDelayAndItsDeviation) {
  // The hand is smooth, the prior of its acceleration is not of this hand: the deviation is what
  // noise and an unknown hand leave, so that errors may be smaller, not larger.
  double squares = 0;
  constexpr int kVideos = 6;
  for (std::uint64_t seed = 0; seed < kVideos; ++seed) {
    const Video v = video(8, 8, kReadout_s, 0.1, seed);
    const RollingShutterResult result = calibrate_rolling_shutter(v.input, start());
    ASSERT_EQ(result.calibration.status, CalibrationStatus::ok) << result.calibration.reason;
    EXPECT_EQ(result.neighbours, 8 * 7);
    const double sigma = deviation(result.calibration, "camera0.line_delay_s");
    const double off = (result.line_delay_s - kReadout_s / (kRows - 1)) / sigma;
    EXPECT_LT(std::abs(off), 4);
    squares += off * off;
    EXPECT_LT(sigma, 0.05 * kReadout_s / (kRows - 1));
    // 64 views of 40 corners: the relative error of the noise is 1 / sqrt(2 * 5120) = 1 %.
    EXPECT_NEAR(result.calibration.sigma_px, 0.1, 4 * 0.001);
  }
  EXPECT_LT(std::sqrt(squares / kVideos), 1.8);  // chi with 6 freedoms: above with 0.1 %
}

/// Clips whose velocity wanders as the calibration's prior says.
Video wandering_video(int clips, int frames, const RollingShutterConfig& prior,
                      std::uint64_t seed) {
  CornerViewsConfig config;
  config.frames = clips;
  config.near_m = 0.3;
  config.far_m = 0.5;
  config.region = {0.3, 0.3, 0.7, 0.7};
  Video v;
  v.camera = study_camera(LensModel::opencv5);
  const CornerViews still = make_corner_views({v.camera}, {Pose{}}, config, Rng(seed));
  v.input = still.input;
  v.input.views.clear();
  const Lens lens(v.camera);
  const auto turned = [](const Eigen::Vector3d& by, const Eigen::Quaterniond& from) {
    return Eigen::Quaterniond(
        Eigen::AngleAxisd(by.norm(), by.norm() > 0 ? Eigen::Vector3d(by.normalized())
                                                   : Eigen::Vector3d(Eigen::Vector3d::UnitX())) *
        from);
  };
  for (int c = 0; c < clips; ++c) {
    Rng rng = Rng(seed).fork("wander").fork(static_cast<std::uint64_t>(c));
    Pose pose = still.rig_from_target[static_cast<std::size_t>(c)];
    Eigen::Matrix<double, 6, 1> velocity;
    for (Eigen::Index k = 0; k < 6; ++k) velocity(k) = (k < 3 ? 0.8 : 0.2) * normal(rng);
    for (int f = 0; f < frames; ++f) {
      const double time_s = c + f * kStep_s;
      const Motion motion = [&](double t) {
        return Pose{turned((t - time_s) * velocity.head<3>(), pose.rotation),
                    pose.translation_m + (t - time_s) * Eigen::Vector3d(velocity.tail<3>())};
      };
      v.input.views.push_back(rolled_view(v.input.target_m, lens, motion, time_s, kReadout_s, 0.1,
                                          100 * c + f,
                                          rng.fork("noise").fork(static_cast<std::uint64_t>(f))));
      // Place and velocity after a step with random acceleration, which are correlated by 3/4.
      Eigen::Matrix<double, 6, 1> moved;
      for (Eigen::Index k = 0; k < 6; ++k) {
        const double sigma =
            kStep_s * (k < 3 ? prior.turn_acceleration_rad_per_s2 : prior.acceleration_m_per_s2);
        const double a = normal(rng), b = normal(rng);
        moved(k) = kStep_s * (velocity(k) + sigma * (0.5 * a + b / std::sqrt(12.0)));
        velocity(k) += sigma * a;
      }
      pose.rotation = turned(moved.head<3>(), pose.rotation);
      pose.translation_m += moved.tail<3>();
    }
  }
  return v;
}

TEST(RollingShutter, ErrorsAreAsLargeAsTheCovarianceSaysWhereThePriorIsTrue) {
  double squares = 0, of_delay = 0;
  int count = 0;
  constexpr int kVideos = 10;
  const RollingShutterConfig config;
  for (std::uint64_t seed = 0; seed < kVideos; ++seed) {
    const Video v = wandering_video(10, 5, config, seed);
    const RollingShutterResult result = calibrate_rolling_shutter(v.input, any_lens(), config);
    const CalibrationResult& c = result.calibration;
    ASSERT_EQ(c.status, CalibrationStatus::ok) << c.reason;
    const Eigen::VectorXd truth = [&] {
      Eigen::VectorXd values(c.values.size());
      values << v.camera.fx_px, v.camera.fy_px, v.camera.cx_px, v.camera.cy_px,
          v.camera.distortion[0], v.camera.distortion[1], v.camera.distortion[2],
          v.camera.distortion[3], v.camera.distortion[4], kReadout_s / (kRows - 1);
      return values;
    }();
    // All ten parameters together: chi-square of ten freedoms.
    const Eigen::VectorXd off = c.values - truth;
    squares += off.dot(c.covariance.ldlt().solve(off));
    count += 10;
    const double delay = off(9) / std::sqrt(c.covariance(9, 9));
    EXPECT_LT(std::abs(delay), 4);
    of_delay += delay * delay;
  }
  // A chi-square of 100 over 100 has a deviation of 0.14, one of 10 over 10 of 0.45: four of them.
  EXPECT_NEAR(squares / count, 1, 4 * 0.14);
  EXPECT_LT(of_delay / kVideos, 1 + 4 * 0.45);
  EXPECT_GT(of_delay / kVideos, 0.05);
}

TEST(RollingShutter, AGlobalShutterHasALineDelayOfZero) {
  const Video v = video(8, 8, 0, 0.1, 2);
  const RollingShutterResult result = calibrate_rolling_shutter(v.input, start());
  ASSERT_EQ(result.calibration.status, CalibrationStatus::ok) << result.calibration.reason;
  const double sigma = deviation(result.calibration, "camera0.line_delay_s");
  EXPECT_LT(std::abs(result.line_delay_s), 4 * sigma);
  EXPECT_LT(sigma * (kRows - 1), 0.001);
}

TEST(RollingShutter, SinglePicturesTellTheLensAndNoLineDelay) {
  Video v = video(20, 1, kReadout_s, 0.1, 3);
  for (TargetView& view : v.input.views) view.time_s = std::nan("");
  const RollingShutterResult result = calibrate_rolling_shutter(v.input, any_lens());
  const CalibrationResult& c = result.calibration;
  EXPECT_EQ(c.status, CalibrationStatus::not_determined);
  EXPECT_EQ(c.not_determined, std::vector<std::string>{"camera0.line_delay_s"});
  EXPECT_TRUE(std::isnan(result.line_delay_s));
  EXPECT_EQ(result.neighbours, 0);
  ASSERT_EQ(c.cameras.size(), 1U);
  EXPECT_NEAR(c.cameras[0].fx_px, v.camera.fx_px, 4 * deviation(c, "camera0.fx_px"));
  EXPECT_NEAR(c.cameras[0].cx_px, v.camera.cx_px, 4 * deviation(c, "camera0.cx_px"));
  // 800 corners, 120 poses' and 120 velocities' numbers: 4 deviations of 2.7 %.
  EXPECT_NEAR(c.sigma_px, 0.1, 0.011);
  EXPECT_GT(calibrate(v.input, start()).sigma_px, 0.13);
}

TEST(RollingShutter, AReadoutThatIsKnownNeedsNoTimes) {
  Video v = video(20, 1, kReadout_s, 0.1, 3);
  for (TargetView& view : v.input.views) view.time_s = std::nan("");
  RollingShutterConfig config;
  config.readout_s = kReadout_s;
  const RollingShutterResult result = calibrate_rolling_shutter(v.input, any_lens(), config);
  EXPECT_EQ(result.calibration.status, CalibrationStatus::ok) << result.calibration.reason;
  EXPECT_DOUBLE_EQ(result.line_delay_s, kReadout_s / (kRows - 1));
  EXPECT_EQ(parameter_index(result.calibration, "camera0.line_delay_s"), -1);
}

TEST(RollingShutter, ACameraThatStandsStillTellsNoLineDelay) {
  const Video v = video(16, 3, kReadout_s, 0.1, 4, 1e-6);
  const RollingShutterResult result = calibrate_rolling_shutter(v.input, start());
  EXPECT_EQ(result.calibration.status, CalibrationStatus::not_determined);
  const auto& names = result.calibration.not_determined;
  EXPECT_EQ(std::count(names.begin(), names.end(), "camera0.line_delay_s"), 1);
  EXPECT_TRUE(std::isnan(result.line_delay_s));
}

TEST(RollingShutter, OutliersAreRejected) {
  Video v = video(8, 8, kReadout_s, 0.1, 5);
  int wrong = 0;
  for (std::size_t i = 0; i < v.input.views.size(); i += 2, ++wrong)
    v.input.views[i].points[i % 7].pixel_px.x() += 6;
  CalibrationConfig calibration = start();
  calibration.reject_sigmas = 5;
  const RollingShutterResult result = calibrate_rolling_shutter(v.input, calibration);
  ASSERT_EQ(result.calibration.status, CalibrationStatus::ok) << result.calibration.reason;
  // All that are wrong, and of the 2500 good ones at most a hundredth: how a hand speeds up within
  // a readout is not modelled.
  for (const CalibrationResidual& r : result.calibration.residuals) {
    const auto& points = v.input.views[static_cast<std::size_t>(r.view)].points;
    if (r.view % 2 == 0 && points[static_cast<std::size_t>(r.view) % 7].id == r.id)
      EXPECT_TRUE(r.rejected) << r.view;
  }
  EXPECT_LE(result.calibration.rejected, wrong + 25);
  EXPECT_NEAR(result.line_delay_s, kReadout_s / (kRows - 1),
              4 * deviation(result.calibration, "camera0.line_delay_s"));
}

TEST(RollingShutter, WhatItCannotDoIsRefusedByName) {
  const Video v = video(3, 2, kReadout_s, 0.1, 6);
  const auto reason = [](const CalibrationInput& input, const CalibrationConfig& config) {
    const CalibrationResult c = calibrate_rolling_shutter(input, config).calibration;
    EXPECT_EQ(c.status, CalibrationStatus::bad_input);
    return c.reason;
  };
  CalibrationInput two = v.input;
  two.cameras.push_back(two.cameras.front());
  EXPECT_NE(reason(two, {}).find("one camera"), std::string::npos);
  CalibrationConfig robust;
  robust.loss = RobustLoss::huber;
  EXPECT_NE(reason(v.input, robust).find("loss"), std::string::npos);
  CalibrationConfig bent;
  bent.board_deformation = true;
  EXPECT_NE(reason(v.input, bent).find("flat"), std::string::npos);
  CalibrationInput same = v.input;
  same.views[1].time_s = same.views[0].time_s;
  CalibrationConfig built;  // in every build
  built.solver = CalibrationSolver::opencv;
  EXPECT_NE(reason(same, built).find("same time"), std::string::npos);
  RollingShutterConfig wrong;
  wrong.max_gap_s = -1;
  EXPECT_THROW((void)calibrate_rolling_shutter(v.input, start(), wrong), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
