#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "benchmarks/score/scores.h"
#include "perception/pipelines/pipeline_table.h"
#include "perception/pipelines/seeds.h"
#include "sim/dataset/truth_io.h"

namespace cousin {

/// What the rows of one run are labelled with.
struct SeedsScoreLabels {
  std::string suite = "seeds";
  std::string scene = "000000";
  std::string case_name = "run";
  std::string method = "ours";
  std::string run = "000000";
  std::uint64_t seed = 0;
  ScoreSettings settings = {};
};

/// "zhengdan958 run 0 60 views 1280x720, one in 8 held out, poses sfm, 7000 steps": a case's name
/// for people, of its settings.
std::string case_text(const std::string& scene, const ScoreSettings& settings);

/// A row with these labels and no metric yet.
ScoreRow labelled_row(const SeedsScoreLabels& labels);
/// "seconds.measure": wall time from `views` pictures to sizes.
ScoreRow seconds_row(const SeedsScoreLabels& labels, double wall_s, std::int64_t views);
/// Why a training left no Gaussian (SplatModel::why_none), not_solved.
ScoreRow untrained_row(ScoreRow base, const SplatModel& none);

struct SeedsScores {
  std::vector<ScoreRow> rows;
  std::vector<SpecimenRow> specimens;
};

/// seconds.STAGE of each stage and seconds.perceive of all, with CPU time and memory in their
/// columns.
void score_timings(const Estimate& estimate, const ScoreRow& base, std::vector<ScoreRow>& rows);

/// Scores one capture: specimens found, missed and spurious, poses, cloud and meshes against the
/// true surfaces, seconds and memory; and one specimen row for each true specimen and trait (status
/// not_solved where it was not measured). Whatever the estimate does not hold is not scored. On a
/// plain board the estimate is turned first, see board_turn.h.
SeedsScores score_run(const SceneTruth& truth, const Estimate& estimate,
                      const SeedsScoreLabels& labels);

/// Groups that statistics are made for: each cultivar, each species, and all seeds ("all").
std::vector<std::string> groups_of(std::span<const SpecimenRow> specimens);

/// Trait statistics over all runs: per cultivar, per species and over all, for each method and
/// trait in the rows.
std::vector<ScoreRow> pooled_rows(std::span<const SpecimenRow> specimens,
                                  const SeedsScoreLabels& labels);

/// Ratio of the RMSE of method a to that of b on the same specimens, per cultivar, species and
/// trait.
std::vector<ScoreRow> paired_rows(std::span<const SpecimenRow> specimens,
                                  const std::string& method_a, const std::string& method_b,
                                  const SeedsScoreLabels& labels);

/// The reference sphere is no seed: its size, twice a seed's, would make every pooled slope right
/// and leave the seeds a corner of every plot.
inline constexpr const char* kSphere = "sphere";

/// Suite and dataset of the runs whose seeds vary as much as the paper's R^2 and RMSE imply. They
/// are pooled on their own.
inline constexpr const char* kPaperSpread = "seeds_paper_spread";

/// Suite and dataset of the captures on which Gaussians are trained as well, at 1280 x 720. They
/// are pooled on their own.
inline constexpr const char* kSplatsSuite = "seeds_splats";
/// Whether its views have poses by structure from motion.
inline bool is_posed_by_tracks(const ScoreRow& row) { return !row.poses.empty(); }

/// maize, wheat, rice; other names stand for themselves.
std::string species_of(const std::string& cultivar);

/// A condition on a metric: "length.rmse<=0.0001".
struct Gate {
  std::string metric;
  bool at_most = true;
  double limit = 0;
};
/// @throws std::invalid_argument naming the text and the form.
Gate parse_gate(const std::string& text);
/// Rows of that metric that break the gate; a metric that no row has breaks it too.
std::vector<std::string> broken(const Gate& gate, std::span<const ScoreRow> rows);

}  // namespace cousin
