#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "benchmarks/loop/limits.h"
#include "benchmarks/loop/score_seeds.h"
#include "benchmarks/score/equal_time.h"
#include "benchmarks/study/shard_scores.h"
#include "benchmarks/suites/seeds/published_seeds.h"
#include "benchmarks/suites/seeds/suite.h"

namespace cousin {
namespace {

/// The iterations of the paper's second column, beside which ours is held.
constexpr int kComparedSteps = 7000;

/// Cultivars whose specimens a group of the pooled table holds, as `groups_of` names it.
std::set<std::string> cultivars_of(std::span<const SpecimenRow> specimens,
                                   const std::string& group) {
  std::set<std::string> result;
  for (const SpecimenRow& row : specimens) {
    if (row.cultivar == group || species_of(row.cultivar) == group ||
        (group == "all" && row.cultivar != kSphere)) {
      result.insert(row.cultivar);
    }
  }
  return result;
}

/// Rows of single runs of `cultivars` at the paper's imaging, whose specimens are pooled.
std::vector<const ScoreRow*> rows_of_runs(const std::vector<ScoreRow>& of_runs,
                                          const std::set<std::string>& cultivars,
                                          const std::string& suite, const std::string& method,
                                          const std::string& metric) {
  std::vector<const ScoreRow*> result;
  for (const ScoreRow& row : of_runs) {
    if (row.suite == suite && row.method == method && row.metric == metric &&
        cultivars.contains(row.scene) && row.views == 60 && row.width_px == 1920 &&
        row.height_px == 1080 && row.steps == 0) {
      result.push_back(&row);
    }
  }
  return result;
}

/// Share of the views that have a pose, and the camera centres' RMS, over all runs of a group.
std::vector<ScoreRow> pooled_pose_rows(const std::vector<ScoreRow>& of_runs,
                                       std::span<const SpecimenRow> specimens,
                                       const SeedsScoreLabels& labels) {
  std::vector<ScoreRow> rows;
  for (const std::string& group : groups_of(specimens)) {
    const std::set<std::string> cultivars = cultivars_of(specimens, group);
    ScoreRow row;
    row.suite = labels.suite;
    row.scene = labels.scene;
    row.case_name = group;
    row.method = "ours";
    row.seed = labels.seed;
    double posed = 0, views = 0, square = 0, centres = 0;
    for (const ScoreRow* run :
         rows_of_runs(of_runs, cultivars, labels.suite, "ours", "views.posed")) {
      views += static_cast<double>(run->n);
      posed += run->value * static_cast<double>(run->n);
    }
    for (const ScoreRow* run :
         rows_of_runs(of_runs, cultivars, labels.suite, "ours", "camera.centre_rms")) {
      if (run->n == 0) continue;  // no view has a pose: its value is no number
      centres += static_cast<double>(run->n);
      square += run->value * run->value * static_cast<double>(run->n);
    }
    if (views == 0) continue;
    row.metric = "views.posed";
    row.value = posed / views;
    row.unit = "1";
    row.n = static_cast<std::int64_t>(views);
    rows.push_back(row);
    row.metric = "camera.centre_rms";
    row.value = centres > 0 ? std::sqrt(square / centres) : ScoreRow::kNone;
    row.unit = "m";
    row.n = static_cast<std::int64_t>(centres);
    rows.push_back(row);
  }
  return rows;
}

/// Puts beside pooled numbers what a capture of the group took: mean seconds of the method's
/// stages, largest memory.
void add_run_times(const std::vector<ScoreRow>& of_runs, std::span<const SpecimenRow> specimens,
                   std::vector<ScoreRow>& rows) {
  for (ScoreRow& row : rows) {
    const auto runs = rows_of_runs(of_runs, cultivars_of(specimens, row.case_name), row.suite,
                                   row.method, "seconds.perceive");
    if (runs.empty()) continue;
    row.wall_s = row.cpu_s = row.peak_rss_mb = 0;
    for (const ScoreRow* run : runs) {
      row.wall_s += run->wall_s / static_cast<double>(runs.size());
      row.cpu_s += run->cpu_s / static_cast<double>(runs.size());
      row.peak_rss_mb = std::max(row.peak_rss_mb, run->peak_rss_mb);
    }
  }
}

/// By how much views trained on are better than those held out, of each model that has both.
std::vector<ScoreRow> held_out_gaps(const std::vector<ScoreRow>& rows) {
  std::map<std::tuple<std::string, std::string, std::string>, double> held_out;
  const std::string before = "held_out.", kind = "psnr_";
  const auto place = [](const ScoreRow& row, const std::string& metric) {
    return std::tuple(row.scene + "/" + row.method, row.case_name, metric);
  };
  for (const ScoreRow& row : rows) {
    if (row.suite == kSplatsSuite && row.metric.starts_with(before + kind))
      held_out[place(row, row.metric.substr(before.size()))] = row.value;
  }
  std::vector<ScoreRow> gaps;
  for (ScoreRow row : rows) {
    if (row.suite != kSplatsSuite || !row.metric.starts_with("train." + kind)) continue;
    const std::string metric = row.metric.substr(std::string("train.").size());
    const auto other = held_out.find(place(row, metric));
    if (other == held_out.end()) continue;
    row.metric = metric + ".train_less_held_out";
    row.value -= other->second;
    gaps.push_back(std::move(row));
  }
  return gaps;
}

/// RMSE of the paper's two ways on our captures over what it published of them, a row a cultivar
/// and trait that it has: 1 is a replication without an error of its own.
std::vector<ScoreRow> over_published(const std::vector<ScoreRow>& rows,
                                     const std::vector<ScoreRow>& published) {
  std::vector<ScoreRow> ratios;
  for (const auto& [own, theirs] :
       {std::pair{"splats_paper", "published: 3DGS"}, std::pair{"paper", "published: SfM-MVS"}}) {
    for (const ScoreRow& of_paper : published) {
      if (of_paper.method != theirs || !of_paper.metric.ends_with(".rmse")) continue;
      const auto found = std::find_if(rows.begin(), rows.end(), [&](const ScoreRow& row) {
        return row.suite == kSplatsSuite && row.scene == "pooled" && row.method == own &&
               row.case_name == of_paper.scene && row.metric == of_paper.metric;
      });
      if (found == rows.end()) continue;
      ScoreRow ratio = *found;
      ratio.method = std::string(own) + "/" + theirs;
      ratio.metric += "_over_published";
      ratio.value /= of_paper.value;
      ratio.ci_low /= of_paper.value;
      ratio.ci_high /= of_paper.value;
      ratio.unit = "1";
      ratios.push_back(std::move(ratio));
    }
  }
  return ratios;
}

}  // namespace

ScoreFile pool_seeds_suite(const std::vector<ShardResult>& results,
                           const SeedsSuiteConfig& config) {
  SeedsScoreLabels labels;
  labels.seed = config.seed;
  ScoreFile pooled = scores_of_shards(results, labels.suite, config.seed);
  pooled.header.program_version = COUSIN_VERSION;
  labels.scene = "pooled";
  const std::vector<ScoreRow> of_runs = pooled.scores;
  for (const char* dataset : {"seeds", kPaperSpread, kSplatsSuite}) {
    labels.suite = dataset;
    std::vector<SpecimenRow> specimens;
    for (const SpecimenRow& row : pooled.specimens) {
      if (row.dataset == dataset) specimens.push_back(row);
    }
    std::vector<ScoreRow> rows = pooled_rows(specimens, labels);
    for (const auto& [a, b] : {std::pair{"ours", "paper"}, std::pair{"splats", "splats_paper"},
                               std::pair{"splats_paper", "paper"}, std::pair{"ours", "splats"}}) {
      for (ScoreRow& row : paired_rows(specimens, a, b, labels)) rows.push_back(std::move(row));
    }
    for (ScoreRow& row : pooled_pose_rows(of_runs, specimens, labels))
      rows.push_back(std::move(row));
    add_run_times(of_runs, specimens, rows);
    pooled.scores.insert(pooled.scores.end(), rows.begin(), rows.end());
  }
  const auto is_trained = [](const ScoreRow& row) { return row.suite == kSplatsSuite; };
  if (std::any_of(of_runs.begin(), of_runs.end(), is_trained)) {
    append({.scores = equal_time_rows(of_runs, {"splats_paper",
                                                "splats_images",
                                                kComparedSteps,
                                                {"train.psnr_whole", "held_out.psnr_whole"},
                                                machines_of_shards(results)})},
           pooled);
    append({.scores = held_out_gaps(of_runs)}, pooled);
    const std::vector<ScoreRow> published = published_seeds_rows();
    append({.scores = over_published(pooled.scores, published)}, pooled);
    append({.scores = published}, pooled);
  }
  return pooled;
}

void hold_seeds_suite(const SeedsSuiteConfig& config, ScoreFile& pooled) {
  if (config.quick || !config.sets.empty()) return;
  std::set<std::string> cultivars;
  for (const SpecimenRow& row : pooled.specimens) {
    if (row.dataset == std::string("seeds")) cultivars.insert(row.cultivar);
  }
  hold_to_limits(pooled.scores, cultivars);
  hold_trained_to_limits(pooled.scores);
}

}  // namespace cousin
