#include "perception/sfm/board_views.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "calibration/boards/planar_pose.h"

namespace cousin {

std::optional<Pose> camera_from_board(const Camera& lens, const FrameCorners& corners,
                                      const SeedBoard& board, const BoardViewConfig& config) {
  if (corners.status != BoardStatus::ok ||
      static_cast<int>(corners.corners.size()) < config.min_corners)
    return {};
  std::vector<BoardPoint> points;
  for (const CornerObservation& corner : corners.corners) {
    points.push_back({corner_in_world_m(board, corner.column, corner.row), corner.pixel_px,
                      corner.covariance_px2});
  }
  const PlanarPose pose = estimate_planar_pose(lens, points);
  if (!pose.ok || pose.is_ambiguous || !(pose.rms_px <= config.max_rms_px)) return {};
  return pose.camera_from_board;
}

BoardAgreement board_agreement(const std::vector<Pose>& camera_from_world,
                               const std::vector<int>& images, const Camera& lens,
                               const Corners& corners, const SeedBoard& board, double most_rad,
                               const BoardViewConfig& config) {
  std::vector<int> seen;
  std::vector<Eigen::Quaterniond> board_from_model;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const auto pose =
        camera_from_board(lens, corners.at(static_cast<std::size_t>(images[i])), board, config);
    if (!pose) continue;
    seen.push_back(static_cast<int>(i));
    board_from_model.emplace_back(pose->rotation.conjugate() * camera_from_world[i].rotation);
  }
  BoardAgreement result;
  result.seen = static_cast<int>(seen.size());
  std::size_t best = 0;
  const auto agree = [&](std::size_t a, std::size_t b) {
    return board_from_model[a].angularDistance(board_from_model[b]) <= most_rad;
  };
  for (std::size_t a = 0; a < seen.size(); ++a) {
    int with = 0;
    for (std::size_t b = 0; b < seen.size(); ++b) with += agree(a, b) ? 1 : 0;
    if (with <= result.with) continue;
    result.with = with;
    best = a;
  }
  for (std::size_t b = 0; b < seen.size(); ++b) {
    if (!agree(best, b)) result.against.push_back(seen[b]);
  }
  return result;
}

SfmModel without_images(const SfmModel& model, const std::vector<int>& gone) {
  SfmModel rest;
  std::set<int> kept;
  for (std::size_t i = 0; i < model.images.size(); ++i) {
    if (std::binary_search(gone.begin(), gone.end(), static_cast<int>(i))) continue;
    kept.insert(model.images[i]);
    rest.images.push_back(model.images[i]);
    rest.lenses.push_back(model.lenses[i]);
    rest.camera_from_world.push_back(model.camera_from_world[i]);
  }
  for (const SfmPoint& point : model.points) {
    SfmPoint own{point.in_world_m, point.color, {}};
    for (const SfmSighting& seen : point.sightings) {
      if (kept.contains(seen.image)) own.sightings.push_back(seen);
    }
    if (own.sightings.size() >= 2) rest.points.push_back(std::move(own));
  }
  return rest;
}

std::vector<int> add_board_views(const Camera& lens, const Corners& corners, const SeedBoard& board,
                                 double sigma_m, double floor_px, const BoardViewConfig& config,
                                 BundleAdjustmentInput& bundle, std::vector<int>& images,
                                 CornerPoints& points) {
  const std::set<int> placed(images.begin(), images.end());
  std::vector<int> added;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (placed.contains(static_cast<int>(i))) continue;
    const auto pose = camera_from_board(lens, corners[i], board, config);
    if (!pose) continue;
    const auto image = static_cast<int>(bundle.camera_from_world.size());
    added.push_back(static_cast<int>(i));
    images.push_back(static_cast<int>(i));
    bundle.camera_from_world.push_back(*pose);
    bundle.lens_of_image.push_back(0);
    for (const CornerObservation& corner : corners[i].corners) {
      const auto next = static_cast<int>(bundle.points_in_world_m.size());
      const auto [at, is_new] = points.try_emplace({corner.row, corner.column}, next);
      if (is_new) {
        const Eigen::Vector3d known = corner_in_world_m(board, corner.column, corner.row);
        bundle.points_in_world_m.push_back(known);
        bundle.known_points.push_back({next, known, sigma_m});
      }
      bundle.observations.push_back({image, at->second, corner.pixel_px,
                                     std::hypot(rms_sigma_px(corner.covariance_px2), floor_px)});
    }
  }
  return added;
}

}  // namespace cousin
