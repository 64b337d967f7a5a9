#include "benchmarks/loop/attribution.h"

#include <algorithm>
#include <set>
#include <utility>

#include "benchmarks/loop/keypoint_noise.h"
#include "benchmarks/loop/score_boxes.h"
#include "benchmarks/loop/truth_stages.h"
#include "benchmarks/score/trait_statistics.h"
#include "sim/types/trait_table.h"

namespace cousin {
namespace {

double wall_s(const Estimate& estimate) {
  double sum = 0;
  for (const StageTiming& timing : estimate.timings) sum += timing.wall_s;
  return sum;
}

}  // namespace

namespace {

/// The board whose corners a pipeline looks for. A pipeline that looks for none gets any board.
SeedBoard board_for(const Capture& capture, const PipelineConfig& config) {
  const auto* seeds = config.get_if<SeedsPipelineConfig>();
  return seeds ? board_of(capture, *seeds) : SeedBoard{};
}

/// Stages in whose place truth can stand, after "none". One that this method leaves out has no seam
/// to fill; what is true of a box is no trait of the specimen.
std::vector<std::string> bars_of(const PipelineConfig& config) {
  const PipelineRow& row = row_of(config);
  const PipelineNeeds needed = needs(config);
  std::vector<std::string> bars = {"none"};
  for (const std::string_view stage : row.order) {
    if (!truth_row(stage).put || (stage == "traits" && row.traits_of != TraitsOf::specimens))
      continue;
    if (std::find(needed.stages.begin(), needed.stages.end(), stage) != needed.stages.end())
      bars.emplace_back(stage);
  }
  return bars;
}

}  // namespace

std::vector<SeamStep> attribute(const SimulatedRun& run, const PipelineConfig& config,
                                const Stages& own, const SeedsScoreLabels& labels,
                                const Estimate* estimate, const Progress& progress) {
  Stages truth = truth_stages(run, board_for(run.capture, config));
  if (takes_keypoints(row_of(config)))
    truth.keypoints = outside_stages(run, row_of(config), {}, 0).keypoints;
  const TraitsOf traits_of = row_of(config).traits_of;
  std::vector<std::string> replaced;
  std::vector<SeamStep> steps;
  const std::vector<std::string> bars = bars_of(config);
  for (std::size_t i = 0; i < bars.size(); ++i) {
    if (progress)
      progress("truth up to " + bars[i], static_cast<int>(i), static_cast<int>(bars.size()));
    if (i > 0) replaced.push_back(bars[i]);
    Estimate result;
    if (i == 0 && estimate) {
      result = *estimate;
    } else {
      Stages stages = replace_stages(own, truth, replaced);
      leave_out_needless(stages, replaced);
      result = run_pipeline(run.capture, config, stages);
    }
    steps.push_back({bars[i],
                     score_estimate(traits_of, run.truth, result, labels, row_of(config).traits),
                     wall_s(result)});
  }
  return steps;
}

namespace {

/// A box of a frame, or a specimen over all frames.
using Measured = std::pair<std::int64_t, std::int64_t>;

/// Specimens whose trait every step has that has any: only over the same ones is the difference of
/// two steps what a stage contributes.
std::set<Measured> solved_in_all(const std::vector<SeamStep>& steps, const std::string& trait) {
  std::set<Measured> common;
  bool is_first = true;
  for (const SeamStep& step : steps) {
    std::set<Measured> own;
    for (const SpecimenRow& row : step.scores.specimens) {
      if (row.trait == trait && row.status == ScoreStatus::ok)
        own.insert({row.frame, row.instance});
    }
    if (own.empty()) continue;
    if (is_first) common = own;
    is_first = false;
    std::erase_if(common, [&](const Measured& which) { return !own.contains(which); });
  }
  return common;
}

}  // namespace

std::vector<ScoreRow> attribution_rows(const std::vector<SeamStep>& steps,
                                       std::span<const std::string_view> traits,
                                       const SeedsScoreLabels& labels) {
  std::vector<ScoreRow> rows;
  for (const SeamStep& step : steps) {
    for (const std::string_view trait : traits) {
      const std::string name(trait), unit(trait_row(trait).unit);
      const std::set<Measured> common = solved_in_all(steps, name);
      const auto pairs =
          trait_pairs(step.scores.specimens, trait, [&](const SpecimenRow& specimen) {
            return common.contains({specimen.frame, specimen.instance});
          });
      ScoreRow base;
      base.suite = labels.suite;
      base.scene = labels.scene;
      base.case_name = "truth up to " + step.stage;
      base.method = labels.method;
      base.seed = labels.seed;
      base.wall_s = step.wall_s;
      if (pairs.empty()) {
        base.metric = name + ".rmse";
        base.unit = unit;
        base.status = ScoreStatus::not_solved;
        rows.push_back(base);
        continue;
      }
      const TraitStatistics s =
          trait_statistics(pairs, Rng(labels.seed).fork("attribution").fork(step.stage + name));
      rows.push_back(with_interval(base, name + ".rmse", unit, s.rmse, s.n));
      rows.push_back(with_interval(base, name + ".bias", unit, s.bias, s.n));
      if (trait_row(trait).scoring == TraitScoring::relative)
        rows.push_back(with_interval(base, name + ".mape", "1", s.mape, s.n));
    }
    for (ScoreRow row : step.scores.rows) {
      if (row.metric != "camera.centre_rms") continue;
      row.case_name = "truth up to " + step.stage;
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

}  // namespace cousin
