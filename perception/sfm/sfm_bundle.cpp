#include "perception/sfm/sfm_bundle.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <utility>

#include "calibration/boards/planar_pose.h"
#include "perception/sfm/track_bundle.h"

namespace cousin {
namespace {

struct ImageResiduals {
  double sum_px2 = 0;
  int points = 0;
};

/// Squared residuals of each image's sightings that count.
std::vector<ImageResiduals> residuals(const SfmBundle& bundle) {
  std::vector<ImageResiduals> squares(bundle.result.camera_from_world.size());
  std::vector<Lens> lenses;
  for (const Camera& lens : image_lenses(bundle)) lenses.emplace_back(lens);
  for (std::size_t i = 0; i < bundle.input.observations.size(); ++i) {
    const BundleObservation& seen = bundle.input.observations[i];
    const Eigen::Vector3d& point =
        bundle.result.points_in_world_m[static_cast<std::size_t>(seen.point)];
    if (bundle.result.rejected[i] || !point.allFinite()) continue;
    const auto image = static_cast<std::size_t>(seen.image);
    const auto pixel_px = lenses[image].project(bundle.result.camera_from_world[image] * point);
    if (!pixel_px) continue;
    squares[image].sum_px2 += (*pixel_px - seen.pixel_px).squaredNorm();
    ++squares[image].points;
  }
  return squares;
}

}  // namespace

std::vector<Camera> image_lenses(const SfmBundle& bundle) {
  std::vector<Camera> lenses;
  for (std::size_t i = 0; i < bundle.input.lens_of_image.size(); ++i) {
    lenses.push_back(
        bundle.result.lenses.at(static_cast<std::size_t>(bundle.input.lens_of_image[i])));
    if (bundle.result.zoom.empty()) continue;  // as COLMAP left it
    lenses.back().fx_px *= bundle.result.zoom.at(i);
    lenses.back().fy_px *= bundle.result.zoom.at(i);
  }
  return lenses;
}

SfmBundle as_it_is(const SfmModel& model) {
  SfmBundle bundle;
  bundle.images = model.images;
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

void take_failure(const BundleAdjustmentResult& result, SfmEstimate& estimate) {
  if (result.status == CalibrationStatus::ok) return;
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

void move_bundle(const WorldSimilarity& board_from_model, SfmBundle& bundle) {
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

void add_scale_covariance(double sigma_share, BundleAdjustmentResult& result) {
  for (std::size_t i = 0; i < result.pose_covariance.size(); ++i) {
    const Eigen::Vector3d along = sigma_share * result.camera_from_world[i].translation_m;
    result.pose_covariance[i].bottomRightCorner<3, 3>() += along * along.transpose();
  }
}

void report_poses(const SfmBundle& bundle, const SfmModel& model, bool good,
                  SfmEstimate& estimate) {
  const std::vector<ImageResiduals> squares = residuals(bundle);
  const std::vector<Camera> lenses = image_lenses(bundle);
  for (std::size_t i = 0; i < bundle.images.size(); ++i) {
    FramePose& pose = estimate.poses.at(static_cast<std::size_t>(bundle.images[i]));
    pose.status = good ? PoseStatus::ok : PoseStatus::degenerate;
    pose.camera_from_world = bundle.result.camera_from_world[i];
    pose.camera = lenses[i];
    if (i < bundle.result.pose_covariance.size())
      pose.covariance = bundle.result.pose_covariance[i];
    pose.corner_count = squares[i].points;
    if (squares[i].points > 0)
      pose.rms_px = std::sqrt(squares[i].sum_px2 / (2 * squares[i].points));
  }
  estimate.lens = mean_lens(lenses);
  estimate.gauge = bundle.result.gauge;
  for (std::size_t p = 0; p < model.points.size(); ++p) {
    if (!bundle.result.points_in_world_m[p].allFinite()) continue;
    estimate.points.push_back(model.points[p]);
    estimate.points.back().in_world_m = bundle.result.points_in_world_m[p];
  }
}

void report_lens(const BundleAdjustmentResult& result, SfmEstimate& estimate) {
  estimate.lens_parameters.clear();
  for (const std::string& name : result.parameters)
    estimate.lens_parameters.push_back(name.substr(name.find('.') + 1));
  estimate.lens_covariance = result.covariance;
}

void lose_frames(const SfmBundle& bundle, const std::vector<int>& frames, SfmEstimate& estimate) {
  const std::set<int> placed(bundle.images.begin(), bundle.images.end());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (!placed.contains(static_cast<int>(i))) estimate.lost.push_back(frames[i]);
  }
  if (estimate.lost.empty()) return;
  if (estimate.status == SfmStatus::ok) estimate.status = SfmStatus::partly_registered;
  std::string reason = std::to_string(estimate.lost.size()) + " of " +
                       std::to_string(frames.size()) + " frames found no place:";
  constexpr std::size_t kMostNamed = 20;
  for (std::size_t i = 0; i < std::min(kMostNamed, estimate.lost.size()); ++i)
    reason += " " + std::to_string(estimate.lost[i]);
  if (estimate.lost.size() > kMostNamed) reason += " ...";
  estimate.reason = reason + (estimate.reason.empty() ? "" : "; ") + estimate.reason;
}

}  // namespace cousin
