#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "calibration/solve/calibrate_opencv_stereo.h"
#include "calibration/solve/calibration_seed.h"
#include "calibration/solve/calibration_solvers.h"

namespace cousin {
namespace {

SolverRun refuse(const std::string& reason) {
  SolverRun run;
  run.status = CalibrationStatus::bad_input;
  run.reason = "opencv: " + reason;
  return run;
}

struct CvViews {
  std::vector<std::vector<cv::Point3f>> flat;
  std::vector<std::vector<cv::Point3d>> target;
  std::vector<std::vector<cv::Point2d>> pixels;
};

CvViews views_of(const CalibrationProblem& problem) {
  CvViews views;
  for (const ProblemView& view : problem.views) {
    std::vector<cv::Point3d> target;
    std::vector<cv::Point2d> pixels;
    for (const ProblemPoint& p : view.points) {
      if (p.rejected) continue;
      const Eigen::Vector3d& x = problem.target[static_cast<std::size_t>(p.id)];
      target.emplace_back(x.x(), x.y(), x.z());
      pixels.emplace_back(p.pixel_px.x(), p.pixel_px.y());
    }
    views.target.push_back(std::move(target));
    views.pixels.push_back(std::move(pixels));
  }
  return views;
}

Pose pose_of_cv(const cv::Mat& r, const cv::Mat& t) {
  Vector6d v;
  for (int i = 0; i < 3; ++i) {
    v(i) = r.at<double>(i);
    v(3 + i) = t.at<double>(i);
  }
  return pose_of_vector(v);
}

/// cv::calibrateCameraExtended: k1 k2 p1 p2 k3 k4 k5 k6 s1..s4, as ours.
SolverRun perspective(const CalibrationProblem& problem, CalibrationState& state, int flags) {
  SolverRun run;
  const ProblemLens& lens = problem.lenses.front();
  const CvViews views = views_of(problem);
  std::vector<std::vector<cv::Point3f>> target;
  std::vector<std::vector<cv::Point2f>> pixels;
  for (std::size_t v = 0; v < views.target.size(); ++v) {
    target.emplace_back(views.target[v].begin(), views.target[v].end());
    pixels.emplace_back(views.pixels[v].begin(), views.pixels[v].end());
  }
  const int coefficients = std::max(5, distortion_count(lens.shape.model));
  cv::Mat k = cv::Mat::eye(3, 3, CV_64F), distortion = cv::Mat::zeros(1, coefficients, CV_64F);
  const Eigen::VectorXd start = lens_parameters(lens.like);
  if (lens.given) {
    k = (cv::Mat_<double>(3, 3) << start(0), 0, start(2), 0, start(1), start(3), 0, 0, 1);
    for (int i = 4; i < start.size(); ++i) distortion.at<double>(i - 4) = start(i);
  }
  std::vector<cv::Mat> r, t;
  cv::Mat deviations, pose_deviations, errors;
  run.rms_px = cv::calibrateCamera(
      target, pixels, cv::Size(lens.like.width_px, lens.like.height_px), k, distortion, r, t,
      deviations, pose_deviations, errors, flags,
      cv::TermCriteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS,
                       problem.config.max_iterations, std::numeric_limits<double>::epsilon()));
  run.rms_name = "cv::calibrateCamera: per point, sqrt(2) of the RMS per coordinate";
  Eigen::VectorXd p = Eigen::VectorXd::Zero(start.size());
  p.head<4>() << k.at<double>(0, 0), k.at<double>(1, 1), k.at<double>(0, 2), k.at<double>(1, 2);
  for (int i = 4; i < p.size(); ++i) p(i) = distortion.at<double>(i - 4);
  const std::vector<std::string> names = lens_parameter_names(lens.shape);
  for (std::size_t i = 0; i < names.size(); ++i)
    run.deviations["camera0." + names[i]] = deviations.at<double>(static_cast<int>(i));
  state.lenses = {p};
  state.cameras = {Vector6d::Zero()};
  state.frames.clear();
  for (std::size_t v = 0; v < r.size(); ++v)
    state.frames.push_back(pose_vector(pose_of_cv(r[v], t[v])));
  return run;
}

SolverRun fisheye(const CalibrationProblem& problem, CalibrationState& state, int flags) {
  SolverRun run;
  const ProblemLens& lens = problem.lenses.front();
  CvViews views = views_of(problem);
  const Eigen::VectorXd start = seed_lens(problem, 0);
  cv::Mat k = (cv::Mat_<double>(3, 3) << start(0), 0, start(2), 0, start(1), start(3), 0, 0, 1);
  cv::Mat distortion = (cv::Mat_<double>(4, 1) << start(4), start(5), start(6), start(7));
  std::vector<cv::Mat> r, t;
  run.rms_px = cv::fisheye::calibrate(
      views.target, views.pixels, cv::Size(lens.like.width_px, lens.like.height_px), k, distortion,
      r, t, flags,
      cv::TermCriteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS,
                       problem.config.max_iterations, 1e-12));
  run.rms_name = "cv::fisheye::calibrate: per point, sqrt(2) of the RMS per coordinate";
  Eigen::VectorXd p(8);
  p << k.at<double>(0, 0), k.at<double>(1, 1), k.at<double>(0, 2), k.at<double>(1, 2),
      distortion.at<double>(0), distortion.at<double>(1), distortion.at<double>(2),
      distortion.at<double>(3);
  state.lenses = {p};
  state.cameras = {Vector6d::Zero()};
  state.frames.clear();
  for (std::size_t v = 0; v < r.size(); ++v)
    state.frames.push_back(pose_vector(pose_of_cv(r[v].reshape(1, 3), t[v].reshape(1, 3))));
  return run;
}

}  // namespace

