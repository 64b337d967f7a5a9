#include "calibration/solve/calibrate_opencv_stereo.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <set>

#include "calibration/solve/calibration_seed.h"

namespace cousin {
namespace {

SolverRun refuse_stereo(const std::string& reason) {
  SolverRun run;
  run.status = CalibrationStatus::bad_input;
  run.reason = "opencv: " + reason;
  return run;
}

/// A lens as OpenCV takes it, and back.
struct CvLens {
  cv::Mat matrix, distortion;
  explicit CvLens(const Eigen::VectorXd& p) {
    matrix = (cv::Mat_<double>(3, 3) << p(0), 0, p(2), 0, p(1), p(3), 0, 0, 1);
    distortion = cv::Mat::zeros(1, std::max(5, static_cast<int>(p.size()) - 4), CV_64F);
    for (int i = 4; i < p.size(); ++i) distortion.at<double>(i - 4) = p(i);
  }
  Eigen::VectorXd parameters(Eigen::Index count) const {
    Eigen::VectorXd p(count);
    p.head<4>() << matrix.at<double>(0, 0), matrix.at<double>(1, 1), matrix.at<double>(0, 2),
        matrix.at<double>(1, 2);
    for (Eigen::Index i = 4; i < count; ++i) p(i) = distortion.at<double>(static_cast<int>(i) - 4);
    return p;
  }
};

std::set<int> ids_of(const ProblemView& view) {
  std::set<int> ids;
  for (const ProblemPoint& p : view.points) {
    if (!p.rejected) ids.insert(p.id);
  }
  return ids;
}

/// Leaves the frames that both cameras see, and of them the points that both see, in one order.
void keep_common(CalibrationProblem& problem, CalibrationState& state) {
  constexpr std::size_t kLeastPoints = 4;
  std::vector<ProblemView> views;
  std::vector<int> numbers;
  std::vector<Vector6d> frames;
  for (std::size_t v = 0; v + 1 < problem.views.size(); ++v) {
    ProblemView left = problem.views[v], right = problem.views[v + 1];
    if (left.frame != right.frame || left.camera == right.camera) continue;
    if (left.camera > right.camera) std::swap(left, right);
    const std::set<int> in_left = ids_of(left), in_right = ids_of(right);
    for (ProblemView* view : {&left, &right}) {
      std::erase_if(view->points, [&](const ProblemPoint& p) {
        return p.rejected || in_left.count(p.id) == 0 || in_right.count(p.id) == 0;
      });
      std::sort(view->points.begin(), view->points.end(),
                [](const ProblemPoint& a, const ProblemPoint& b) { return a.id < b.id; });
    }
    if (left.points.size() < kLeastPoints) continue;
    numbers.push_back(problem.frames[static_cast<std::size_t>(left.frame)]);
    frames.push_back(state.frames[static_cast<std::size_t>(left.frame)]);
    left.frame = right.frame = static_cast<int>(numbers.size()) - 1;
    views.push_back(std::move(left));
    views.push_back(std::move(right));
  }
  problem.views = std::move(views);
  problem.frames = std::move(numbers);
  state.frames = std::move(frames);
}

/// Poses of the frames that fit both cameras best, lenses and places held.
void refine_frames(const CalibrationProblem& problem, CalibrationState& state) {
  constexpr int kSteps = 30;
  for (std::size_t f = 0; f < state.frames.size(); ++f) {
    double before = std::numeric_limits<double>::infinity();
    for (int i = 0; i < kSteps; ++i) {
      Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
      Vector6d right = Vector6d::Zero();
      double squares = 0;
      const PosedFrame frame(state.frames[f].data());
      for (const ProblemView& view : problem.views) {
        if (view.frame != static_cast<int>(f)) continue;
        const auto camera = static_cast<std::size_t>(view.camera);
        const auto lens = static_cast<std::size_t>(problem.lens_of_camera[camera]);
        const PosedFrame in_rig(state.cameras[camera].data());
        const LensShape& shape = problem.lenses[lens].shape;
        RowMatrix d_lens(2, lens_parameter_count(shape));
        for (const ProblemPoint& p : view.points) {
          ObservationValue value;
          if (!observe(shape, state.lenses[lens].data(), &in_rig, frame,
                       problem.target[static_cast<std::size_t>(p.id)], value, d_lens.data()))
            continue;
          const Eigen::Vector2d r = value.pixel_px - p.pixel_px;
          squares += r.squaredNorm();
          normal += value.d_rig_from_points.transpose() * value.d_rig_from_points;
          right += value.d_rig_from_points.transpose() * r;
        }
      }
      state.frames[f] -= normal.ldlt().solve(right);
      if (squares >= before * (1 - 1e-13)) break;
      before = squares;
    }
  }
}

/// Each camera alone. @return the worse run; `lenses` grows
SolverRun lenses_alone(const CalibrationProblem& problem, std::vector<Eigen::VectorXd>& lenses) {
  SolverRun worst;
  for (int camera = 0; camera < 2; ++camera) {
    CalibrationProblem single =
        single_lens_problem(problem, camera, static_cast<int>(problem.views.size()));
    CalibrationState alone;
    if (single.views.empty())
      return refuse_stereo("camera" + std::to_string(camera) + " has no view");
    const SolverRun run = solve_with_opencv(single, alone);
    if (alone.lenses.empty()) return run;
    lenses.push_back(alone.lenses.front());
  }
  return worst;
}

/// Points that both cameras see as OpenCV takes them, per frame.
struct PointsOfBoth {
  std::vector<std::vector<cv::Point3f>> target;
  std::vector<std::vector<cv::Point2f>> pixels[2];  ///< of each camera
};

PointsOfBoth points_of_both(const CalibrationProblem& problem) {
  PointsOfBoth both;
  for (const ProblemView& view : problem.views) {
    std::vector<cv::Point3f> points;
    std::vector<cv::Point2f> seen;
    for (const ProblemPoint& p : view.points) {
      const Eigen::Vector3f x = problem.target[static_cast<std::size_t>(p.id)].cast<float>();
      points.emplace_back(x.x(), x.y(), x.z());
      seen.emplace_back(static_cast<float>(p.pixel_px.x()), static_cast<float>(p.pixel_px.y()));
    }
    if (view.camera == 0) both.target.push_back(std::move(points));
    both.pixels[view.camera].push_back(std::move(seen));
  }
  return both;
}

Pose stereo_pose_of_cv(const cv::Mat& rotation, const cv::Mat& translation) {
  Eigen::Matrix3d r;
  Eigen::Vector3d t;
  for (int i = 0; i < 3; ++i) {
    t(i) = translation.at<double>(i);
    for (int j = 0; j < 3; ++j) r(i, j) = rotation.at<double>(i, j);
  }
  return {Eigen::Quaterniond(r).normalized(), t};
}

}  // namespace

SolverRun solve_stereo_with_opencv(CalibrationProblem& problem, CalibrationState& state) {
  if (problem.lenses.size() != 2)
    return refuse_stereo("cv::stereoCalibrate has no lens that two cameras share");
  const LensModel model = problem.lenses.front().shape.model;
  if (model != problem.lenses.back().shape.model)
    return refuse_stereo("cv::stereoCalibrate wants one lens model of both cameras");
  if (model == LensModel::kannala_brandt4)
    return refuse_stereo(
        "cv::fisheye::stereoCalibrate is not among what is called: two fisheyes by ceres");
  int flags = 0;
  const std::string unable = opencv_flags(problem.lenses.front(), flags);
  if (!unable.empty()) return refuse_stereo(unable);

  state = {};
  SolverRun run = lenses_alone(problem, state.lenses);
  if (state.lenses.size() != 2) return run;
  const std::vector<int> alone =
      assemble_rig(problem, seed_view_poses(problem, state.lenses), state);
  if (alone.empty()) keep_common(problem, state);
  if (!alone.empty() || problem.views.empty()) {
    run.status = CalibrationStatus::not_determined;
    run.reason = "cameras that share no frame with the others";
    run.not_determined = {"camera1.pose"};
    return run;
  }
  const PointsOfBoth points = points_of_both(problem);
  CvLens left(state.lenses[0]), right(state.lenses[1]);
  const Camera& like = problem.lenses.front().like;
  cv::Mat rotation, translation, essential, fundamental;
  try {
    run.rms_px = cv::stereoCalibrate(
        points.target, points.pixels[0], points.pixels[1], left.matrix, left.distortion,
        right.matrix, right.distortion, cv::Size(like.width_px, like.height_px), rotation,
        translation, essential, fundamental, flags | cv::CALIB_USE_INTRINSIC_GUESS,
        cv::TermCriteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS,
                         problem.config.max_iterations, std::numeric_limits<double>::epsilon()));
  } catch (const cv::Exception& error) {
    run.status = CalibrationStatus::not_converged;
    run.reason = std::string("opencv: ") + error.what();
    state.frames.clear();
    return run;
  }
  run.rms_name =
      "cv::stereoCalibrate: per point of both cameras, sqrt(2) of the RMS per coordinate";
  state.lenses = {left.parameters(state.lenses[0].size()),
                  right.parameters(state.lenses[1].size())};
  state.cameras[1] = pose_vector(stereo_pose_of_cv(rotation, translation));
  refine_frames(problem, state);
  return run;
}

}  // namespace cousin
