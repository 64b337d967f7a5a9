#pragma once

#include <string>
#include <vector>

#include "benchmarks/loop/run_config.h"
#include "benchmarks/loop/stage_files.h"
#include "sim/sensors/device.h"

namespace cousin {

/// One pass of a run: whether it runs and why, or why it is left out.
struct PlanEntry {
  std::string pass;
  bool runs = false;
  std::string why;
};

/// The simulator's passes alone: what the reader of the images makes it render; anybody: nobody
/// reads them yet, as in a dataset.
std::vector<PlanEntry> simulator_plan(const RunConfig& config, Reader reader = Reader::pipeline);

/// What `run` does with a configuration: the union of what the pipeline needs and what is scored.
/// @param attribution  truth is put into each seam too, which reads true depth and instances
/// @param sources  stages that the user gives
std::vector<PlanEntry> run_plan(const RunConfig& config, bool attribution,
                                const std::vector<StageSource>& sources = {});

/// Appends what comes after the simulator: truth images, stages, scores.
void add_pipeline_plan(const PipelineConfig& pipeline, bool attribution,
                       const std::vector<StageSource>& sources, std::vector<PlanEntry>& plan);

/// The truth images that the plan renders: those that true seams are made of, and scores of boxes.
TruthNeeds planned_truth(const PipelineConfig& pipeline, bool attribution);

std::string describe(const std::vector<PlanEntry>& plan);

}  // namespace cousin
