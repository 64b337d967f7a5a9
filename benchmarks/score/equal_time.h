#pragma once

#include <map>
#include <string>
#include <vector>

#include "benchmarks/score/scores.h"

namespace cousin {

/// What a training's rows have in common: scene, method and case.
std::string training_of(const ScoreRow& row);
/// Machines that trainings ran on, by training_of; empty or absent: not known.
using TrainingMachines = std::map<std::string, std::string>;

/// Whose trainings are held beside whose.
struct EqualTimeQuestion {
  std::string reference, ours;  ///< methods
  int reference_steps = 7000;   ///< the reference's last model of at most so many
  std::vector<std::string> metrics;
  TrainingMachines machines = {};  ///< seconds of two that are known to differ do not compare
};
/// Of each scene, case and metric: that of ours, the last training that took no longer than the
/// reference's, less the reference's, as METRIC_gain_at_equal_seconds and
/// METRIC_gain_at_equal_cpu_seconds. Each training of ours is one of its own: there is nothing
/// between two of them. Without seconds, or a training of ours by then, there is no row; nor where
/// the two are over other numbers of photographs (n), or the reference's training failed.
std::vector<ScoreRow> equal_time_rows(const std::vector<ScoreRow>& rows,
                                      const EqualTimeQuestion& question);

}  // namespace cousin
