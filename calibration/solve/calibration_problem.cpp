#include "calibration/solve/calibration_problem.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <sstream>

#include "calibration/boards/planar_pose.h"

namespace cousin {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kLeastPoints = 4;

/// Moves the target to its middle and to size 1. False if its points lie on a line.
bool normalise_target(const CalibrationInput& input, CalibrationProblem& problem,
                      std::string& complaint) {
  const std::vector<Eigen::Vector3d>& points = input.target_m;
  const auto fail = [&](const std::string& what) {
    complaint = what;
    return false;
  };
  if (points.size() < kLeastPoints) {
    return fail("target: " + std::to_string(points.size()) + " points, at least 4 are needed");
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite())
      return fail("target: point " + std::to_string(i) + " is not finite");
  }
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  // About the first point: a sum of large coordinates would round.
  for (const Eigen::Vector3d& p : points) centre += p - points.front();
  centre = points.front() + centre / static_cast<double>(points.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  Eigen::Vector2d half = Eigen::Vector2d::Zero();
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector3d d = p - centre;
    spread += d * d.transpose();
    half = half.cwiseMax(d.head<2>().cwiseAbs());
  }
  const double unit = std::sqrt(spread.trace() / static_cast<double>(points.size()));
  const double flat = std::sqrt(spread(2, 2) / static_cast<double>(points.size()));
  const Eigen::Vector2d across =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(spread.topLeftCorner<2, 2>()).eigenvalues();
  if (!(across(0) > 1e-8 * across(1))) return fail("target: its points lie on a line");
  if (flat > 0.1 * unit) return fail("target: it is not flat: z spreads over a tenth of its size");
  problem.centre_m = centre;
  problem.unit_m = unit;
  for (const Eigen::Vector3d& p : points) {
    problem.target.emplace_back((p - centre) / unit);
    problem.board.emplace_back((p - centre).head<2>().cwiseQuotient(half));
  }
  return true;
}

ProblemLens make_lens(const CalibrationCamera& camera, const CalibrationConfig& config) {
  ProblemLens lens;
  lens.shape = shape_of(camera.start);
  lens.like = camera.start;
  lens.given = camera.start.fx_px > 0;
  const std::vector<std::string> names = lens_parameter_names(lens.shape);
  const auto n = static_cast<Eigen::Index>(names.size());
  lens.prior_mean = lens_parameters(camera.start);
  lens.prior_sigma = Eigen::VectorXd::Constant(n, kInfinity);
  for (const std::string& name : names) {
    lens.free.push_back(std::find(config.fixed.begin(), config.fixed.end(), name) ==
                        config.fixed.end());
  }
  // The surface can do all that the core does: the core stays at its start [mrcal, "Splined
  // stereographic lens model"].
  if (lens.shape.model == LensModel::splined_stereographic) {
    std::fill_n(lens.free.begin(), 4, false);
  }
  if (lens.given && config.focal_prior_share > 0) {
    lens.prior_sigma.head<2>() = config.focal_prior_share * lens.prior_mean.head<2>();
  }
  if (lens.given && config.centre_prior_px > 0) {
    lens.prior_sigma.segment<2>(2).setConstant(config.centre_prior_px);
  }
  if (lens.shape.model == LensModel::splined_stereographic) {
    lens.prior_sigma.tail(n - 4).setConstant(config.spline_prior);
  } else if (config.distortion_prior > 0) {
    lens.prior_sigma.tail(n - 4).setConstant(config.distortion_prior);
  }
  return lens;
}

