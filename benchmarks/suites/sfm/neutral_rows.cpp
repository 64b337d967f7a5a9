#include <algorithm>
#include <filesystem>
#include <optional>

#include "benchmarks/suites/sfm/sfm_rows.h"
#include "perception/sfm/sfm_poses.h"
#include "sim/dataset/import.h"

namespace cousin {
namespace {

/// What a choice of pairs cost and gave.
struct PairsRun {
  std::vector<ScoreRow> rows;
  bool solved = false;
  double matching_wall_s = 0, matching_cpu_s = 0;
  int placed = 0;
};

std::vector<Pose> true_poses(const Capture& capture) {
  std::vector<Pose> poses;
  for (const Frame& frame : capture.frames) poses.push_back(frame.rig_from_world.value());
  return poses;
}

void add(std::vector<ScoreRow> more, std::vector<ScoreRow>& rows) {
  rows.insert(rows.end(), more.begin(), more.end());
}

SfmConfig pairs_config(const SfmSuiteConfig& suite, PairChoice choice) {
  SfmConfig config;
  config.pairs.choice = choice;
  config.scale = SfmScale::none;
  config.colmap.program = suite.program;
  config.colmap.threads = suite.threads;
  config.colmap.match_lost = false;  // what the pairs alone are worth
  config.colmap.folder = (suite.folder / ("neutral_" + std::string(to_string(choice)))).string();
  return config;
}

void add_adjusted_rows(const ScoreRow& row, const SfmEstimate& estimate, const Capture& capture,
                       const std::vector<Pose>& truth, bool refine, std::vector<ScoreRow>& rows) {
  ScoreRow own = row;
  own.method += refine ? ", our adjustment" : ", COLMAP's own";
  if (!has_poses(estimate.status)) {
    rows.push_back(unsolved_row(own, estimate.reason, estimate.status));
    return;
  }
  own.wall_s = estimate.timings.back().wall_s;
  own.cpu_s = estimate.timings.back().cpu_s;
  const auto n = static_cast<std::int64_t>(capture.frames.size());
  add(pose_rows(own, score_poses(estimate.poses, truth, {}, PoseAlignment::similarity)), rows);
  rows.push_back(numbered(own, "focal length, relative error",
                          estimate.lens.fx_px / capture.rig.front().camera.fx_px - 1, "1", n));
  if (refine) {
    rows.push_back(numbered(own, "sighting's deviation", estimate.feature_sigma_px, "px", n));
  }
}

PairsRun run_pairs(const SfmSuiteConfig& suite, const Capture& capture, PairChoice choice) {
  PairsRun result;
  const std::string name(to_string(choice));
  const ScoreRow row = sfm_row(suite, "neutral", name + " pairs");
  SfmConfig config = pairs_config(suite, choice);
  ColmapInput input;
  std::vector<int> frames;
  for (const Frame& frame : capture.frames) {
    input.images.push_back(&frame.sensors.front().color);
    frames.push_back(frame.id);
  }
  const std::optional<Camera> lens = capture.rig.front().camera;
  input.lens = lens;
  input.pairs = image_pairs(static_cast<int>(frames.size()), config.pairs);
  const ColmapRun run = run_colmap(input, config.colmap);
  const auto n = static_cast<std::int64_t>(frames.size());
  if (run.status != ColmapStatus::ok) {
    result.rows.push_back(unsolved_row(row, run.reason, sfm_status_of(run.status)));
    return result;
  }
  result.solved = true;
  result.placed = static_cast<int>(run.model.images.size());
  result.rows.push_back(
      numbered(row, "pairs matched", static_cast<double>(input.pairs.size()), "1", n));
  for (const StageTiming& timing : run.timings) {
    ScoreRow seconds = numbered(row, "seconds of " + timing.stage, timing.wall_s, "s", n);
    seconds.wall_s = timing.wall_s;
    seconds.cpu_s = timing.cpu_s;
    result.rows.push_back(seconds);
    if (timing.stage != "matches") continue;
    result.matching_wall_s = timing.wall_s;
    result.matching_cpu_s = timing.cpu_s;
  }
  result.rows.push_back(numbered(row, "views placed", result.placed, "1", n));
  const std::vector<Pose> truth = true_poses(capture);
  for (const bool refine : {false, true}) {
    config.refine = refine;
    const SfmEstimate estimate = refine_sfm(run.model, frames, lens, {}, {}, config);
    add_adjusted_rows(row, estimate, capture, truth, refine, result.rows);
  }
  return result;
}

}  // namespace

std::vector<ScoreRow> neutral_rows(const SfmSuiteConfig& config) {
  const std::filesystem::path file = config.neutral / "transforms.json";
  if (!std::filesystem::exists(file)) {
    return {missing_row(sfm_row(config, "neutral", "ours"), "absent: " + file.string(),
                        ScoreStatus::not_built)};
  }
  const Capture capture = import_nerfstudio(file);
  const PairsRun ordered = run_pairs(config, capture, PairChoice::ordered);
  std::vector<ScoreRow> rows = ordered.rows;
  if (!ordered.solved) return rows;
  const PairsRun all = run_pairs(config, capture, PairChoice::exhaustive);
  add(all.rows, rows);
  if (!all.solved) return rows;
  const ScoreRow row = sfm_row(config, "neutral", "ordered against exhaustive");
  const auto n = static_cast<std::int64_t>(capture.frames.size());
  // The processor's seconds: other work on the machine does not change them much.
  rows.push_back(at_most(row, "CPU seconds of matching over all pairs'",
                         ordered.matching_cpu_s / all.matching_cpu_s, "1", n, 1.0 / 3));
  rows.push_back(numbered(row, "seconds of matching over all pairs'",
                          ordered.matching_wall_s / all.matching_wall_s, "1", n));
  rows.push_back(at_most(row, "views lost", static_cast<double>(n) - ordered.placed, "1", n, 0));
  return rows;
}

}  // namespace cousin
