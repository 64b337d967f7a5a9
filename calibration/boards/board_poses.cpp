#include "calibration/boards/board_poses.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "calibration/boards/board_bundle.h"
#include "calibration/boards/planar_pose.h"
#include "sim/config/limits.h"

namespace cousin {
namespace {

void check_input(const Capture& capture, const Corners& corners, const SeedBoard& board) {
  if (corners.size() != capture.frames.size()) {
    throw std::invalid_argument("corners of " + std::to_string(corners.size()) +
                                " frames for a capture of " +
                                std::to_string(capture.frames.size()));
  }
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const std::string frame = "frame " + std::to_string(capture.frames[i].id);
    if (corners[i].frame != capture.frames[i].id) {
      throw std::invalid_argument(frame + ": its corners are of frame " +
                                  std::to_string(corners[i].frame));
    }
    if (capture.frames[i].sensors.empty()) throw std::invalid_argument(frame + " has no sensor");
    const Camera& reported = capture.frames[i].sensors.front().reported;
    validate(reported);
    const Camera& first = capture.frames.front().sensors.front().reported;
    if (reported.model != first.model) {
      throw std::invalid_argument(frame + ": reports another lens model than frame " +
                                  std::to_string(capture.frames.front().id) +
                                  "; all frames share one lens");
    }
    for (const CornerObservation& c : corners[i].corners) {
      if (!corner_exists(board, c.column, c.row) || !c.pixel_px.allFinite() ||
          !c.covariance_px2.allFinite() || !(c.covariance_px2(0, 0) > 0) ||
          !(c.covariance_px2.determinant() >
            1e-12 * c.covariance_px2(0, 0) * c.covariance_px2(1, 1))) {
        throw std::invalid_argument(frame + ": corner (" + std::to_string(c.column) + ", " +
                                    std::to_string(c.row) +
                                    ") is not on the board, or its pixel is not finite or its "
                                    "covariance not positive definite");
      }
    }
  }
}

std::vector<BoardPoint> points_of(const FrameCorners& frame, const SeedBoard& board) {
  std::vector<BoardPoint> points;
  for (const CornerObservation& c : frame.corners) {
    points.push_back({corner_in_world_m(board, c.column, c.row), c.pixel_px, c.covariance_px2});
  }
  return points;
}

}  // namespace

Fields fields(BoardPosesConfig& config) {
  return {
      {"refine_lens", &config.refine_lens, "shared lens over all views; false: as reported"},
      {"min_views_for_lens", &config.min_views_for_lens,
       "with fewer views the lens stays as reported", 2, 1e6},
      {"focal_prior", &config.focal_prior, "relative sigma of the focal lengths' common factor",
       1e-8, 1},
      {"focus_law", &config.focus_law,
       "images' focal lengths follow the thin lens law, if they do"},
      {"focus_law_jitter", &config.focus_law_jitter,
       "relative sigma of one image's focal length about that law", 1e-8, 1},
      {"focal_jitter", &config.focal_jitter, "relative sigma of one image's focal length", 1e-8, 1},
      {"centre_prior_px_per_width", &config.centre_prior_px_per_width,
       "sigma of the principal point, over the width", 1e-8, 1},
      {"distortion_prior", &config.distortion_prior, "sigma of each distortion coefficient", 1e-8,
       10},
      {"sheet_bend_m", &config.sheet_bend_m,
       "sigma of a printed sheet's bends, solved for where corners fit no plane; 0 = flat", 0,
       0.01},
      {"hand_speed_m_per_s", &config.hand_speed_m_per_s,
       "sigma of the velocity while reading; 0 = still", 0, 10},
      {"hand_rate_rad_per_s", &config.hand_rate_rad_per_s,
       "sigma of the turning rate while reading; 0 = still", 0, 10},
      {"corner_floor_px", &config.corner_floor_px, "added in quadrature to each corner's sigma", 0,
       10},
      {"max_rms_px", &config.max_rms_px, "views that fit worse are not_converged", 1e-3, 100},
      {"max_iterations", &config.max_iterations, "of the bundle adjustment", 1, 1000},
  };
}

void validate(const BoardPosesConfig& config) {
  BoardPosesConfig copy = config;
  check_limits(fields(copy));
}

