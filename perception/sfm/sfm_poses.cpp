#include "perception/sfm/sfm_poses.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <stdexcept>
#include <utility>

#include "calibration/planar_pose.h"
#include "sim/geometry/similarity.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

constexpr double kLeastSigma_px = 1e-3;  ///< of a track's sighting, where there is no noise

/// An adjustment's start and what came of it.
struct Bundle {
  BundleAdjustmentInput input;
  BundleAdjustmentResult result;
};

/// COLMAP's own poses and lenses as if they were an adjustment's.
Bundle as_it_is(const SfmModel& model) {
  Bundle bundle;
  bundle.input = track_bundle(model, std::nullopt, 1);
  bundle.input.lenses = model.lenses;
  std::iota(bundle.input.lens_of_image.begin(), bundle.input.lens_of_image.end(), 0);
  bundle.result.status = CalibrationStatus::ok;
  bundle.result.lenses = model.lenses;
  bundle.result.camera_from_world = model.camera_from_world;
  bundle.result.points_in_world_m = bundle.input.points_in_world_m;
  bundle.result.rejected.assign(bundle.input.observations.size(), false);
  return bundle;
}

/// What an adjustment that did not succeed makes of the estimate.
void take_failure(const BundleAdjustmentResult& result, SfmEstimate& estimate) {
  estimate.reason = "adjustment: " + result.reason;
  estimate.not_determined.clear();
  for (const std::string& name : result.not_determined) {
    // With a lens an image, one image's name stands for all.
    const std::string own = name.substr(name.find('.') + 1);
    if (std::find(estimate.not_determined.begin(), estimate.not_determined.end(), own) ==
        estimate.not_determined.end())
      estimate.not_determined.push_back(own);
  }
  switch (result.status) {
    case CalibrationStatus::ok:
      return;
    case CalibrationStatus::not_determined:
      estimate.status = SfmStatus::not_determined;
      for (const std::string& name : estimate.not_determined) estimate.reason += " " + name;
      return;
    case CalibrationStatus::not_converged:
      estimate.status = SfmStatus::not_converged;
      return;
    case CalibrationStatus::bad_input:
      estimate.status = SfmStatus::no_model;
      return;
    case CalibrationStatus::not_built:
      estimate.status = SfmStatus::not_built;
      return;
  }
}

/// The whole bundle in the world `board_from_model` leads to. The start's lenses stay.
void move_bundle(const WorldSimilarity& board_from_model, Bundle& bundle) {
  for (Pose& pose : bundle.result.camera_from_world) pose = moved(pose, board_from_model);
  for (Eigen::Vector3d& point : bundle.result.points_in_world_m) point = board_from_model * point;
  for (std::size_t i = 0; i < bundle.result.pose_covariance.size(); ++i) {
    // t' = s t - R' shift: a turn of the camera moves t' too.
    const Eigen::Vector3d shift =
        bundle.result.camera_from_world[i].rotation * board_from_model.shift_m;
    Eigen::Matrix<double, 6, 6> to_board = Eigen::Matrix<double, 6, 6>::Identity();
    to_board.bottomLeftCorner<3, 3>() = cross_matrix(shift);
    to_board.bottomRightCorner<3, 3>() *= board_from_model.scale;
    Eigen::Matrix<double, 6, 6>& covariance = bundle.result.pose_covariance[i];
    covariance = (to_board * covariance * to_board.transpose()).eval();
  }
}

/// A scale that is off moves cameras along their translations.
void add_scale_covariance(double sigma_share, BundleAdjustmentResult& result) {
  for (std::size_t i = 0; i < result.pose_covariance.size(); ++i) {
    const Eigen::Vector3d along = sigma_share * result.camera_from_world[i].translation_m;
    result.pose_covariance[i].bottomRightCorner<3, 3>() += along * along.transpose();
  }
}

/// Sightings over a deviation of their own: the loss turns where it did in pixels of a track.
BundleAdjustmentConfig weighed(const SfmConfig& config, double feature_sigma_px) {
  BundleAdjustmentConfig own = config.adjust;
  own.loss_px /= std::max(feature_sigma_px, kLeastSigma_px);
  return own;
}

