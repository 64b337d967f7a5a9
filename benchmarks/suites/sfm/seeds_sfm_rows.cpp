#include <algorithm>
#include <cmath>
#include <optional>

#include "benchmarks/loop/seeds_run.h"
#include "benchmarks/suites/sfm/sfm_rows.h"
#include "calibration/boards/board_poses.h"
#include "calibration/solve/calibration_uncertainty.h"
#include "perception/sfm/self_calibration.h"
#include "perception/sfm/sfm_poses.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

/// Poses while the middle row is read, and lenses, as they were.
struct TrueCameras {
  std::vector<Pose> poses;
  std::vector<Camera> lenses;
};
TrueCameras true_cameras(const SceneTruth& truth) {
  TrueCameras result;
  for (const TrueView& view : truth.views) {
    result.poses.push_back(interpolate(view.camera_from_world, view.camera_from_world_end, 0.5));
    result.lenses.push_back(view.camera);
  }
  return result;
}

void add(std::vector<ScoreRow> more, std::vector<ScoreRow>& rows) {
  rows.insert(rows.end(), more.begin(), more.end());
}

SfmConfig with_folder(SfmConfig config, const SfmSuiteConfig& suite, const std::string& name) {
  config.colmap.program = suite.program;
  config.colmap.threads = suite.threads;
  config.colmap.folder = (suite.folder / name).string();
  return config;
}

/// Errors of the metric poses; where there is no scale, after a similarity.
std::vector<ScoreRow> estimate_rows(const ScoreRow& row, const SfmEstimate& estimate,
                                    const TrueCameras& truth) {
  const auto n = static_cast<std::int64_t>(estimate.poses.size());
  if (!has_poses(estimate.status)) return {unsolved_row(row, estimate.reason, estimate.status)};
  std::vector<ScoreRow> rows;
  const auto placed = static_cast<double>(estimate.poses.size() - estimate.lost.size());
  rows.push_back(numbered(row, "views placed", placed, "1", n));
  rows.push_back(numbered(row, "views placed by the board alone",
                          static_cast<double>(estimate.by_board.size()), "1", n));
  rows.push_back(numbered(row, "views whose place the board denied",
                          static_cast<double>(estimate.contradicted.size()), "1", n));
  rows.push_back(
      numbered(row, "COLMAP's models", static_cast<double>(estimate.model_sizes.size()), "1", n));
  if (!estimate.images.empty()) {
    std::int64_t features = 0, alone = 0;
    for (const ImageMatches& image : estimate.images) {
      features += image.features;
      alone += image.partners == 0 ? 1 : 0;
    }
    rows.push_back(numbered(row, "features a view, mean",
                            static_cast<double>(features) / static_cast<double>(n), "1", n));
    rows.push_back(
        numbered(row, "views without a verified pair", static_cast<double>(alone), "1", n));
  }
  for (const StageTiming& timing : estimate.timings) {
    ScoreRow seconds = numbered(row, "seconds of " + timing.stage, timing.wall_s, "s", n);
    seconds.wall_s = timing.wall_s;
    seconds.cpu_s = timing.cpu_s;
    rows.push_back(seconds);
  }
  if (estimate.gauge == BundleGauge::metric) {
    add(pose_rows(row, score_poses(estimate.poses, truth.poses, truth.lenses)), rows);
    rows.push_back(
        numbered(row, "scale, predicted relative deviation", estimate.scale_sigma_share, "1", n));
  }
  ScoreRow aligned = row;
  aligned.case_name += ", after a similarity";
  const PoseScore score =
      score_poses(estimate.poses, truth.poses, truth.lenses, PoseAlignment::similarity);
  add(pose_rows(aligned, score), rows);
  if (estimate.gauge == BundleGauge::metric)
    rows.push_back(numbered(aligned, "scale, relative error", 1 / score.scale - 1, "1", n));
  rows.push_back(numbered(aligned, "focal length, RMS relative error", score.focal_rms, "1", n));
  return rows;
}

/// The board's corners alone, without COLMAP.
std::vector<ScoreRow> board_rows(const SfmSuiteConfig& suite, const Capture& capture,
                                 const Corners& corners, const TrueCameras& truth) {
  const ScoreRow row = sfm_row(suite, "seeds", "board alone");
  const StageClock clock("board_poses");
  const Poses poses = estimate_board_poses(capture, corners, SeedBoard{});
  const StageTiming timing = clock.finish();
  ScoreRow timed = row;
  timed.wall_s = timing.wall_s;
  timed.cpu_s = timing.cpu_s;
  const PoseScore score = score_poses(poses, truth.poses, truth.lenses);
  std::vector<ScoreRow> rows = {
      numbered(timed, "views placed", score.posed, "1", static_cast<std::int64_t>(poses.size()))};
  add(pose_rows(timed, score), rows);
  return rows;
}

