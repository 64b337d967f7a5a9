#include "perception/sfm/sfm_poses.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>
#include <utility>

#include "calibration/boards/planar_pose.h"
#include "perception/sfm/board_views.h"
#include "perception/sfm/sfm_bundle.h"
#include "sim/geometry/similarity.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

constexpr double kLeastSigma_px = 1e-3;  ///< of a track's sighting, where there is no noise

/// Sightings over a deviation of their own: the loss turns where it did in pixels of a track.
BundleAdjustmentConfig weighed(const SfmConfig& config, double feature_sigma_px) {
  BundleAdjustmentConfig own = config.adjust;
  own.loss_px /= std::max(feature_sigma_px, kLeastSigma_px);
  if (config.focal == SfmFocal::per_image) own.zoom_share = config.focal_jitter;
  return own;
}

/// The bundle again, from where it ended, with the board's corners as known points.
BundleAdjustmentInput with_board(const SfmBundle& bundle, const std::vector<BoardCorner>& corners,
                                 const SeedBoard& board, const SfmConfig& config,
                                 CornerPoints& points) {
  BundleAdjustmentInput input = bundle.input;
  input.camera_from_world = bundle.result.camera_from_world;
  // Of a sighting of one pixel: the least is of what it scatters, whatever it was weighed by
  // before.
  const double sigma_px =
      std::max(bundle.sighting_px * bundle.result.sigma_px, kLeastSigma_px) / bundle.sighting_px;
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
    points[{corner.row, corner.column}] = point;
    for (BundleObservation seen : corner.observations) {
      seen.point = point;
      input.observations.push_back(seen);
    }
  }
  return input;
}

/// Images that the board places start where it says. From where the tracks alone left them, some
/// centimetres off, an image's corners may all count as outliers, and a few wrong tracks then take
/// it anywhere.
void start_at_board(const Corners& corners, const SeedBoard& board, const SfmConfig& config,
                    SfmBundle& bundle) {
  for (std::size_t i = 0; i < bundle.images.size(); ++i) {
    const std::optional<Pose> own = camera_from_board(
        bundle.result.lenses.at(0), corners.at(static_cast<std::size_t>(bundle.images[i])), board,
        {.min_corners = config.min_board_corners});
    if (own) bundle.input.camera_from_world[i] = *own;
  }
}

void refuse_scale(const std::string& why, SfmEstimate& estimate) {
  estimate.reason += (estimate.reason.empty() ? "" : "; ") + why;
  estimate.status = SfmStatus::no_scale;
}

/// Deviation of the focal length over itself; 0 where it was not solved for. Where it is off by a
/// share, cameras stand off by the same share from what they look at, and so does a model's scale.
double focal_share(const SfmEstimate& estimate, const SfmBundle& bundle) {
  const auto& names = estimate.lens_parameters;
  const auto at = std::find(names.begin(), names.end(), "fx_px");
  if (at == names.end() || bundle.result.lenses.empty()) return 0;
  const auto i = static_cast<Eigen::Index>(at - names.begin());
  if (i >= estimate.lens_covariance.rows()) return 0;
  return std::sqrt(estimate.lens_covariance(i, i)) / bundle.result.lenses.front().fx_px;
}

/// Whether something other than sightings bears on the lens: then their deviation matters.
bool has_lens_prior(const SfmConfig& config) {
  return config.adjust.focal_prior_share > 0 || config.adjust.centre_prior_px > 0 ||
         config.adjust.distortion_prior > 0 || config.focal == SfmFocal::per_image;
}

/// A lens that the model itself estimated was found by the sightings that are to be adjusted: it is
/// where they start, and no knowledge beside them.
SfmConfig without_lens_prior(SfmConfig config) {
  config.adjust.focal_prior_share = 0;
  config.adjust.centre_prior_px = 0;
  config.adjust.distortion_prior = 0;
  return config;
}

/// Sightings in the middle of the images alone may bend the lens back on itself in the corners. It
/// is then adjusted once more with what bends it most as it was.
BundleAdjustmentResult adjust_unfolded(const BundleAdjustmentInput& input,
                                       BundleAdjustmentConfig config) {
  BundleAdjustmentResult result = adjust_bundle(input, config);
  if (!result.folds) return result;
  for (const char* name : {"k2", "k3", "k4", "k5", "k6"}) config.fixed.emplace_back(name);
  return adjust_bundle(input, config);
}