/// The bundle again, from where it ended, with the board's corners as known points.
BundleAdjustmentInput with_board(const Bundle& bundle, const std::vector<BoardCorner>& corners,
                                 const SeedBoard& board, const SfmConfig& config) {
  BundleAdjustmentInput input = bundle.input;
  input.camera_from_world = bundle.result.camera_from_world;
  const double sigma_px = std::max(bundle.result.sigma_px, kLeastSigma_px);
  std::vector<BundleObservation> kept;
  for (BundleObservation seen : input.observations) {
    if (!bundle.result.points_in_world_m[static_cast<std::size_t>(seen.point)].allFinite())
      continue;
    seen.sigma_px *= sigma_px;
    kept.push_back(seen);
  }
  for (std::size_t p = 0; p < input.points_in_world_m.size(); ++p) {
    if (bundle.result.points_in_world_m[p].allFinite())
      input.points_in_world_m[p] = bundle.result.points_in_world_m[p];
  }
  input.observations = std::move(kept);
  for (const BoardCorner& corner : corners) {
    const auto point = static_cast<int>(input.points_in_world_m.size());
    const Eigen::Vector3d known = corner_in_world_m(board, corner.column, corner.row);
    input.points_in_world_m.push_back(known);
    input.known_points.push_back({point, known, config.board_sigma_m});
    for (BundleObservation seen : corner.observations) {
      seen.point = point;
      input.observations.push_back(seen);
    }
  }
  return input;
}

/// Each image its own focal lengths about the shared ones; all else of the lens stays.
BundleAdjustmentResult adjust_focal_lengths(BundleAdjustmentInput& input,
                                            const BundleAdjustmentResult& shared,
                                            double feature_sigma_px, const SfmConfig& config) {
  input.lenses.assign(input.camera_from_world.size(), shared.lenses.at(0));
  std::iota(input.lens_of_image.begin(), input.lens_of_image.end(), 0);
  input.camera_from_world = shared.camera_from_world;
  for (std::size_t p = 0; p < input.points_in_world_m.size(); ++p) {
    if (shared.points_in_world_m[p].allFinite())
      input.points_in_world_m[p] = shared.points_in_world_m[p];
  }
  BundleAdjustmentConfig own = weighed(config, feature_sigma_px);
  own.fixed = {"cx_px", "cy_px", "k1", "k2", "k3", "k4", "k5",
               "k6",    "p1",    "p2", "s1", "s2", "s3", "s4"};
  own.focal_prior_share = config.focal_jitter;
  return adjust_bundle(input, own);
}

struct ImageResiduals {
  double sum_px2 = 0;
  int points = 0;
};

/// Squared residuals of each image's sightings that count.
std::vector<ImageResiduals> residuals(const Bundle& bundle) {
  std::vector<ImageResiduals> squares(bundle.result.camera_from_world.size());
  std::vector<Lens> lenses;
  for (const Camera& lens : bundle.result.lenses) lenses.emplace_back(lens);
  for (std::size_t i = 0; i < bundle.input.observations.size(); ++i) {
    const BundleObservation& seen = bundle.input.observations[i];
    const Eigen::Vector3d& point =
        bundle.result.points_in_world_m[static_cast<std::size_t>(seen.point)];
    if (bundle.result.rejected[i] || !point.allFinite()) continue;
    const auto image = static_cast<std::size_t>(seen.image);
    const Lens& lens = lenses[static_cast<std::size_t>(bundle.input.lens_of_image[image])];
    const auto pixel_px = lens.project(bundle.result.camera_from_world[image] * point);
    if (!pixel_px) continue;
    squares[image].sum_px2 += (*pixel_px - seen.pixel_px).squaredNorm();
    ++squares[image].points;
  }
  return squares;
}