std::string opencv_flags(const ProblemLens& lens, int& flags) {
  const std::vector<std::string> names = lens_parameter_names(lens.shape);
  const auto fixed = [&](const char* name) {
    const auto at = std::find(names.begin(), names.end(), name);
    return at == names.end() || !lens.free[static_cast<std::size_t>(at - names.begin())];
  };
  if (fixed("fx_px") != fixed("fy_px")) return "fx_px and fy_px are fixed together or not at all";
  if (fixed("cx_px") != fixed("cy_px")) return "cx_px and cy_px are fixed together or not at all";
  const bool fisheye = lens.shape.model == LensModel::kannala_brandt4;
  if (fisheye) {
    flags = cv::fisheye::CALIB_RECOMPUTE_EXTRINSIC | cv::fisheye::CALIB_FIX_SKEW |
            cv::fisheye::CALIB_USE_INTRINSIC_GUESS;
    constexpr std::array<int, 4> kFix = {cv::fisheye::CALIB_FIX_K1, cv::fisheye::CALIB_FIX_K2,
                                         cv::fisheye::CALIB_FIX_K3, cv::fisheye::CALIB_FIX_K4};
    for (std::size_t i = 0; i < 4; ++i) {
      if (!lens.free[4 + i]) flags |= kFix[i];
    }
    if (fixed("cx_px")) flags |= cv::fisheye::CALIB_FIX_PRINCIPAL_POINT;
    return fixed("fx_px") ? "cv::fisheye cannot fix the focal lengths" : "";
  }
  if (fixed("p1") != fixed("p2")) return "p1 and p2 are fixed together or not at all";
  flags = cv::CALIB_USE_LU;
  if (lens.given) flags |= cv::CALIB_USE_INTRINSIC_GUESS;
  if (fixed("fx_px")) flags |= cv::CALIB_FIX_FOCAL_LENGTH;
  if (fixed("cx_px")) flags |= cv::CALIB_FIX_PRINCIPAL_POINT;
  if (fixed("p1")) flags |= cv::CALIB_FIX_TANGENT_DIST;
  const int n = distortion_count(lens.shape.model);
  if (n >= 8) flags |= cv::CALIB_RATIONAL_MODEL;
  if (n >= 12) flags |= cv::CALIB_THIN_PRISM_MODEL;
  constexpr std::array<std::pair<const char*, int>, 6> kFix = {{{"k1", cv::CALIB_FIX_K1},
                                                                {"k2", cv::CALIB_FIX_K2},
                                                                {"k3", cv::CALIB_FIX_K3},
                                                                {"k4", cv::CALIB_FIX_K4},
                                                                {"k5", cv::CALIB_FIX_K5},
                                                                {"k6", cv::CALIB_FIX_K6}}};
  for (const auto& [name, flag] : kFix) {
    const bool known = std::find(names.begin(), names.end(), name) != names.end();
    if ((known || n == 0) && fixed(name)) flags |= flag;
  }
  if (n >= 12) {
    const int prisms = fixed("s1") + fixed("s2") + fixed("s3") + fixed("s4");
    if (prisms != 0 && prisms != 4) return "s1 to s4 are fixed together or not at all";
    if (prisms == 4) flags |= cv::CALIB_FIX_S1_S2_S3_S4;
  }
  return "";
}

SolverRun solve_with_opencv(CalibrationProblem& problem, CalibrationState& state) {
  const CalibrationConfig& config = problem.config;
  const std::size_t cameras = problem.lens_of_camera.size();
  if (cameras > 2)
    return refuse("it calibrates one camera or two (cv::stereoCalibrate), not " +
                  std::to_string(cameras));
  if (problem.lenses.front().shape.model == LensModel::splined_stereographic)
    return refuse("it has no splined lens");
  if (config.board_deformation) return refuse("it knows no board deformation");
  if (config.weigh_by_covariance) return refuse("it does not weigh observations");
  if (config.loss != RobustLoss::none) return refuse("it has no robust loss");
  if (config.focal_prior_share + config.centre_prior_px + config.distortion_prior > 0)
    return refuse("it has no priors");
  if (cameras == 2) return solve_stereo_with_opencv(problem, state);
  for (std::size_t v = 0; v < problem.views.size(); ++v) {
    // Each view is a frame of its own here.
    if (problem.views[v].frame != static_cast<int>(v)) return refuse("two views of one frame");
  }
  int flags = 0;
  const std::string unable = opencv_flags(problem.lenses.front(), flags);
  if (!unable.empty()) return refuse(unable);
  try {
    const bool is_fisheye = problem.lenses.front().shape.model == LensModel::kannala_brandt4;
    return is_fisheye ? fisheye(problem, state, flags) : perspective(problem, state, flags);
  } catch (const cv::Exception& error) {
    SolverRun run;
    run.status = CalibrationStatus::not_converged;
    run.reason = std::string("opencv: ") + error.what();
    state.frames.clear();
    return run;
  }
}

}  // namespace cousin
