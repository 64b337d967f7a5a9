#include "benchmarks/loop/pipeline_run.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "benchmarks/loop/perceive_views.h"
#include "benchmarks/loop/score_depths.h"
#include "benchmarks/loop/score_views.h"
#include "benchmarks/loop/seeds_report.h"
#include "benchmarks/loop/specimens_text.h"
#include "benchmarks/loop/splat_images.h"
#include "benchmarks/loop/views_report.h"
#include "perception/pipelines/seeds.h"
#include "perception/pipelines/views.h"
#include "sim/dataset/manifest.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

// ---- Of any pipeline
// -----------------------------------------------------------------------------

/// Says which views have no pose and why; the number of those that have one.
int count_posed(const Poses& poses, const Corners& corners, const Warn& warn) {
  int posed = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (poses[i].status == PoseStatus::ok) {
      ++posed;
      continue;
    }
    std::string why(to_string(poses[i].status));
    if (i < corners.size() && corners[i].status != BoardStatus::ok) {
      why += " (" + std::string(to_string(corners[i].status)) + ")";
    }
    if (warn) warn("view " + std::to_string(poses[i].frame) + " has no pose: " + why);
  }
  return posed;
}

/// Whether no stage found anything that could be measured; what is only seen has no cluster.
bool found_nothing(const Estimate& estimate) {
  if (estimate.traits.empty()) return true;
  const std::vector<int>& instance = estimate.clusters.instance;
  return std::all_of(instance.begin(), instance.end(), [](int i) { return i < 0; }) &&
         std::none_of(estimate.traits.begin(), estimate.traits.end(),
                      [](const SpecimenTraits& s) { return s.status == TraitStatus::ok; });
}

std::string no_gaussians_text(const SplatModel& none) {
  return "no Gaussians" + (none.why_none.empty() ? "" : ": " + none.why_none);
}

/// "3 of 4 frames have depth, 62 % of their pixels; 410233 points".
std::string depths_text(const Estimate& estimate) {
  std::size_t frames = 0, pixels = 0, known = 0;
  for (const FrameDepth& frame : estimate.depths) {
    if (frame.depth_m.empty()) continue;
    ++frames;
    pixels += frame.depth_m.size();
    known += static_cast<std::size_t>(std::count_if(frame.depth_m.begin(), frame.depth_m.end(),
                                                    [](float z) { return !std::isnan(z); }));
  }
  char text[160];
  std::snprintf(
      text, sizeof text, "%zu of %zu frames have depth, %.0f %% of their pixels", frames,
      estimate.depths.size(),
      100 * static_cast<double>(known) / static_cast<double>(std::max<std::size_t>(1, pixels)));
  std::string all = text;
  if (!estimate.cloud.empty()) all += "; " + std::to_string(estimate.cloud.size()) + " points";
  return all;
}

// ---- Why nothing was found
// -----------------------------------------------------------------------

/// Where all of the views are, and nothing was found from Gaussians.
std::string why_no_splats(const Estimate& estimate, const SeedsPipelineConfig& config) {
  const std::string count = std::to_string(estimate.splats.splats.size());
  if (estimate.splats.splats.empty()) return no_gaussians_text(estimate.splats);
  if (config.method == SeedsMethod::splats_paper)
    return "of " + count + " Gaussians none has its centre in the volume and an opacity of " +
           "splats.least_opacity";
  return "the depths of " + count + " Gaussians agree in no views";
}

std::string why_no_poses(const Estimate& estimate) {
  const auto seen =
      std::count_if(estimate.corners.begin(), estimate.corners.end(),
                    [](const FrameCorners& corners) { return corners.status == BoardStatus::ok; });
  const bool no_image = std::all_of(
      estimate.corners.begin(), estimate.corners.end(),
      [](const FrameCorners& corners) { return corners.status == BoardStatus::no_image; });
  if (!estimate.corners.empty() && no_image) return "the capture has no colour images";
  return seen == 0 ? "no view shows the board"
                   : std::to_string(seen) + " views show the board, but none could be posed";
}