bool add_lenses(const CalibrationInput& input, CalibrationProblem& problem,
                std::string& complaint) {
  const CalibrationConfig& config = problem.config;
  std::vector<std::string> known;
  for (std::size_t c = 0; c < input.cameras.size(); ++c) {
    const CalibrationCamera& camera = input.cameras[c];
    const std::string name = "camera" + std::to_string(c);
    if (camera.start.width_px < 1 || camera.start.height_px < 1) {
      complaint = name + ": image of " + std::to_string(camera.start.width_px) + " x " +
                  std::to_string(camera.start.height_px) + " px";
      return false;
    }
    if (camera.shares_lens_with >= static_cast<int>(c)) {
      complaint = name + ": shares_lens_with = " + std::to_string(camera.shares_lens_with) +
                  " is not an earlier camera";
      return false;
    }
    if (camera.shares_lens_with >= 0) {
      problem.lens_of_camera.push_back(
          problem.lens_of_camera[static_cast<std::size_t>(camera.shares_lens_with)]);
      continue;
    }
    if (camera.start.model == LensModel::splined_stereographic &&
        (camera.start.spline.columns <= camera.start.spline.order ||
         camera.start.spline.rows <= camera.start.spline.order ||
         !(camera.start.spline.fov_x_rad > 0))) {
      complaint = name + ": a splined lens needs its surface's columns, rows and fov_x_rad";
      return false;
    }
    problem.lens_of_camera.push_back(static_cast<int>(problem.lenses.size()));
    problem.lenses.push_back(make_lens(camera, config));
    const ProblemLens& lens = problem.lenses.back();
    if (!lens.given && std::any_of(config.fixed.begin(), config.fixed.end(),
                                   [](const auto& f) { return f == "fx_px" || f == "fy_px"; })) {
      complaint = name + ": fx_px or fy_px is fixed, but no start is given";
      return false;
    }
    const auto names = lens_parameter_names(problem.lenses.back().shape);
    known.insert(known.end(), names.begin(), names.end());
  }
  for (const std::string& name : config.fixed) {
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      complaint = "fixed: no camera has a parameter \"" + name + "\"";
      return false;
    }
  }
  return true;
}

/// Whether the points of a view span a plane of the target.
bool spans(const CalibrationProblem& problem, const ProblemView& view) {
  if (view.points.size() < kLeastPoints) return false;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  const auto at = [&](const ProblemPoint& p) -> Eigen::Vector2d {
    return problem.target[static_cast<std::size_t>(p.id)].head<2>();
  };
  for (const ProblemPoint& p : view.points) mean += at(p);
  mean /= static_cast<double>(view.points.size());
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const ProblemPoint& p : view.points) spread += (at(p) - mean) * (at(p) - mean).transpose();
  const Eigen::Vector2d e = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(spread).eigenvalues();
  return e(0) > 1e-8 * e(1);
}

bool add_view(const TargetView& view, int index, CalibrationProblem& problem,
              std::string& complaint) {
  const std::string name = "view " + std::to_string(index);
  if (view.camera < 0 || view.camera >= static_cast<int>(problem.lens_of_camera.size())) {
    complaint = name + ": camera " + std::to_string(view.camera) + " does not exist";
    return false;
  }
  ProblemView add{index, view.camera, 0, view.status == TargetStatus::half_turn_unknown, {}};
  for (const TargetObservation& point : view.points) {
    if (point.id < 0 || point.id >= static_cast<int>(problem.target.size())) {
      complaint = name + ": point " + std::to_string(point.id) + " is not one of the target's " +
                  std::to_string(problem.target.size());
      return false;
    }
    if (!point.pixel_px.allFinite()) {
      complaint = name + ": pixel of point " + std::to_string(point.id) + " is not finite";
      return false;
    }
    const Camera& image = problem
                              .lenses[static_cast<std::size_t>(
                                  problem.lens_of_camera[static_cast<std::size_t>(view.camera)])]
                              .like;
    const Eigen::Array2d last(image.width_px, image.height_px);
    if ((point.pixel_px.array() < -1).any() || (point.pixel_px.array() > last).any()) {
      std::ostringstream text;
      text << name << ": pixel (" << point.pixel_px.x() << ", " << point.pixel_px.y()
           << ") of point " << point.id << " is outside the camera's image of " << image.width_px
           << " x " << image.height_px;
      complaint = text.str();
      return false;
    }
    ProblemPoint p{point.id, point.pixel_px};
    if (problem.config.weigh_by_covariance) {
      if (!(point.covariance_px2.determinant() > 0 && point.covariance_px2(0, 0) > 0)) {
        complaint = name + ": covariance of point " + std::to_string(point.id) + " is not positive";
        return false;
      }
      p.white = whitening(point.covariance_px2);
    }
    add.points.push_back(p);
  }
  if (spans(problem, add)) problem.views.push_back(std::move(add));
  return true;
}

}  // namespace

