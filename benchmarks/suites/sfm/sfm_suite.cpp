#include "benchmarks/suites/sfm/sfm_suite.h"

#include <cstdio>
#include <stdexcept>
#include <utility>

#include "benchmarks/suites/seeds/capture_store.h"
#include "benchmarks/suites/sfm/sfm_rows.h"
#include "perception/sfm/colmap_run.h"
#include "sim/dataset/manifest.h"

namespace cousin {
namespace {

std::string text_of(std::vector<ScoreRow> rows) {
  ScoreFile file;
  file.scores = std::move(rows);
  return to_json(file);
}

}  // namespace

ScoreRow sfm_row(const SfmSuiteConfig& config, const std::string& scene,
                 const std::string& method) {
  ScoreRow row;
  row.suite = "sfm";
  row.scene = scene;
  row.case_name = scene;
  row.method = method;
  row.seed = config.seed;
  return row;
}

ScoreRow numbered(ScoreRow row, const std::string& metric, double value, const std::string& unit,
                  std::int64_t n) {
  row.metric = metric;
  row.value = value;
  row.unit = unit;
  row.n = n;
  return row;
}

ScoreRow at_most(ScoreRow row, const std::string& metric, double value, const std::string& unit,
                 std::int64_t n, double limit) {
  char text[48];
  std::snprintf(text, sizeof text, " (at most %.3g)", limit);
  return limited(numbered(std::move(row), metric + text, value, unit, n), at_most(limit));
}

std::vector<ScoreRow> pose_rows(const ScoreRow& row, const PoseScore& score) {
  return {
      numbered(row, "camera.centre_rms", score.centre_rms_m, "m", score.posed),
      numbered(row, "camera.centre_rms over distance", score.centre_rms_share, "1", score.posed),
      numbered(row, "camera.rotation_rms", score.rotation_rms_rad, "rad", score.posed)};
}

ScoreRow missing_row(ScoreRow row, const std::string& why, ScoreStatus status) {
  row.metric = why;
  row.unit = "1";
  row.status = status;
  return row;
}

ScoreRow unsolved_row(ScoreRow row, const std::string& why, SfmStatus status) {
  if (status == SfmStatus::program_failed || status == SfmStatus::timed_out)
    throw std::runtime_error(std::string(to_string(status)) + ": " + why);
  return missing_row(
      std::move(row), why,
      status == SfmStatus::not_built ? ScoreStatus::not_built : ScoreStatus::not_solved);
}

std::vector<ShardJob> sfm_suite_jobs(const SfmSuiteConfig& config, const Progress& progress) {
  const std::string key = std::string(COUSIN_VERSION) + "/" + std::to_string(config.seed) + "/" +
                          (config.quick ? "quick" : "full") + "/" + std::to_string(config.threads) +
                          "/colmap " + colmap_version(config.program) +
                          (COUSIN_WITH_CERES ? " adjusted, lens judged/" : " without adjustment/") +
                          config.neutral.string() + "/" + sha256_hex_of_folder(config.neutral);
  const std::string ending = config.quick ? ".quick" : "";
  std::vector<ShardJob> jobs;
  for (GridJob& place :
       jobs_of({{"{part}" + ending, {named_factor("part", {"neutral", "seeds"})}}})) {
    if (place.at("part").word == "neutral") {
      jobs.push_back(shard_of(std::move(place), key + "/neutral",
                              [config] { return text_of(neutral_rows(config)); }));
      continue;
    }
    jobs.push_back(
        shard_of(std::move(place),
                 key + "/seeds" + resolved_toml(seeds_sfm_scene(config)) + built_in_tables(),
                 [config, progress] { return text_of(seeds_sfm_rows(config, progress)); }));
  }
  return jobs;
}

}  // namespace cousin