/// Which stage found nothing first, if there is no specimen.
std::string why_nothing(const Estimate& estimate, const SeedsPipelineConfig& config, int posed) {
  if (!estimate.cloud.empty() || !estimate.clusters.cloud.empty())
    return estimate.traits.empty() ? "nothing stands on the board"
                                   : "no object has enough points of the cloud";
  if (posed == 0) return why_no_poses(estimate);
  if (config.method == SeedsMethod::splats || config.method == SeedsMethod::splats_paper)
    return why_no_splats(estimate, config);
  const bool some_depth =
      std::any_of(estimate.depths.begin(), estimate.depths.end(), [](const FrameDepth& frame) {
        return std::any_of(frame.depth_m.begin(), frame.depth_m.end(),
                           [](float depth_m) { return !std::isnan(depth_m); });
      });
  return some_depth ? "the views agree on no depth"
                    : "no view has depth, which takes more views beside it";
}

std::string why_nothing(const Estimate& estimate, const PipelineConfig& config, int posed) {
  if (const auto* seeds = config.get_if<SeedsPipelineConfig>())
    return why_nothing(estimate, *seeds, posed);
  if (row_of(config).traits_of == TraitsOf::plants)
    return estimate.keypoints.empty() ? "no keypoints" : "no plant is measured";
  return estimate.boxes.empty() ? "no boxes" : "no box is measured";
}

// ---- What each kind of pipeline makes
// ------------------------------------------------------------

PerceivedScene perceive_traits(const PerceiveTask& task, const Progress& progress,
                               const Warn& warn) {
  PerceivedScene made;
  made.estimate = perceive(task.capture, task.config, task.seed, task.sources, task.scene_index,
                           task.estimate_dir, progress, warn, task.outside);
  const Estimate& estimate = made.estimate;
  for (const std::string& note : *estimate.notes) {
    if (warn) warn(note);
  }
  if (row_of(task.config).traits_of == TraitsOf::depths) {
    made.summary = depths_text(estimate);
    return made;
  }
  const int posed = count_posed(estimate.poses, estimate.corners, warn);
  if (!estimate.poses.empty())
    made.summary = std::to_string(posed) + " of " + std::to_string(task.capture.frames.size()) +
                   " views posed, ";
  made.summary += specimens_text(estimate.traits);
  made.unmeasured = unmeasured_lines(estimate.traits);
  if (found_nothing(estimate)) {
    made.nothing = why_nothing(estimate, task.config, posed);
    made.summary += ": " + made.nothing;
  }
  return made;
}

std::string number_of(const std::vector<ScoreRow>& rows, const std::string& metric) {
  for (const ScoreRow& row : rows) {
    if (row.metric != metric) continue;
    char text[64];
    std::snprintf(text, sizeof text, "%.2f %s of %lld views", row.value, row.unit.c_str(),
                  static_cast<long long>(row.n));
    return text;
  }
  return {};
}

PerceivedScene perceive_whole(const PerceiveTask& task, const ViewsPipelineConfig& config,
                              const Progress& progress, const Warn& warn) {
  ViewsRun run = perceive_views(task.capture, config, task.seed, task.sources, task.scene_index,
                                task.name, task.estimate_dir, progress, warn, task.learned);
  PerceivedScene made;
  made.estimate = std::move(run.estimate);
  made.rows = std::move(run.rows);
  const Poses& poses = made.estimate.poses;
  const auto posed = std::count_if(poses.begin(), poses.end(), [](const FramePose& pose) {
    return pose.status == PoseStatus::ok;
  });
  made.summary = std::to_string(posed) + " of " + std::to_string(task.capture.frames.size()) +
                 " views posed, " + std::to_string(made.estimate.splats.splats.size()) +
                 " Gaussians";
  for (const auto& [metric, words] :
       {std::pair("train.psnr", "trained on"), std::pair("held_out.psnr", "held out")}) {
    const std::string number = number_of(made.rows, metric);
    if (!number.empty()) made.summary += ", " + std::string(words) + " " + number;
  }
  if (made.estimate.splats.splats.empty()) made.nothing = no_gaussians_text(made.estimate.splats);
  return made;
}

/// Rows beside those of traits: how Gaussians look beside all photographs.
std::vector<ScoreRow> more_rows(const SimulatedRun& run, const PerceivedScene& made,
                                const PipelineConfig& config, const SeedsScoreLabels& labels) {
  constexpr std::size_t kAllViews = std::numeric_limits<std::size_t>::max();
  const auto* seeds = config.get_if<SeedsPipelineConfig>();
  if (!seeds) return {};
  return splat_image_rows(run.capture, made.estimate, *seeds, labels, nullptr, kAllViews);
}