/// The bundle's poses, lens and points into the estimate.
void report(const Bundle& bundle, const SfmModel& model, bool good, SfmEstimate& estimate) {
  const std::vector<ImageResiduals> squares = residuals(bundle);
  for (std::size_t i = 0; i < model.images.size(); ++i) {
    FramePose& pose = estimate.poses.at(static_cast<std::size_t>(model.images[i]));
    pose.status = good ? PoseStatus::ok : PoseStatus::degenerate;
    pose.camera_from_world = bundle.result.camera_from_world[i];
    pose.camera = bundle.result.lenses[static_cast<std::size_t>(bundle.input.lens_of_image[i])];
    if (i < bundle.result.pose_covariance.size())
      pose.covariance = bundle.result.pose_covariance[i];
    pose.corner_count = squares[i].points;
    pose.rms_px = std::sqrt(squares[i].sum_px2 / std::max(1, 2 * squares[i].points));
  }
  estimate.lens = mean_lens(bundle.result.lenses);
  estimate.gauge = bundle.result.gauge;
  for (std::size_t p = 0; p < model.points.size(); ++p) {
    if (!bundle.result.points_in_world_m[p].allFinite()) continue;
    estimate.points.push_back(model.points[p]);
    estimate.points.back().in_world_m = bundle.result.points_in_world_m[p];
  }
}

/// The lens as all images share it, with its covariance.
void report_lens(const BundleAdjustmentResult& result, SfmEstimate& estimate) {
  estimate.lens_parameters.clear();
  for (const std::string& name : result.parameters)
    estimate.lens_parameters.push_back(name.substr(name.find('.') + 1));
  estimate.lens_covariance = result.covariance;
}

void lose_frames(const SfmModel& model, const std::vector<int>& frames, SfmEstimate& estimate) {
  const std::set<int> placed(model.images.begin(), model.images.end());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    estimate.poses.push_back({.frame = frames[i], .status = PoseStatus::not_converged});
    if (!placed.contains(static_cast<int>(i))) estimate.lost.push_back(frames[i]);
  }
  if (estimate.lost.empty()) return;
  estimate.status = SfmStatus::partly_registered;
  estimate.reason = std::to_string(estimate.lost.size()) + " of " + std::to_string(frames.size()) +
                    " frames found no place:";
  constexpr std::size_t kMostNamed = 20;
  for (std::size_t i = 0; i < std::min(kMostNamed, estimate.lost.size()); ++i)
    estimate.reason += " " + std::to_string(estimate.lost[i]);
  if (estimate.lost.size() > kMostNamed) estimate.reason += " ...";
}

void refuse_scale(const std::string& why, SfmEstimate& estimate) {
  estimate.reason += (estimate.reason.empty() ? "" : "; ") + why;
  estimate.status = SfmStatus::no_scale;
}

/// Deviation of the focal length over itself; 0 where it was not solved for. Where it is off by a
/// share, cameras stand off by the same share from what they look at, and so does a model's scale.
double focal_share(const SfmEstimate& estimate, const Bundle& bundle) {
  const auto& names = estimate.lens_parameters;
  const auto at = std::find(names.begin(), names.end(), "fx_px");
  if (at == names.end() || bundle.result.lenses.empty()) return 0;
  const auto i = static_cast<Eigen::Index>(at - names.begin());
  if (i >= estimate.lens_covariance.rows()) return 0;
  return std::sqrt(estimate.lens_covariance(i, i)) / bundle.result.lenses.front().fx_px;
}

