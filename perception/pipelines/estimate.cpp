#include "perception/pipelines/estimate.h"

#include <exception>

#include "perception/pipelines/stage_table.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

/// Runs one stage, times it and tells the observer; an exception names the stage and keeps what is
/// finished.
void run_stage(const StageRow& row, const Stages& stages, const Capture& capture,
               Estimate& estimate, const StageObserver& observer) {
  if (observer) observer(row.name, false, estimate);
  const StageClock clock{std::string(row.name)};
  try {
    row.run(stages, capture, estimate);
  } catch (const std::exception& error) {
    std::throw_with_nested(StageError(std::string(row.name), error.what()));
  }
  estimate.timings.push_back(clock.finish());
  if (row.check) row.check(row.name, capture, estimate);
  if (observer) observer(row.name, true, estimate);
}

}  // namespace

StageError::StageError(const std::string& stage_name, const std::string& what)
    : std::runtime_error("stage " + stage_name + ": " + what), stage(stage_name) {}

Estimate run_stages(const Capture& capture, const Stages& stages, StageOrder order,
                    const StageObserver& observer) {
  if (capture.frames.empty()) throw std::invalid_argument("the capture has no frames");
  Estimate estimate;
  for (const std::string_view name : order) {
    const StageRow& row = stage_row(name);
    if (row.is_there(stages)) run_stage(row, stages, capture, estimate, observer);
  }
  return estimate;
}

}  // namespace cousin