/// The model's own adjustment: sightings count as a pixel each, which is right up to a factor. What
/// is known of the lens has a deviation of its own, so that with it the sightings are weighed by
/// what they turned out to scatter, and all is adjusted once more.
SfmBundle adjust_tracks(const SfmModel& model, const std::optional<Camera>& lens,
                        const SfmConfig& config) {
  SfmBundle bundle;
  bundle.images = model.images;
  bundle.input = track_bundle(model, lens, 1);
  bundle.result = adjust_unfolded(bundle.input, config.adjust);
  if (!has_lens_prior(config)) return bundle;
  // What one focal length for all leaves of the images' own is no scatter of sightings.
  const int passes = config.focal == SfmFocal::per_image ? 2 : 1;
  for (int pass = 0; pass < passes && std::isfinite(bundle.result.sigma_px); ++pass) {
    const double factor =
        std::max(bundle.sighting_px * bundle.result.sigma_px, kLeastSigma_px) / bundle.sighting_px;
    bundle.sighting_px *= factor;
    for (BundleObservation& seen : bundle.input.observations) seen.sigma_px *= factor;
    bundle.result = adjust_unfolded(bundle.input, weighed(config, bundle.sighting_px));
  }
  return bundle;
}

/// Without images whose sightings do not determine a pose: three leave four, and points that no
/// other image shows leave any. They would make the whole adjustment singular.
SfmModel without_blind_images(SfmModel model) {
  constexpr int kLeastSightings = 4;
  while (true) {
    std::map<int, int> sightings;
    for (const SfmPoint& point : model.points) {
      if (point.sightings.size() < 2) continue;
      for (const SfmSighting& seen : point.sightings) ++sightings[seen.image];
    }
    std::vector<int> blind;
    for (std::size_t i = 0; i < model.images.size(); ++i) {
      if (sightings[model.images[i]] < kLeastSightings) blind.push_back(static_cast<int>(i));
    }
    if (blind.empty()) return model;
    model =
        without_images(model, blind);  // and points of one image left, so that others may follow
  }
}

/// Takes images that the board contradicts out of an adjusted model, and adjusts what is left.
/// @returns false where the board contradicts the model as a whole: the estimate says so
bool keep_what_agrees(const std::vector<int>& frames, const std::optional<Camera>& lens,
                      const Corners& corners, const SeedBoard& board, const SfmConfig& config,
                      SfmModel& model, SfmBundle& bundle, SfmEstimate& estimate) {
  const BoardAgreement agreement = board_agreement(
      bundle.result.camera_from_world, model.images, bundle.result.lenses.at(0), corners, board,
      config.max_board_turn_rad, {.min_corners = config.min_board_corners});
  if (agreement.against.empty()) return true;
  for (const int image : agreement.against)
    estimate.contradicted.push_back(
        frames[static_cast<std::size_t>(model.images[static_cast<std::size_t>(image)])]);
  // Two of many images agree by chance, and a half may be either half.
  if (agreement.with < 3 || 2 * agreement.with <= agreement.seen) {
    estimate.status = SfmStatus::contradicted;
    estimate.reason = "of " + std::to_string(agreement.seen) +
                      " placed images that show the board, at most " +
                      std::to_string(agreement.with) + " agree where it stands";
    return false;
  }
  model = without_blind_images(without_images(model, agreement.against));
  bundle = adjust_tracks(model, lens, config);
  return true;
}

