#include "benchmarks/suites/calibration/studies.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "benchmarks/suites/calibration/fruit_positions.h"
#include "benchmarks/suites/calibration/study_points.h"
#include "benchmarks/suites/calibration/study_run.h"

namespace cousin {
namespace {

constexpr const char* kSuite = "calibration";

void add_group(const StudyPoint& point, const StudyMethod& method,
               const std::vector<ScoreRow>& rows, const StudiesConfig& config,
               std::vector<ScoreRow>& pooled) {
  for (const StudyMetric& metric : study_metrics()) {
    ScoreRow base;
    base.suite = kSuite;
    base.scene = point.axis;
    base.case_name = point.name();
    base.method = method.name;
    base.seed = config.seed;
    std::vector<TraitPair> pairs;
    int runs = 0, solved = 0;
    double wall_s = 0;
    for (const ScoreRow& row : rows) {
      if (row.scene != point.axis || row.method != method.name || row.metric != metric.name ||
          !row.case_name.starts_with(point.name() + " run "))
        continue;
      ++runs;
      solved += row.status == ScoreStatus::ok;
      wall_s += row.wall_s;
      if (row.status == ScoreStatus::not_built) base.status = ScoreStatus::not_built;
      if (std::isfinite(row.value))
        pairs.push_back({0, row.value, ScoreRow::kNone, std::to_string(runs)});
    }
    if (runs == 0) continue;
    base.wall_s = wall_s / runs;
    if (base.status == ScoreStatus::ok && solved < runs) base.status = ScoreStatus::not_solved;
    if (pairs.size() > 1) {
      const TraitStatistics s = trait_statistics(
          pairs, Rng(config.seed).fork("calibration").fork(point.name()).fork(metric.name));
      pooled.push_back(with_interval(base, metric.name, metric.unit, s.rmse, s.n));
    } else {
      base.metric = metric.name;
      base.unit = metric.unit;
      base.value = pairs.empty() ? ScoreRow::kNone : std::abs(pairs.front().measured);
      base.n = static_cast<std::int64_t>(pairs.size());
      pooled.push_back(base);
    }
    if (&metric == study_metrics().data()) {
      ScoreRow row = pooled.back();
      row.metric = "solved";
      row.unit = "1";
      row.value = static_cast<double>(solved) / runs;
      row.n = runs;
      row.ci_low = row.ci_high = ScoreRow::kNone;
      pooled.push_back(std::move(row));
    }
  }
}

/// All that the photographs and what is made of them depend on, but the code.
std::string key_of(const StudyGroup& group) {
  std::string key;
  const auto add = [&key](const std::string& word) { key += word + "/"; };
  for (const std::string& set : group.sets) add(set);
  for (const StudyPoint& point : group.points) {
    add(point.name() + " " + std::to_string(point.views));
    for (const std::string& set : point.sensor_sets) add(set);
    for (const StudyMethod& method : point.methods) add(method.name);
  }
  return key;
}

/// Rows of a build without Ceres say that it is not built in: one that has it makes them anew.
std::string version_key(std::uint64_t seed) {
  return std::string(COUSIN_VERSION) + (COUSIN_WITH_CERES ? "/ceres/" : "/without ceres/") +
         std::to_string(seed) + "/";
}

/// A unit whose positions of fruits are measured: as it is made, or gone off since by the disparity
/// that the published errors of z would take.
struct PositionsUnit {
  const char* word;
  const char* name;
  double out_of_yaw_px;
};
constexpr std::array<PositionsUnit, 2> kPositionsUnits = {
    {{"as_made", "unit as made", 0}, {"off", "unit off by 0.45 px", 0.45}}};

ShardJob positions_job(const StudiesConfig& config, GridJob place) {
  const PositionsUnit& unit = kPositionsUnits.at(place.at("unit").level);
  PositionsConfig positions;
  positions.out_of_yaw_px = unit.out_of_yaw_px;
  if (config.quick) positions.points = 9;
  const int runs = config.quick ? 2 : config.runs;
  const std::string key = version_key(config.seed) + place.name + ".json/" +
                          std::to_string(positions.points) + "/" + std::to_string(runs);
  return shard_of(std::move(place), key, [positions, runs, unit, seed = config.seed] {
    std::vector<std::vector<FruitPosition>> all;
    for (int run = 0; run < runs; ++run) all.push_back(measure_positions(positions, seed, run));
    ScoreFile file;
    file.scores = position_rows(all, unit.name, seed);
    if (unit.out_of_yaw_px > 0) return to_json(file);
    const std::vector<ScoreRow> published = published_position_rows();
    file.scores.insert(file.scores.end(), published.begin(), published.end());
    return to_json(file);
  });
}

ShardJob photographs_job(const StudiesConfig& config, const StudyGroup& group, GridJob place) {
  const int run = place.number("run");
  const std::string key = version_key(config.seed) + "study_" + place.at("photographs").word +
                          "_run" + std::to_string(run) + ".json/" + key_of(group);
  return shard_of(std::move(place), key, [group, run, seed = config.seed] {
    ScoreFile file;
    file.scores = run_group(group, run, seed);
    return to_json(file);
  });
}

Grid studies_grid(const StudiesConfig& config, const std::vector<StudyGroup>& groups) {
  Factor unit{"unit", {}}, photographs{"photographs", {}};
  for (const PositionsUnit& u : kPositionsUnits) unit.levels.push_back({u.word});
  for (const StudyGroup& group : groups)
    photographs.levels.push_back({group.points.front().name(), group.sets});
  return {{"study_positions_{unit}", {unit}},
          {"study_{photographs}_run{run}",
           {number_factor("run", 0, config.quick ? 1 : config.runs), photographs}}};
}

}  // namespace

std::vector<ShardJob> study_jobs(const StudiesConfig& config) {
  const std::vector<StudyGroup> groups = study_groups(config.quick);
  std::vector<ShardJob> jobs;
  for (GridJob& place : jobs_of(studies_grid(config, groups))) {
    if (place.has("unit")) {
      jobs.push_back(positions_job(config, std::move(place)));
      continue;
    }
    const StudyGroup& group = groups[place.at("photographs").level];
    jobs.push_back(photographs_job(config, group, std::move(place)));
  }
  return jobs;
}

std::vector<ScoreRow> study_rows(const std::vector<ScoreRow>& rows, const StudiesConfig& config) {
  std::vector<ScoreRow> pooled;
  for (const StudyPoint& point : study_points(config.quick)) {
    for (const StudyMethod& method : point.methods) add_group(point, method, rows, config, pooled);
  }
  const std::vector<ScoreRow> crossings = crossing_rows(pooled);
  pooled.insert(pooled.end(), crossings.begin(), crossings.end());
  return pooled;
}

}  // namespace cousin