namespace {

/// Replaces the reported focal lengths by a thin lens' at the distances found [image distance over
/// focal length = 1 + f / (d - f)]: one line through all views' focal lengths over 1 / (d - f).
/// False, and nothing changed, where they do not follow such a law.
bool follow_focus_law(const BundleResult& found, std::vector<BundleView>& views) {
  constexpr std::size_t kLeastViews = 8;
  constexpr double kLeastSpread = 0.15;     // of 1 / d, largest over smallest less one
  constexpr double kLargestMisfit = 0.002;  // relative, root mean square
  constexpr double kLongestFocal_m = 0.03;
  if (views.size() < kLeastViews) return false;
  std::vector<double> distances_m;
  for (const BundleResult::View& view : found.views) {
    distances_m.push_back(view.camera_from_board.translation_m.norm());
  }
  const auto [nearest, farthest] = std::minmax_element(distances_m.begin(), distances_m.end());
  if (!(*nearest > 2 * kLongestFocal_m) || !(*farthest > (1 + kLeastSpread) * *nearest))
    return false;
  const auto n = static_cast<double>(views.size());
  double focal_m = 0, at_infinity_px = 0;
  for (int round = 0; round < 3; ++round) {
    double sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (std::size_t i = 0; i < views.size(); ++i) {
      const double x = 1 / (distances_m[i] - focal_m), y = views[i].reported.fx_px;
      sx += x;
      sy += y;
      sxx += x * x;
      sxy += x * y;
    }
    const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
    at_infinity_px = (sy - slope * sx) / n;
    focal_m = slope / at_infinity_px;
    if (!(at_infinity_px > 0) || !(focal_m > 0) || focal_m > kLongestFocal_m) return false;
  }
  std::vector<double> factors;
  double squares = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const double law_px = at_infinity_px * (1 + focal_m / (distances_m[i] - focal_m));
    factors.push_back(law_px / views[i].reported.fx_px);
    squares += (factors.back() - 1) * (factors.back() - 1) / n;
  }
  if (!(squares < kLargestMisfit * kLargestMisfit)) return false;
  for (std::size_t i = 0; i < views.size(); ++i) {
    views[i].reported.fx_px *= factors[i];
    views[i].reported.fy_px *= factors[i];
    views[i].camera_from_board = found.views[i].camera_from_board;
  }
  return true;
}

}  // namespace

Poses estimate_board_poses(const Capture& capture, const Corners& corners, const SeedBoard& board,
                           const BoardPosesConfig& config) {
  validate(config);
  validate(board);
  check_input(capture, corners, board);
  // A still hand has no motion to solve for; neither has a global shutter.
  const bool moving = config.hand_speed_m_per_s > 0 && config.hand_rate_rad_per_s > 0;
  const bool rolling =
      moving && !capture.rig.empty() && capture.rig.front().shutter == Shutter::rolling;
  const double readout_s = rolling ? capture.rig.front().readout_s : 0;

  Poses poses(corners.size());
  std::vector<BundleView> views(corners.size());
  tbb::parallel_for(std::size_t{0}, corners.size(), [&](std::size_t i) {
    FramePose& pose = poses[i];
    pose.frame = corners[i].frame;
    pose.camera = capture.frames[i].sensors.front().reported;
    if (corners[i].status != BoardStatus::ok) return;
    pose.corner_count = static_cast<int>(corners[i].corners.size());
    views[i] = {pose.camera, points_of(corners[i], board), {}, readout_s};
    const PlanarPose start = estimate_planar_pose(pose.camera, views[i].points);
    views[i].camera_from_board = start.camera_from_board;
    pose.status = start.ok ? PoseStatus::ok : PoseStatus::degenerate;
  });

  std::vector<std::size_t> used;
  std::vector<BundleView> solved;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (poses[i].status != PoseStatus::ok) continue;
    used.push_back(i);
    solved.push_back(std::move(views[i]));
  }
  BundleResult result = bundle_adjust(solved, config);
  constexpr double kMostMisfit = 3;
  bool is_bent = false;
  const bool is_plane = result.converged && !(result.misfit > kMostMisfit);
  if (result.adjusted && config.refine_lens && config.sheet_bend_m > 0 && !is_plane) {
    BundleResult bent = bundle_adjust(solved, config, true);
    if (bent.converged && bent.misfit < result.misfit) {
      result = std::move(bent);
      is_bent = true;
    }
  }
  if (config.focus_law && config.refine_lens && result.converged && result.adjusted &&
      follow_focus_law(result, solved)) {
    BoardPosesConfig held = config;
    held.focal_jitter = config.focus_law_jitter;
    result = bundle_adjust(solved, held, is_bent);
  }
  for (std::size_t k = 0; k < used.size(); ++k) {
    FramePose& pose = poses[used[k]];
    const BundleResult::View& view = result.views[k];
    pose.camera_from_world = view.camera_from_board;
    pose.camera = view.camera;
    pose.covariance = view.covariance;
    pose.rms_px = view.rms_px;
    const bool fits = result.converged && view.rms_px <= config.max_rms_px;
    if (!fits) pose.status = PoseStatus::not_converged;
  }
  return poses;
}

}  // namespace cousin