/// @returns false where an adjusted image is not where its own corners say: the estimate says so
bool stayed_at_board(const std::vector<int>& frames, const Corners& corners, const SeedBoard& board,
                     const SfmConfig& config, const SfmBundle& bundle, SfmEstimate& estimate) {
  std::string left;
  for (std::size_t i = 0; i < bundle.images.size(); ++i) {
    const auto image = static_cast<std::size_t>(bundle.images[i]);
    const std::optional<Pose> own =
        camera_from_board(bundle.result.lenses.at(0), corners.at(image), board,
                          {.min_corners = config.min_board_corners});
    const Pose& adjusted = bundle.result.camera_from_world[i];
    if (!own || own->rotation.angularDistance(adjusted.rotation) <= config.max_board_turn_rad)
      continue;
    estimate.contradicted.push_back(frames[image]);
    left += " " + std::to_string(frames[image]);
  }
  if (left.empty()) return true;
  estimate.status = SfmStatus::contradicted;
  estimate.reason = "the adjustment turned these frames away from where the board is:" + left;
  return false;
}

/// Brings the bundle into the board's frame in metres. @returns false where the adjustment failed
bool scale_bundle(const std::vector<int>& frames, const Corners& corners, const SeedBoard& board,
                  const SfmConfig& config, SfmBundle& bundle, SfmEstimate& estimate) {
  const std::vector<BoardCorner> found = board_corners(
      bundle.result, image_lenses(bundle), bundle.images, corners, config.corner_floor_px);
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
      refuse_scale(
          std::to_string(squares.sides) +
              " of the board's sides have both corners in the model; at least 2 are needed",
          estimate);
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
    add_scale_covariance(estimate.scale_sigma_share, bundle.result);
    return true;
  }
  CornerPoints points;
  bundle.input = with_board(bundle, found, board, config, points);
  start_at_board(corners, board, config, bundle);
  if (config.place_by_board) {
    for (const int image :
         add_board_views(bundle.result.lenses.at(0), corners, board, config.board_sigma_m,
                         config.corner_floor_px, {.min_corners = config.min_board_corners},
                         bundle.input, bundle.images, points))
      estimate.by_board.push_back(frames[static_cast<std::size_t>(image)]);
  }
  bundle.result = adjust_bundle(bundle.input, weighed(config, estimate.feature_sigma_px));
  return bundle.result.status == CalibrationStatus::ok &&
         stayed_at_board(frames, corners, board, config, bundle, estimate);
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

SfmEstimate refine_sfm(const SfmModel& given, const std::vector<int>& frames,
                       const std::optional<Camera>& lens, const Corners& corners,
                       const SeedBoard& board, const SfmConfig& asked) {
  validate(asked);
  const SfmConfig config = lens ? asked : without_lens_prior(asked);
  if (!corners.empty() && corners.size() != frames.size()) {
    throw std::invalid_argument("refine_sfm: corners of " + std::to_string(corners.size()) +
                                " frames for " + std::to_string(frames.size()));
  }
  const StageClock clock("adjust");
  SfmEstimate estimate;
  estimate.status = SfmStatus::ok;
  for (const int frame : frames)
    estimate.poses.push_back({.frame = frame, .status = PoseStatus::not_converged});
  SfmModel model = config.refine ? without_blind_images(given) : given;
  SfmBundle bundle = config.refine ? adjust_tracks(model, lens, config) : as_it_is(model);
  bool good = bundle.result.status == CalibrationStatus::ok;
  const bool wants_scale = config.scale != SfmScale::none;
  bool agrees = true;
  if (good && config.refine && wants_scale && !corners.empty()) {
    agrees = keep_what_agrees(frames, lens, corners, board, config, model, bundle, estimate);
    good = agrees && bundle.result.status == CalibrationStatus::ok;
  }
  if (config.refine) {
    estimate.feature_sigma_px = bundle.sighting_px * bundle.result.sigma_px;
    report_lens(bundle.result, estimate);
  }
  if (good && wants_scale && corners.empty()) refuse_scale("there is no board", estimate);
  if (good && wants_scale && !corners.empty()) {
    good = scale_bundle(frames, corners, board, config, bundle, estimate);
    if (good && config.scale == SfmScale::adjusted && bundle.result.gauge == BundleGauge::metric)
      report_lens(bundle.result, estimate);
  }
  if (agrees) take_failure(bundle.result, estimate);
  lose_frames(bundle, frames, estimate);
  if (!bundle.result.camera_from_world.empty()) report_poses(bundle, model, good, estimate);
  estimate.timings.push_back(clock.finish());
  return estimate;
}

}  // namespace cousin
