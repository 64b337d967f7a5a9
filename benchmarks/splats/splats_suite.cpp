#include "benchmarks/splats/splats_suite.h"

#include "benchmarks/splats/field_rows.h"
#include "benchmarks/splats/kernel_rows.h"
#include "benchmarks/splats/training_rows.h"
#include "perception/splats/splat_train_config.h"
#include "sim/dataset/manifest.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

/// Which set of photographs it is: its list of views says so.
std::string text_of(const fs::path& set) {
  const fs::path list = set.extension() == ".json" ? set : set / "transforms.json";
  const std::string state = fs::is_regular_file(list) ? sha256_hex_of_file(list)
                            : fs::is_directory(set)   ? "there"
                                                      : "absent";
  return set.string() + " " + state;
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
  return {job("kernels", "", [](const SplatsSuiteConfig& c) { return splat_kernel_rows(c.seed); }),
          job("training", text_of(config.photographs),
              [](const SplatsSuiteConfig& c) {
                return splat_training_rows(c.photographs, c.seed, c.quick);
              }),
          job("fields", text_of(config.photographs) + text_of(config.fox) + text_of(config.chair),
              [](const SplatsSuiteConfig& c) {
                return field_rows(c.photographs, c.fox, c.chair, c.seed, c.quick);
              })};
}

}  // namespace cousin