CalibrationProblem make_problem(const CalibrationInput& input, const CalibrationConfig& config,
                                std::string& complaint) {
  CalibrationProblem problem;
  problem.config = config;
  complaint.clear();
  if (input.cameras.empty()) complaint = "no cameras";
  if (!complaint.empty() || !normalise_target(input, problem, complaint) ||
      !add_lenses(input, problem, complaint)) {
    return problem;
  }
  std::map<int, int> frames;
  for (std::size_t i = 0; i < input.views.size(); ++i) {
    if (!is_usable(input.views[i])) continue;
    const std::size_t before = problem.views.size();
    if (!add_view(input.views[i], static_cast<int>(i), problem, complaint)) return problem;
    if (problem.views.size() > before) frames.emplace(input.views[i].frame, 0);
  }
  if (problem.views.empty()) {
    complaint = "no view shows four points of the target that are not on a line";
    return problem;
  }
  for (auto& [number, index] : frames) {
    index = static_cast<int>(problem.frames.size());
    problem.frames.push_back(number);
  }
  for (ProblemView& view : problem.views) {
    view.frame = frames.at(input.views[static_cast<std::size_t>(view.input_view)].frame);
  }
  std::stable_sort(problem.views.begin(), problem.views.end(),
                   [](const ProblemView& a, const ProblemView& b) { return a.frame < b.frame; });
  return problem;
}

Eigen::Vector2d d_deformation(const CalibrationProblem& problem, int id) {
  const Eigen::Vector2d& b = problem.board[static_cast<std::size_t>(id)];
  return {1 - b.x() * b.x(), 1 - b.y() * b.y()};
}

Eigen::Vector3d deformed(const CalibrationProblem& problem, int id,
                         const Eigen::Vector2d& deformation) {
  Eigen::Vector3d p = problem.target[static_cast<std::size_t>(id)];
  p.z() += deformation.dot(d_deformation(problem, id));
  return p;
}

std::vector<Eigen::Vector2d> residuals_of(const CalibrationProblem& problem,
                                          const CalibrationState& state, const ProblemView& view) {
  const auto camera = static_cast<std::size_t>(view.camera);
  const auto lens = static_cast<std::size_t>(problem.lens_of_camera[camera]);
  const PosedFrame frame(state.frames[static_cast<std::size_t>(view.frame)].data());
  const PosedFrame in_rig(state.cameras[camera].data());
  std::vector<Eigen::Vector2d> residuals;
  residuals.reserve(view.points.size());
  for (const ProblemPoint& p : view.points) {
    ObservationValue value;
    const bool seen = observe(problem.lenses[lens].shape, state.lenses[lens].data(), &in_rig, frame,
                              deformed(problem, p.id, state.deformation), value, nullptr);
    residuals.emplace_back(
        seen ? Eigen::Vector2d(value.pixel_px - p.pixel_px)
             : Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN()));
  }
  return residuals;
}

void describe_noise(const CalibrationProblem& problem, double deviation,
                    CalibrationResult& result) {
  result.sigma_px = deviation;
  if (!problem.config.weigh_by_covariance) return;
  double variance = 0;
  for (const ProblemView& view : problem.views) {
    for (const ProblemPoint& p : view.points) {
      if (!p.rejected) variance += p.white.inverse().squaredNorm();  // the covariance's trace
    }
  }
  result.noise_factor = deviation;
  result.sigma_px = deviation * std::sqrt(variance / std::max(1, 2 * observation_count(problem)));
}

int observation_count(const CalibrationProblem& problem) {
  int count = 0;
  for (const ProblemView& view : problem.views) {
    for (const ProblemPoint& p : view.points) count += p.rejected ? 0 : 1;
  }
  return count;
}

int free_parameter_count(const CalibrationProblem& problem, bool with_frames) {
  std::ptrdiff_t count = 6 * (static_cast<std::ptrdiff_t>(problem.lens_of_camera.size()) - 1);
  for (const ProblemLens& lens : problem.lenses) {
    count += std::count(lens.free.begin(), lens.free.end(), true);
  }
  if (problem.config.board_deformation) count += 2;
  if (with_frames) count += 6 * static_cast<std::ptrdiff_t>(problem.frames.size());
  return static_cast<int>(count);
}

}  // namespace cousin
