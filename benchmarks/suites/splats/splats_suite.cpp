#include "benchmarks/suites/splats/splats_suite.h"

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

}  // namespace

std::vector<ShardJob> splats_jobs(const SplatsSuiteConfig& config) {
  const std::string key = std::string(COUSIN_VERSION) + "/" + std::to_string(config.seed) +
                          (config.quick ? "/quick/low_pass" : "/low_pass") +
                          std::to_string(SplatTrainConfig().low_pass_px2);
  const std::string ending = config.quick ? ".quick.json" : ".json";
  const auto job = [&](const std::string& name, const std::string& of, auto rows) {
    return ShardJob{name + ending,
                    key + "/" + name + "/" + of,
                    [config, rows] { return to_json(ScoreFile{.scores = rows(config)}); },
                    {}};
  };
  const auto kernels = [](const SplatsSuiteConfig& c) {
    std::vector<ScoreRow> rows = splat_kernel_rows(c.seed);
    const std::vector<ScoreRow> of_field = ngp_kernel_rows(c.seed);
    rows.insert(rows.end(), of_field.begin(), of_field.end());
    return rows;
  };
  return {job("kernels", "with the radiance field's", kernels),
          job("training", text_of(config.photographs),
              [](const SplatsSuiteConfig& c) {
                return splat_training_rows(c.photographs, c.seed, c.quick);
              }),
          job("choices", text_of(config.photographs),
              [](const SplatsSuiteConfig& c) {
                return splat_choice_rows(c.photographs, c.seed, c.quick);
              }),
          job("fields",
              "ssim and flip, seconds a sample/" + text_of(config.photographs) +
                  text_of(config.fox.parent_path()) + text_of(config.chair) + "/colmap " +
                  colmap_version(),  // which places the chair's photographs
              [](const SplatsSuiteConfig& c) {
                return field_rows(c.photographs, c.fox, c.chair, c.seed, c.quick);
              })};
}

}  // namespace cousin
