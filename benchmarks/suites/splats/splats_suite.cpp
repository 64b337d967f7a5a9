#include "benchmarks/suites/splats/splats_suite.h"

#include <functional>
#include <string>
#include <utility>

#include "benchmarks/suites/splats/field_rows.h"
#include "benchmarks/suites/splats/kernel_rows.h"
#include "benchmarks/suites/splats/ngp_kernel_rows.h"
#include "benchmarks/suites/splats/training_rows.h"
#include "perception/sfm/colmap_run.h"
#include "perception/splats/splat_train_config.h"
#include "sim/dataset/manifest.h"

namespace cousin {
namespace {

/// Which photographs they are. @param folder  that holds them
std::string text_of(const std::filesystem::path& folder) {
  return folder.string() + " " + sha256_hex_of_folder(folder);
}

std::vector<ScoreRow> all_kernel_rows(const SplatsSuiteConfig& config) {
  std::vector<ScoreRow> rows = splat_kernel_rows(config.seed);
  const std::vector<ScoreRow> of_field = ngp_kernel_rows(config.seed);
  rows.insert(rows.end(), of_field.begin(), of_field.end());
  return rows;
}

/// A level of the factor "part".
struct SplatsPart {
  std::string name;
  std::string depends;  ///< on what, beside the suite's configuration
  std::function<std::vector<ScoreRow>(const SplatsSuiteConfig&)> rows;
};

std::vector<SplatsPart> splats_parts(const SplatsSuiteConfig& config) {
  return {{"kernels", "with the radiance field's", all_kernel_rows},
          {"training", text_of(config.photographs),
           [](const SplatsSuiteConfig& c) {
             return splat_training_rows(c.photographs, c.seed, c.quick);
           }},
          {"choices", text_of(config.photographs),
           [](const SplatsSuiteConfig& c) {
             return splat_choice_rows(c.photographs, c.seed, c.quick);
           }},
          {"fields",
           "ssim and flip, seconds a sample/" + text_of(config.photographs) +
               text_of(config.fox.parent_path()) + text_of(config.chair) + "/colmap " +
               colmap_version(),  // which places the chair's photographs
           [](const SplatsSuiteConfig& c) {
             return field_rows(c.photographs, c.fox, c.chair, c.seed, c.quick);
           }}};
}

}  // namespace

std::vector<ShardJob> splats_jobs(const SplatsSuiteConfig& config) {
  const std::string key = std::string(COUSIN_VERSION) + "/" + std::to_string(config.seed) +
                          (config.quick ? "/quick/low_pass" : "/low_pass") +
                          std::to_string(SplatTrainConfig().low_pass_px2);
  const std::vector<SplatsPart> parts = splats_parts(config);
  Factor part_factor{"part", {}};
  for (const SplatsPart& part : parts) part_factor.levels.push_back({part.name});
  const std::string ending = config.quick ? ".quick" : "";
  std::vector<ShardJob> jobs;
  for (GridJob& place : jobs_of({{"{part}" + ending, {part_factor}}})) {
    const SplatsPart& part = parts[place.at("part").level];
    jobs.push_back(shard_of(
        std::move(place), key + "/" + part.name + "/" + part.depends,
        [config, rows = part.rows] { return to_json(ScoreFile{.scores = rows(config)}); }));
  }
  return jobs;
}

}  // namespace cousin