/// The lens from the tracks of what lies on the board, nothing of it known.
std::vector<ScoreRow> lens_rows(const SfmSuiteConfig& suite, const SfmModel& model,
                                const Camera& reported, const Camera& truth) {
  const ScoreRow row = sfm_row(suite, "seeds", "lens from the capture itself");
  const SelfCalibration found = self_calibrate(model, reported);
  std::vector<ScoreRow> rows;
  rows.push_back(numbered(row, "RMS spread of the optical axes", found.geometry.axes_rad, "rad",
                          found.observations));
  rows.push_back(
      numbered(row, "flatness of the points", found.geometry.flatness, "1", found.observations));
  rows.push_back(
      numbered(row, "median parallax", found.geometry.parallax_rad, "rad", found.observations));
  if (found.status != CalibrationStatus::ok) {
    rows.push_back(missing_row(row, std::string(to_string(found.status)) + ": " + found.reason,
                               found.status == CalibrationStatus::not_built
                                   ? ScoreStatus::not_built
                                   : ScoreStatus::not_solved));
    return rows;
  }
  const double off = found.lens.fx_px - truth.fx_px, sigma = deviation(found, "fx_px");
  rows.push_back(
      numbered(row, "focal length, relative error", off / truth.fx_px, "1", found.observations));
  rows.push_back(numbered(row, "focal length, predicted relative deviation", sigma / truth.fx_px,
                          "1", found.observations));
  rows.push_back(
      numbered(row, "focal length, error over deviation", off / sigma, "1", found.observations));
  // Of `ok` the deviation over the image is within a limit: three of it are the most by chance.
  const double limit_px = 3 * SelfCalibrationConfig{}.adjust.max_deviation_share * truth.width_px;
  rows.push_back(at_most(row, "projection error, RMS over the image",
                         projection_difference(truth, found.lens).rms_px, "px", found.observations,
                         limit_px));
  return rows;
}

}  // namespace

RunConfig seeds_sfm_scene(const SfmSuiteConfig& config) {
  return seeds_run_config({std::string("views=") + (config.quick ? "30" : "60")});
}

std::vector<ScoreRow> seeds_sfm_rows(const SfmSuiteConfig& config, const Progress& progress) {
  const ScoreRow row = sfm_row(config, "seeds", "ours");
  if (colmap_version(config.program).empty())
    return {missing_row(row, "COLMAP was not found", ScoreStatus::not_built)};
  const SimulatedRun run =
      simulate(seeds_sfm_scene(config), config.seed, 0, TruthNeeds{}, progress);
  const TrueCameras truth = true_cameras(run.truth);
  const Corners corners = detect_board(run.capture, SeedBoard{});
  std::vector<ScoreRow> rows = board_rows(config, run.capture, corners, truth);
  const SfmConfig ours = with_folder({}, config, "seeds_ours");
  add(estimate_rows(row, estimate_poses_sfm(run.capture, corners, SeedBoard{}, ours), truth), rows);
  // COLMAP's files are there: it does not run again.
  SfmConfig zooming = ours;
  zooming.focal = SfmFocal::per_image;
  add(estimate_rows(sfm_row(config, "seeds", "ours, a focal length an image"),
                    estimate_poses_sfm(run.capture, corners, SeedBoard{}, zooming), truth),
      rows);
  const SfmConfig paper = with_folder(paper_sfm_config(), config, "seeds_paper");
  add(estimate_rows(sfm_row(config, "seeds", "paper: self-calibration, one factor"),
                    estimate_poses_sfm(run.capture, corners, SeedBoard{}, paper), truth),
      rows);
  // The same run once more: its files are there.
  ColmapInput input;
  for (const Frame& frame : run.capture.frames)
    input.images.push_back(&frame.sensors.front().color);
  input.pairs = image_pairs(static_cast<int>(input.images.size()), paper.pairs);
  const ColmapRun tracks = run_colmap(input, paper.colmap);
  if (tracks.status == ColmapStatus::ok) {
    add(lens_rows(config, tracks.model, run.capture.rig.front().camera, mean_lens(truth.lenses)),
        rows);
  }
  return rows;
}

}  // namespace cousin
