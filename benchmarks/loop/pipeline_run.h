#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "benchmarks/loop/perceive.h"
#include "benchmarks/loop/report_scene.h"
#include "benchmarks/loop/score_boxes.h"
#include "benchmarks/score/image_scores.h"
#include "benchmarks/score/learned/learned_distance.h"

namespace cousin {

/// What a pipeline is asked to do with one scene's capture.
struct PerceiveTask {
  const Capture& capture;
  const PipelineConfig& config;
  std::uint64_t seed = 0;
  const std::vector<StageSource>& sources;
  int scene_index = 0;
  std::string name;                    ///< of the scene in rows
  std::filesystem::path estimate_dir;  ///< empty: nothing is written
  const LearnedDistance* learned = nullptr;
  Stages outside = {};  ///< of `perceive`
};

/// What became of it.
struct PerceivedScene {
  Estimate estimate;
  std::vector<ScoreRow> rows;  ///< that need no truth; those of stages' seconds are in scores
  std::string summary;         ///< "12 of 12 views posed, 10 specimens"
  std::string nothing;         ///< why there is nothing that can be used; empty where there is
  std::vector<std::string> unmeasured;  ///< a line each
};
PerceivedScene perceive_scene(const PerceiveTask& task, const Progress& progress, const Warn& warn);

/// Scores one scene as the pipeline's traits ask for, with `made.rows`.
ScoreFile score_scene(const SimulatedRun& run, const PerceivedScene& made,
                      const PipelineConfig& config, PoseAlignment alignment,
                      const SeedsScoreLabels& labels);

/// What a page shows of it. @param estimate_dir  where its seams were written
ReportScene page_scene(const std::string& name, const SimulatedRun& run, const PerceivedScene& made,
                       const PipelineConfig& config, const std::filesystem::path& estimate_dir);

/// A hash of the files in the folder that a key of the pipeline names. "" if no key names one.
std::string user_folders_hash(const PipelineConfig& config);

/// A page's paragraph below its title.
std::string page_summary(const PipelineConfig& config);

}  // namespace cousin
