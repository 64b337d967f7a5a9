#include <algorithm>
#include <stdexcept>

#include "perception/sfm/sfm_poses.h"
#include "sim/types/stage_clock.h"

namespace cousin {

SfmStatus sfm_status_of(ColmapStatus status) {
  switch (status) {
    case ColmapStatus::ok:
      return SfmStatus::ok;
    case ColmapStatus::too_few_images:
      return SfmStatus::too_few_images;
    case ColmapStatus::not_built:
      return SfmStatus::not_built;
    case ColmapStatus::program_failed:
      return SfmStatus::program_failed;
    case ColmapStatus::timed_out:
      return SfmStatus::timed_out;
    case ColmapStatus::no_model:
      return SfmStatus::no_model;
    case ColmapStatus::no_lens:
      return SfmStatus::not_determined;
  }
  throw std::logic_error("a status of COLMAP's run is not known");
}

namespace {

/// The lens that the first sensor reports, its focal lengths the mean of what frames report.
Camera reported_lens(const Capture& capture) {
  Camera lens = capture.frames.front().sensors.front().reported;
  const auto n = static_cast<double>(capture.frames.size());
  lens.fx_px = lens.fy_px = 0;
  for (const Frame& frame : capture.frames) {
    const Camera& reported = frame.sensors.front().reported;
    if (reported.model != lens.model || reported.width_px != lens.width_px ||
        reported.height_px != lens.height_px) {
      throw std::invalid_argument("estimate_poses_sfm: frame " + std::to_string(frame.id) +
                                  " reports another lens model or image size than frame " +
                                  std::to_string(capture.frames.front().id) +
                                  "; all frames share one lens");
    }
    lens.fx_px += frame.sensors.front().reported.fx_px / n;
    lens.fy_px += frame.sensors.front().reported.fy_px / n;
  }
  return lens;
}

void require_colour(const Capture& capture) {
  for (const Frame& frame : capture.frames) {
    if (frame.sensors.empty() || frame.sensors.front().color.empty()) {
      throw std::invalid_argument("estimate_poses_sfm: frame " + std::to_string(frame.id) +
                                  " has no colour image");
    }
  }
}

SeedBoard named_board(const std::string& name) {
  SeedBoard board;
  board.has_markers = name != "plain";
  return board;
}

/// Features and matches of frames without a place, the first few.
std::string why_lost(const std::vector<int>& frames, const std::vector<int>& lost,
                     const std::vector<ImageMatches>& images) {
  constexpr int kMostNamed = 5;
  std::string text;
  int named = 0;
  for (std::size_t i = 0; i < std::min(frames.size(), images.size()); ++i) {
    if (std::find(lost.begin(), lost.end(), frames[i]) == lost.end()) continue;
    if (++named > kMostNamed) return text + "; ...";
    text += "; frame " + std::to_string(frames[i]) + ": " + std::to_string(images[i].features) +
            " features, matched with " + std::to_string(images[i].tried) + ", of which " +
            std::to_string(images[i].partners) + " agree";
  }
  return text;
}

SfmEstimate estimate(const Capture& capture, const Corners& corners, const SeedBoard& board,
                     const SfmConfig& config) {
  ColmapInput input;
  std::vector<int> frames;
  for (const Frame& frame : capture.frames) {
    input.images.push_back(&frame.sensors.front().color);
    frames.push_back(frame.id);
  }
  input.pairs = image_pairs(static_cast<int>(frames.size()), config.pairs);
  std::optional<Camera> lens;
  if (config.colmap.lens != ColmapLens::self && !capture.frames.empty())
    lens = reported_lens(capture);
  input.lens = lens;
  ColmapRun run;
  if (frames.empty()) {
    run.status = ColmapStatus::too_few_images;
    run.reason = "the capture has no frames";
  } else {
    run = run_colmap(input, config.colmap);
  }
  SfmEstimate result;
  if (run.status == ColmapStatus::ok) {
    result = refine_sfm(run.model, frames, lens, corners, board, config);
    if (!run.reason.empty()) result.reason += (result.reason.empty() ? "" : "; ") + run.reason;
  } else {
    result.status = sfm_status_of(run.status);
    result.reason = run.reason;
    result.lost = frames;
    for (const int frame : frames)
      result.poses.push_back({.frame = frame, .status = PoseStatus::not_converged});
  }
  if (run.status != ColmapStatus::no_lens)
    result.reason += why_lost(frames, result.lost, run.images);
  result.images = run.images;
  result.colmap_version = run.version;
  result.model_sizes = run.model_sizes;
  result.done_before = run.done_before;
  result.timings.insert(result.timings.begin(), run.timings.begin(), run.timings.end());
  return result;
}

}  // namespace

void require_sfm() {}  // it is here

SfmEstimate estimate_poses_sfm(const Capture& capture, const Corners& corners,
                               const SeedBoard& board, const SfmConfig& config) {
  validate(config);
  require_colour(capture);
  if (corners.size() != capture.frames.size()) {
    throw std::invalid_argument("estimate_poses_sfm: corners of " + std::to_string(corners.size()) +
                                " frames for " + std::to_string(capture.frames.size()));
  }
  return estimate(capture, corners, board, config);
}

SfmEstimate estimate_poses_sfm(const Capture& capture, const SfmConfig& config) {
  validate(config);
  require_colour(capture);
  const SeedBoard board = named_board(capture.board);
  const bool has_board = capture.board == "markers" || capture.board == "plain";
  if (config.scale == SfmScale::none || !has_board) return estimate(capture, {}, board, config);
  const StageClock clock("board");
  const Corners corners = detect_board(capture, board, config.board);
  const StageTiming timing = clock.finish();
  SfmEstimate result = estimate(capture, corners, board, config);
  result.timings.insert(result.timings.begin(), timing);
  return result;
}

}  // namespace cousin
