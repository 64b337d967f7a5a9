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

/// Positions of fruits by units as they are made, and by units that have gone off since: by the
/// disparity that the published errors of z would take.
std::vector<ShardJob> position_jobs(const StudiesConfig& config) {
  constexpr double kOff_px = 0.45;
  struct Kind {
    const char* name;
    double out_of_yaw_px;
  };
  std::vector<ShardJob> jobs;
  for (const Kind& kind : {Kind{"unit as made", 0}, Kind{"unit off by 0.45 px", kOff_px}}) {
    PositionsConfig positions;
    positions.out_of_yaw_px = kind.out_of_yaw_px;
    if (config.quick) positions.points = 9;
    const int runs = config.quick ? 2 : config.runs;
    const std::string name =
        kind.out_of_yaw_px > 0 ? "study_positions_off.json" : "study_positions_as_made.json";
    const std::string key = version_key(config.seed) + name + "/" +
                            std::to_string(positions.points) + "/" + std::to_string(runs);
    jobs.push_back({name, key, [positions, runs, kind, seed = config.seed] {
                      std::vector<std::vector<FruitPosition>> all;
                      for (int run = 0; run < runs; ++run)
                        all.push_back(measure_positions(positions, seed, run));
                      ScoreFile file;
                      file.scores = position_rows(all, kind.name, seed);
                      if (kind.out_of_yaw_px > 0) return to_json(file);
                      const std::vector<ScoreRow> published = published_position_rows();
                      file.scores.insert(file.scores.end(), published.begin(), published.end());
                      return to_json(file);
                    }});
  }
  return jobs;
}

}  // namespace

std::vector<ShardJob> study_jobs(const StudiesConfig& config) {
  std::vector<ShardJob> jobs = position_jobs(config);
  const std::vector<StudyGroup> groups = study_groups(config.quick);
  for (int run = 0; run < (config.quick ? 1 : config.runs); ++run) {
    for (const StudyGroup& group : groups) {
      std::string name =
          "study_" + group.points.front().name() + "_run" + std::to_string(run) + ".json";
      std::string key = version_key(config.seed) + name + "/" + key_of(group);
      for (char& c : name) {
        if (c == ' ' || c == ',') c = '_';
      }
      jobs.push_back({name, key, [group, run, seed = config.seed] {
                        ScoreFile file;
                        file.scores = run_group(group, run, seed);
                        return to_json(file);
                      }});
    }
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