ScoreFile score_whole(const SimulatedRun& run, const PerceivedScene& made, PoseAlignment alignment,
                      const SeedsScoreLabels& labels) {
  ScoreRow base = labelled_row(labels);
  base.case_name = "photographs";
  ScoreFile file;
  file.scores =
      score_views(run.truth, made.estimate, alignment, !made.estimate.cloud.empty(), base);
  // The pipeline's own rows have its seconds too.
  std::erase_if(file.scores,
                [](const ScoreRow& row) { return row.metric.starts_with("seconds."); });
  for (ScoreRow row : made.rows) {
    row.suite = base.suite;
    file.scores.push_back(std::move(row));
  }
  return file;
}

}  // namespace

PerceivedScene perceive_scene(const PerceiveTask& task, const Progress& progress,
                              const Warn& warn) {
  const auto* views = task.config.get_if<ViewsPipelineConfig>();
  return views ? perceive_whole(task, *views, progress, warn)
               : perceive_traits(task, progress, warn);
}

ScoreFile score_scene(const SimulatedRun& run, const PerceivedScene& made,
                      const PipelineConfig& config, PoseAlignment alignment,
                      const SeedsScoreLabels& labels) {
  const TraitsOf traits_of = row_of(config).traits_of;
  if (traits_of == TraitsOf::nothing) return score_whole(run, made, alignment, labels);
  if (traits_of == TraitsOf::depths)
    return {
        .header = {}, .scores = score_depths(run.truth, made.estimate, labels), .specimens = {}};
  SeedsScores scores =
      score_estimate(traits_of, run.truth, made.estimate, labels, row_of(config).traits);
  ScoreFile file;
  file.scores = std::move(scores.rows);
  file.specimens = std::move(scores.specimens);
  append({.scores = more_rows(run, made, config, labels)}, file);
  return file;
}

ReportScene page_scene(const std::string& name, const SimulatedRun& run, const PerceivedScene& made,
                       const PipelineConfig& config, const fs::path& estimate_dir) {
  if (row_of(config).traits_of == TraitsOf::nothing)
    return views_report_scene(estimate_dir, run.truth);
  return report_scene(name, run, made.estimate);
}

std::string user_folders_hash(const PipelineConfig& config) {
  const auto* views = config.get_if<ViewsPipelineConfig>();
  return views && !views->masks.empty() ? "\n" + sha256_hex_of_folder(views->masks) : "";
}

std::string page_summary(const PipelineConfig& config) {
  switch (row_of(config).traits_of) {
    case TraitsOf::specimens:
      return kMeasuredAgainstTruth;
    case TraitsOf::boxes:
      return "Every number here is measured against the exact surface of the specimens, in the "
             "axes of each image's camera. Intervals are 95 % bootstrap intervals, drawn by scene "
             "where there are several. The scene and the sensor are verified against theory only; "
             "no real device has been compared with them.";
    case TraitsOf::plants:
      return "Every number here is measured against the exact plants: their keypoints in the axes "
             "of each frame's first camera, their internodes and heights. Intervals are 95 % "
             "bootstrap intervals, drawn by scene where there are several. The scene and the "
             "sensor are verified against theory only; no real device has been compared with them.";
    case TraitsOf::trees:
      return "Every number here is measured against the exact fruits that hang in the tree's place "
             "of the row, each over all views. Intervals are 95 % bootstrap intervals, drawn by "
             "scene where there are several. The scene and the sensor are verified against theory "
             "only; no real device has been compared with them.";
    case TraitsOf::depths:
      return "Every depth here is measured against the first surface that the pixel's ray meets. "
             "The scene and the sensor are verified against theory only; no real device has been "
             "compared with them.";
    case TraitsOf::nothing:
      break;
  }
  return "Photographs by a virtual camera became Gaussians, and from these depth, a cloud and a "
         "mesh. Images are scored against photographs, held-out ones among them, shapes against "
         "every true surface that two views at least could see, and near specimens.";
}

}  // namespace cousin