/// Brings the bundle into the board's frame in metres. @returns false where the adjustment failed
bool scale_bundle(const SfmModel& model, const Corners& corners, const SeedBoard& board,
                  const SfmConfig& config, Bundle& bundle, SfmEstimate& estimate) {
  const std::vector<BoardCorner> found = board_corners(
      bundle.result, bundle.input.lens_of_image, model.images, corners, config.corner_floor_px);
  if (static_cast<int>(found.size()) < config.min_board_corners) {
    refuse_scale(std::to_string(found.size()) + " corners of the board were placed, at least " +
                     std::to_string(config.min_board_corners) + " are needed",
                 estimate);
    return true;
  }
  std::vector<Eigen::Vector3d> true_m, in_model;
  for (const BoardCorner& corner : found) {
    true_m.push_back(corner_in_world_m(board, corner.column, corner.row));
    in_model.push_back(corner.in_world_m);
  }
  SimilarityFit fit = fit_similarity(true_m, in_model);
  if (!fit.ok) {
    refuse_scale("the board's corners lie on a line", estimate);
    return true;
  }
  if (config.scale == SfmScale::squares) {
    const SquareScale squares = scale_by_squares(board, found);
    if (!(squares.scale > 0)) {
      refuse_scale("no two corners of the board are neighbours", estimate);
      return true;
    }
    for (Eigen::Vector3d& point : in_model) point *= squares.scale;
    fit = fit_similarity(true_m, in_model, ScaleFreedom::fixed);
    fit.a_from_b.scale = squares.scale;
    fit.scale_sigma_share = squares.sigma_share;
  }
  estimate.metres_per_unit = fit.a_from_b.scale;
  estimate.scale_sigma_share = std::hypot(fit.scale_sigma_share, focal_share(estimate, bundle));
  move_bundle(fit.a_from_b, bundle);
  bundle.result.gauge = BundleGauge::metric;
  if (config.scale == SfmScale::squares) {
    add_scale_covariance(fit.scale_sigma_share, bundle.result);
    return true;
  }
  bundle.input = with_board(bundle, found, board, config);
  bundle.result = adjust_bundle(bundle.input, weighed(config, estimate.feature_sigma_px));
  return bundle.result.status == CalibrationStatus::ok;
}

}  // namespace

Camera mean_lens(const std::vector<Camera>& lenses) {
  Camera mean = lenses.at(0);
  const auto n = static_cast<double>(lenses.size());
  mean.fx_px = mean.fy_px = 0;
  for (const Camera& lens : lenses) {
    mean.fx_px += lens.fx_px / n;
    mean.fy_px += lens.fy_px / n;
  }
  return mean;
}

SfmEstimate refine_sfm(const SfmModel& model, const std::vector<int>& frames,
                       const std::optional<Camera>& lens, const Corners& corners,
                       const SeedBoard& board, const SfmConfig& config) {
  validate(config);
  if (!corners.empty() && corners.size() != frames.size()) {
    throw std::invalid_argument("refine_sfm: corners of " + std::to_string(corners.size()) +
                                " frames for " + std::to_string(frames.size()));
  }
  const StageClock clock("adjust");
  SfmEstimate estimate;
  estimate.status = SfmStatus::ok;
  lose_frames(model, frames, estimate);
  Bundle bundle;
  if (config.refine) {
    bundle.input = track_bundle(model, lens, 1);
    bundle.result = adjust_bundle(bundle.input, config.adjust);
    estimate.feature_sigma_px = bundle.result.sigma_px;
    report_lens(bundle.result, estimate);
  } else {
    bundle = as_it_is(model);
  }
  bool good = bundle.result.status == CalibrationStatus::ok;
  const bool wants_scale = config.scale != SfmScale::none;
  if (good && wants_scale && corners.empty()) refuse_scale("there is no board", estimate);
  if (good && wants_scale && !corners.empty()) {
    good = scale_bundle(model, corners, board, config, bundle, estimate);
    if (good && config.scale == SfmScale::adjusted && bundle.result.gauge == BundleGauge::metric)
      report_lens(bundle.result, estimate);
  }
  if (good && config.refine && config.focal == SfmFocal::per_image) {
    // With the board in it, sightings are over their deviation; else they are in pixels.
    const bool is_weighed =
        config.scale == SfmScale::adjusted && bundle.result.gauge == BundleGauge::metric;
    bundle.result = adjust_focal_lengths(bundle.input, bundle.result,
                                         is_weighed ? estimate.feature_sigma_px : 1, config);
    good = bundle.result.status == CalibrationStatus::ok;
  }
  if (!good) take_failure(bundle.result, estimate);
  if (!bundle.result.camera_from_world.empty()) report(bundle, model, good, estimate);
  estimate.timings.push_back(clock.finish());
  return estimate;
}

}  // namespace cousin
