#include "benchmarks/tools/measure/board_lens.h"

#include <algorithm>
#include <vector>

#include "calibration/boards/board_detection.h"
#include "calibration/boards/board_poses.h"

namespace cousin {
namespace {

constexpr std::size_t kMostViews = 24;

/// Evenly spread over all frames.
Capture some_of(const Capture& capture) {
  Capture some;
  some.pipeline = capture.pipeline;
  some.board = capture.board;
  some.rig = capture.rig;
  const std::size_t all = capture.frames.size(), count = std::min(all, kMostViews);
  for (std::size_t i = 0; i < count; ++i) some.frames.push_back(capture.frames[i * all / count]);
  return some;
}

/// The camera of the posed view whose focal length is the median one; null without any.
const Camera* middle_camera(const Poses& poses, int& posed) {
  std::vector<const Camera*> cameras;
  for (const FramePose& pose : poses) {
    if (pose.status == PoseStatus::ok) cameras.push_back(&pose.camera);
  }
  posed = static_cast<int>(cameras.size());
  if (cameras.empty()) return nullptr;
  const auto middle = cameras.begin() + static_cast<std::ptrdiff_t>(cameras.size() / 2);
  std::nth_element(cameras.begin(), middle, cameras.end(),
                   [](const Camera* a, const Camera* b) { return a->fx_px < b->fx_px; });
  return *middle;
}

void report_lens(const Camera& lens, Capture& capture) {
  for (Frame& frame : capture.frames) frame.sensors.front().reported = lens;
  for (SensorReport& sensor : capture.rig) sensor.camera = lens;
}

}  // namespace

void trust_the_board(SeedsPipelineConfig& config) {
  config.poses.focal_prior = 0.25;
  config.poses.focal_jitter = 0.003;
  config.poses.centre_prior_px_per_width = 0.02;
  config.poses.distortion_prior = 0.2;
}

BoardLens take_lens_of_board(const SeedsPipelineConfig& config, Capture& capture) {
  BoardLens found;
  if (capture.frames.empty()) return found;
  Capture some = some_of(capture);
  const SeedBoard board = board_of(capture, config);
  const Corners corners = detect_board(some, board, config.board);
  for (int round = 0; round < 2; ++round) {
    const Poses poses = estimate_board_poses(some, corners, board, config.poses);
    const Camera* lens = middle_camera(poses, found.views);
    if (lens == nullptr) return found;
    found.focal_px = lens->fx_px;
    report_lens(*lens, capture);
    report_lens(*lens, some);
  }
  return found;
}

}  // namespace cousin
