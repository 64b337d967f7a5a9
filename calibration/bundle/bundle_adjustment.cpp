#include "calibration/bundle/bundle_adjustment.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>
#include <sstream>
#include <stdexcept>

#include "calibration/boards/planar_pose.h"
#include "calibration/bundle/bundle_frame.h"
#include "calibration/bundle/bundle_problem.h"
#include "calibration/bundle/bundle_squares.h"
#include "calibration/solve/calibration_uncertainty.h"

namespace cousin {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// What cannot be used at all; "" if nothing.
std::string complaint_about(const BundleAdjustmentInput& input) {
  const auto images = static_cast<int>(input.camera_from_world.size());
  const auto points = static_cast<int>(input.points_in_world_m.size());
  if (images < 2) return std::to_string(images) + " images; at least 2";
  if (input.lens_of_image.size() != input.camera_from_world.size())
    return "lens_of_image has " + std::to_string(input.lens_of_image.size()) + " entries for " +
           std::to_string(images) + " images";
  for (const int lens : input.lens_of_image) {
    if (lens < 0 || lens >= static_cast<int>(input.lenses.size()))
      return "lens " + std::to_string(lens) + " does not exist";
  }
  for (const BundleObservation& seen : input.observations) {
    if (seen.image < 0 || seen.image >= images || seen.point < 0 || seen.point >= points)
      return "an observation of image " + std::to_string(seen.image) + ", point " +
             std::to_string(seen.point) + "; there are " + std::to_string(images) + " and " +
             std::to_string(points);
    if (!seen.pixel_px.allFinite() || !(seen.sigma_px > 0)) return "an observation is no number";
  }
  for (const KnownPoint& known : input.known_points) {
    if (known.point < 0 || known.point >= points || !(known.sigma_m > 0) ||
        !known.in_world_m.allFinite())
      return "known point " + std::to_string(known.point) + " is not of this bundle";
  }
  for (const KnownDistance& known : input.known_distances) {
    if (std::min(known.point_a, known.point_b) < 0 ||
        std::max(known.point_a, known.point_b) >= points || known.point_a == known.point_b ||
        !(known.sigma_m > 0) || !(known.length_m > 0))
      return "a known distance is not of this bundle";
  }
  return "";
}

bool fix_the_frame(const std::vector<KnownPoint>& known) {
  Eigen::Matrix3Xd points(3, known.size());
  for (std::size_t i = 0; i < known.size(); ++i)
    points.col(static_cast<Eigen::Index>(i)) = known[i].in_world_m;
  return !are_on_a_line(points, 1e-5);
}

void place_lens(const BundleAdjustmentConfig& config, const Camera& lens, BundleProblem& problem) {
  problem.shapes.push_back(shape_of(lens));
  problem.like.push_back(lens);
  problem.lenses.push_back(lens_parameters(lens));
  const std::vector<std::string> names = lens_parameter_names(problem.shapes.back());
  const auto n = static_cast<Eigen::Index>(names.size());
  Eigen::VectorXd sigma = Eigen::VectorXd::Constant(n, std::numeric_limits<double>::infinity());
  std::vector<bool> free;
  for (std::size_t k = 0; k < names.size(); ++k) {
    const auto is = [&](const char* name) { return names[k] == name; };
    free.push_back(std::none_of(
        config.fixed.begin(), config.fixed.end(),
        [&](const std::string& fixed) { return fixed == "lens" || fixed == names[k]; }));
    double& own = sigma[static_cast<Eigen::Index>(k)];
    if (is("fx_px") || is("fy_px")) {
      if (config.focal_prior_share > 0) own = config.focal_prior_share * lens.fx_px;
    } else if (is("cx_px") || is("cy_px")) {
      if (config.centre_prior_px > 0) own = config.centre_prior_px;
    } else if (config.distortion_prior > 0) {
      own = config.distortion_prior;
    }
  }
  problem.free.push_back(std::move(free));
  problem.prior_mean.push_back(problem.lenses.back());
  problem.prior_sigma.push_back(std::move(sigma));
}

BundleProblem make_problem(const BundleAdjustmentInput& input,
                           const BundleAdjustmentConfig& config) {
  BundleProblem problem;
  problem.config = config;
  const auto n = static_cast<double>(input.camera_from_world.size());
  for (const Pose& pose : input.camera_from_world) problem.centre_m += centre_in_world_m(pose) / n;
  double spread = 0;
  for (const Pose& pose : input.camera_from_world)
    spread += (centre_in_world_m(pose) - problem.centre_m).squaredNorm() / n;
  problem.unit_m = spread > 0 ? std::sqrt(spread) : 1;
  for (const Camera& lens : input.lenses) place_lens(config, lens, problem);
  problem.lens_of_image = input.lens_of_image;
  problem.zoom.assign(input.camera_from_world.size(), 1);
  for (const Pose& pose : input.camera_from_world) {
    Pose own = pose;
    // t + R c, from the centres: a far origin must not cost digits.
    own.translation_m =
        -(pose.rotation * (centre_in_world_m(pose) - problem.centre_m)) / problem.unit_m;
    problem.poses.push_back(pose_vector(own));
  }
  for (const Vector3d& point : input.points_in_world_m)
    problem.points.push_back((point - problem.centre_m) / problem.unit_m);
  problem.observations = input.observations;
  problem.used.assign(input.observations.size(), true);
  for (KnownPoint known : input.known_points) {
    known.in_world_m = (known.in_world_m - problem.centre_m) / problem.unit_m;
    known.sigma_m /= problem.unit_m;
    problem.known_points.push_back(known);
  }
  for (KnownDistance known : input.known_distances) {
    known.length_m /= problem.unit_m;
    known.sigma_m /= problem.unit_m;
    problem.known_distances.push_back(known);
  }
  problem.gauge = fix_the_frame(input.known_points) ? BundleGauge::metric
                  : input.known_distances.empty()   ? BundleGauge::similarity
                                                    : BundleGauge::rigid;
  return problem;
}

/// Points that fewer than two images show, or whose rays are too near parallel, go.
std::vector<bool> leave_out(const BundleAdjustmentInput& input,
                            const BundleAdjustmentConfig& config, BundleProblem& problem) {
  std::vector<std::set<int>> images(input.points_in_world_m.size());
  for (const BundleObservation& seen : input.observations)
    images[static_cast<std::size_t>(seen.point)].insert(seen.image);
  std::set<int> known;
  for (const KnownPoint& k : input.known_points) known.insert(k.point);
  std::vector<bool> out(images.size());
  for (std::size_t p = 0; p < images.size(); ++p) {
    if (known.contains(static_cast<int>(p))) continue;
    out[p] = images[p].size() < 2 ||
             (config.min_parallax_rad > 0 &&
              parallax_rad(input, static_cast<int>(p)) < config.min_parallax_rad);
  }
  for (std::size_t i = 0; i < problem.used.size(); ++i)
    problem.used[i] = !out[static_cast<std::size_t>(input.observations[i].point)];
  return out;
}

/// @returns how many observations went.
int reject(BundleProblem& problem) {
  const double limit = problem.config.reject_sigmas * std::max(robust_sigma(problem), 1e-9);
  int gone = 0;
  for (std::size_t i = 0; i < problem.observations.size(); ++i) {
    if (!problem.used[i]) continue;
    if (bundle_residual(problem, problem.observations[i]).norm() <= limit) continue;
    problem.used[i] = false;
    ++gone;
  }
  return gone;
}

/// From a start whose residuals are far beyond where the loss turns, most of them would count as
/// outliers and hold each other where they are: the loss turns at two deviations of most residuals
/// first, loosely, and comes down as they do [graduated non-convexity, Blake & Zisserman 1987].
std::string minimise_from_afar(BundleProblem& problem, int& iterations) {
  const BundleAdjustmentConfig asked = problem.config;
  problem.config.tolerance = std::max(asked.tolerance, 1e-3);
  constexpr int kPasses = 10;
  for (int pass = 0; pass < kPasses && asked.loss != RobustLoss::none; ++pass) {
    problem.config.loss_px = 2 * robust_sigma(problem);
    if (!(problem.config.loss_px > 2 * asked.loss_px)) break;
    minimise_bundle(problem, iterations);
  }
  problem.config = asked;
  return minimise_bundle(problem, iterations);
}

/// Sightings of one image that contradict those of the others can be had by a point at that
/// camera's centre, from where it projects anywhere: there the normal equations are singular. What
/// is nearer than a share of the median depth of what the image shows goes. @returns how many
/// points went.
int drop_points_at_cameras(BundleProblem& problem) {
  constexpr double kNearest = 0.05;
  const auto depth_of = [&](const BundleObservation& seen) {
    const Pose pose = pose_of_vector(problem.poses[static_cast<std::size_t>(seen.image)]);
    return (pose * problem.points[static_cast<std::size_t>(seen.point)]).z();
  };
  std::vector<std::vector<double>> depths(problem.poses.size());
  for (std::size_t i = 0; i < problem.observations.size(); ++i) {
    const BundleObservation& seen = problem.observations[i];
    if (problem.used[i]) depths[static_cast<std::size_t>(seen.image)].push_back(depth_of(seen));
  }
  std::vector<double> nearest;
  for (std::vector<double>& own : depths) {
    const auto middle = own.begin() + static_cast<std::ptrdiff_t>(own.size() / 2);
    std::nth_element(own.begin(), middle, own.end());
    nearest.push_back(own.empty() ? 0 : kNearest * *middle);
  }
  std::set<int> gone;
  for (std::size_t i = 0; i < problem.observations.size(); ++i) {
    const BundleObservation& seen = problem.observations[i];
    if (problem.used[i] && depth_of(seen) < nearest[static_cast<std::size_t>(seen.image)])
      gone.insert(seen.point);
  }
  for (const KnownPoint& known : problem.known_points) gone.erase(known.point);
  for (std::size_t i = 0; i < problem.observations.size(); ++i) {
    if (gone.contains(problem.observations[i].point)) problem.used[i] = false;
  }
  return static_cast<int>(gone.size());
}

/// Points that rejection left to fewer than two images have no place any more: what is left of them
/// goes too. @returns which points have none, `out` among them
std::vector<bool> without_place(const BundleAdjustmentInput& input, std::vector<bool> out,
                                BundleProblem& problem) {
  std::vector<std::set<int>> images(problem.points.size());
  for (std::size_t i = 0; i < problem.observations.size(); ++i) {
    const BundleObservation& seen = problem.observations[i];
    if (problem.used[i]) images[static_cast<std::size_t>(seen.point)].insert(seen.image);
  }
  std::set<int> known;
  for (const KnownPoint& k : input.known_points) known.insert(k.point);
  for (std::size_t p = 0; p < images.size(); ++p)
    out[p] = out[p] || (images[p].size() < 2 && !known.contains(static_cast<int>(p)));
  for (std::size_t i = 0; i < problem.used.size(); ++i) {
    if (out[static_cast<std::size_t>(problem.observations[i].point)]) problem.used[i] = false;
  }
  return out;
}

/// Least squares first, loosely, as the start may be far off; then a loss that turns at two
/// deviations of most residuals; then what is left beyond the limit goes until nothing does.
std::string minimise_without_outliers(BundleProblem& problem, int& iterations) {
  const BundleAdjustmentConfig asked = problem.config;
  problem.config.loss = RobustLoss::none;
  problem.config.tolerance = 1e-3;
  minimise_bundle(problem, iterations);
  constexpr int kSoftPasses = 3;
  for (int pass = 0; pass < kSoftPasses; ++pass) {
    problem.config.loss = RobustLoss::cauchy;
    problem.config.loss_px = 2 * std::max(robust_sigma(problem), 1e-6);
    minimise_bundle(problem, iterations);
  }
  problem.config = asked;
  std::string why;
  constexpr int kPasses = 10;
  for (int pass = 0; pass < kPasses; ++pass) {
    const int gone = reject(problem);
    if (gone == 0 && pass > 0) break;
    why = minimise_bundle(problem, iterations);
  }
  return why;
}

/// Makes each lens's focal lengths the mean of its images': only what is known of zooms before
/// tells a lens from zooms that all differ by one factor. Focal lengths that were held stay.
void fold_zoom(BundleProblem& problem) {
  for (std::size_t l = 0; l < problem.lenses.size(); ++l) {
    if (!problem.free[l][0] || !problem.free[l][1]) continue;
    double sum = 0;
    int images = 0;
    for (std::size_t i = 0; i < problem.zoom.size(); ++i) {
      if (problem.lens_of_image[i] != static_cast<int>(l)) continue;
      sum += problem.zoom[i];
      ++images;
    }
    if (images == 0) continue;
    const double mean = sum / images;
    problem.lenses[l].head<2>() *= mean;
    for (std::size_t i = 0; i < problem.zoom.size(); ++i) {
      if (problem.lens_of_image[i] == static_cast<int>(l)) problem.zoom[i] /= mean;
    }
  }
}

/// The part of a lens, as projection_uncertainty takes it.
CalibrationResult lens_alone(const BundleAdjustmentResult& bundle, std::size_t lens,
                             Eigen::Index from) {
  CalibrationResult alone;
  alone.cameras = {bundle.lenses[lens]};
  const std::string prefix = "lens" + std::to_string(lens) + ".";
  for (const std::string& name : bundle.parameters) {
    if (name.starts_with(prefix))
      alone.parameters.push_back("camera0." + name.substr(prefix.size()));
  }
  const auto n = static_cast<Eigen::Index>(alone.parameters.size());
  alone.values = bundle.values.segment(from, n);
  alone.covariance = bundle.covariance.block(from, from, n, n);
  return alone;
}

/// What keeps a lens, as it was found, from being one, whatever deviations say: that it folds
/// inside its image. Empty: nothing.
std::string complaint_about_lens(const Camera& lens) {
  try {
    validate(lens);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

/// Names the free parameters of a lens and those that the images do not fix.
/// @return what is wrong with its distortion as a whole; empty: nothing
std::string judge_lens(const BundleProblem& problem, std::size_t lens,
                       BundleAdjustmentResult& result) {
  const Camera& like = problem.like[lens];
  const BundleAdjustmentConfig& config = problem.config;
  const std::vector<std::string> names = lens_parameter_names(problem.shapes[lens]);
  const std::string prefix = "lens" + std::to_string(lens) + ".";
  const auto from = static_cast<Eigen::Index>(result.parameters.size());
  std::vector<std::string> bends;
  for (std::size_t k = 0; k < names.size(); ++k) {
    if (!problem.free[lens][k]) continue;
    const auto i = static_cast<Eigen::Index>(result.parameters.size());
    result.parameters.push_back(prefix + names[k]);
    result.values.conservativeResize(i + 1);
    result.values[i] = problem.lenses[lens][static_cast<Eigen::Index>(k)];
    const bool is_focal = names[k] == "fx_px" || names[k] == "fy_px";
    const bool is_centre = names[k] == "cx_px" || names[k] == "cy_px";
    if (!is_focal && !is_centre) bends.push_back(prefix + names[k]);
    const double deviation =
        result.covariance.size() > 0 ? std::sqrt(result.covariance(i, i)) : INFINITY;
    const double limit = is_focal    ? config.max_focal_share * like.fx_px
                         : is_centre ? config.max_centre_share * like.width_px
                                     : INFINITY;
    if (!(deviation <= limit)) result.not_determined.push_back(prefix + names[k]);
  }
  if (bends.empty()) return {};
  std::ostringstream why;
  if (const std::string none = complaint_about_lens(result.lenses[lens]); !none.empty()) {
    result.folds = true;
    why << prefix << none;
  } else if (result.covariance.size() > 0) {
    const double rms_px =
        rms_deviation_px(projection_uncertainty(lens_alone(result, lens, from), 0));
    const double limit_px = config.max_deviation_share * like.width_px;
    if (rms_px <= limit_px) return {};
    why << prefix << "projection has a deviation of " << rms_px << " px over the image (at most "
        << limit_px << ")";
  } else {
    return {};
  }
  result.not_determined.insert(result.not_determined.end(), bends.begin(), bends.end());
  return why.str();
}

/// @param out  points that were left out from the start
/// @param lost  points without a place, those among them
void report(const BundleProblem& problem, const BundleAdjustmentInput& input,
            const std::vector<bool>& out, const std::vector<bool>& lost,
            BundleAdjustmentResult& result) {
  result.gauge = problem.gauge;
  for (std::size_t l = 0; l < problem.lenses.size(); ++l)
    result.lenses.push_back(with_parameters(problem.like[l], problem.lenses[l]));
  for (const Vector6d& vector : problem.poses) {
    const Pose own = pose_of_vector(vector);
    Pose pose = own;
    const Vector3d centre = problem.centre_m + problem.unit_m * centre_in_world_m(own);
    pose.translation_m = -(own.rotation * centre);
    result.camera_from_world.push_back(pose);
  }
  result.zoom = problem.zoom;
  for (std::size_t p = 0; p < problem.points.size(); ++p) {
    result.points_in_world_m.push_back(
        lost[p] ? Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()).eval()
                : (problem.centre_m + problem.unit_m * problem.points[p]).eval());
  }
  for (std::size_t i = 0; i < input.observations.size(); ++i)
    result.rejected.push_back(!problem.used[i] &&
                              !out[static_cast<std::size_t>(input.observations[i].point)]);
  const BundleSquares squares = squares_of(problem);
  result.cost_px2 = squares.softened;
  result.rms_px = std::sqrt(squares.plain / std::max(1, 2 * squares.points));
  const int freedoms = freedoms_of(problem);
  if (freedoms > 0) result.sigma_px = std::sqrt(squares.softened / freedoms);
}

void add_covariance(const BundleProblem& problem, BundleAdjustmentResult& result) {
  const BundleCovariance own = bundle_covariance(problem);
  if (own.solved && std::isfinite(result.sigma_px)) {
    const double s2 = result.sigma_px * result.sigma_px;
    result.covariance = s2 * own.lens;
    for (std::size_t i = 0; i < own.poses.size(); ++i) {
      // From the cameras' middle c to the world's origin: t = t' - R c, so that a turn moves t too.
      const Vector3d middle = result.camera_from_world[i].rotation * problem.centre_m;
      Eigen::Matrix<double, 6, 6> to_world = Eigen::Matrix<double, 6, 6>::Identity();
      to_world.bottomLeftCorner<3, 3>() = cross_matrix(middle);
      to_world.bottomRightCorner<3, 3>() *= problem.unit_m;
      result.pose_covariance.emplace_back(s2 * (to_world * own.poses[i] * to_world.transpose()));
    }
  }
  std::string bent;
  for (std::size_t l = 0; l < problem.lenses.size(); ++l) {
    const std::string why = judge_lens(problem, l, result);
    if (!why.empty()) bent += (bent.empty() ? "" : "; ") + why;
  }
  if (own.solved && result.not_determined.empty()) return;
  result.status = CalibrationStatus::not_determined;
  result.reason = !bent.empty() ? bent
                  : own.solved  ? "the images do not fix these parameters to a useful deviation"
                                : "the normal equations are singular beyond the gauge";
}

}  // namespace

bool cost_has_settled(const std::vector<double>& costs) {
  constexpr std::size_t kLeastSteps = 60;
  constexpr double kNothing = 1e-3;
  if (costs.size() <= kLeastSteps) return false;
  const std::size_t third = (costs.size() - 1) / 3;
  const double fall = costs[costs.size() - 1 - third] - costs.back();
  return fall >= 0 && fall < kNothing;
}

std::string_view to_string(BundleGauge gauge) {
  switch (gauge) {
    case BundleGauge::metric:
      return "metric";
    case BundleGauge::rigid:
      return "rigid";
    case BundleGauge::similarity:
      return "similarity";
  }
  throw std::invalid_argument("gauge " + std::to_string(static_cast<int>(gauge)) +
                              " does not exist");
}

double parallax_rad(const BundleAdjustmentInput& input, int point) {
  const Vector3d& at = input.points_in_world_m.at(static_cast<std::size_t>(point));
  std::vector<Vector3d> ways;
  for (const BundleObservation& seen : input.observations) {
    if (seen.point != point) continue;
    const Pose& pose = input.camera_from_world.at(static_cast<std::size_t>(seen.image));
    ways.push_back((at - centre_in_world_m(pose)).normalized());
  }
  double widest = 0;
  for (std::size_t a = 0; a < ways.size(); ++a) {
    for (std::size_t b = a + 1; b < ways.size(); ++b)
      widest = std::max(widest, 2 * std::asin(std::min(1.0, 0.5 * (ways[a] - ways[b]).norm())));
  }
  return widest;
}

BundleAdjustmentResult adjust_bundle(const BundleAdjustmentInput& input,
                                     const BundleAdjustmentConfig& config) {
  validate(config);
  const auto start = std::chrono::steady_clock::now();
  BundleAdjustmentResult result;
  result.reason = complaint_about(input);
  if (!result.reason.empty()) {
    result.status = CalibrationStatus::bad_input;
    return result;
  }
#if !COUSIN_WITH_CERES
  result.status = CalibrationStatus::not_built;
  result.reason = "built without Ceres";
  return result;
#endif
  BundleProblem problem = make_problem(input, config);
  const std::vector<bool> out = leave_out(input, config, problem);
  if (freedoms_of(problem) <= 0) {
    result.status = CalibrationStatus::not_determined;
    result.reason = "fewer measured coordinates than unknowns";
    return result;
  }
  const std::vector<Vector6d> before = problem.poses;
  std::string why = config.reject_sigmas > 0 ? minimise_without_outliers(problem, result.iterations)
                                             : minimise_from_afar(problem, result.iterations);
  if (drop_points_at_cameras(problem) > 0) why = minimise_bundle(problem, result.iterations);
  hold_frame(before, problem);
  if (config.zoom_share > 0) fold_zoom(problem);
  result.status = why.empty() ? CalibrationStatus::ok : CalibrationStatus::not_converged;
  result.reason = why;
  report(problem, input, out, without_place(input, out, problem), result);
  add_covariance(problem, result);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace cousin
