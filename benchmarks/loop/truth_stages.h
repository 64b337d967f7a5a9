#pragma once

#include <span>
#include <string_view>

#include "benchmarks/loop/report_scene.h"
#include "benchmarks/loop/simulate.h"
#include "perception/pipelines/stage_table.h"

namespace cousin {

/// Truth passes that the true seams below read.
TruthNeeds truth_stage_needs();

/// How truth stands in the place of a stage, and what a page shows of it.
struct TruthRow {
  std::string_view stage;
  /// Puts its true seam into `stages`; the run must outlive these. Null if no seam is the true one.
  void (*put)(Stages& stages, const SimulatedRun& run, const SeedBoard& board) = nullptr;
  std::string_view why_none = {};
  /// Adds its pictures and shapes to the page's scene (stage_pictures.h). Null if it has none.
  void (*show)(const SimulatedRun& run, const Estimate& estimate, ReportScene& scene) = nullptr;
  std::string_view why_not_shown = {};
};
/// One for each row of stage_table().
std::span<const TruthRow> truth_table();
/// @throws std::logic_error for a stage without a row
const TruthRow& truth_row(std::string_view stage);

/// Stages that hand over the truth instead of an estimate, in the same form and with the same
/// visibility limits: corners where the board is seen, depth of first surfaces, points of surfaces
/// that some view sees, outlines where nothing else cuts them. `run.truth.images` must hold
/// truth_stage_needs(). The run must outlive the stages.
Stages truth_stages(const SimulatedRun& run, const SeedBoard& board);

}  // namespace cousin
