#include "benchmarks/app/views_options.h"

#include <algorithm>
#include <cstdio>
#include <stdexcept>
#include <utility>

#include "benchmarks/app/option_keys.h"

namespace cousin {
namespace {

std::string number_of(const std::vector<ScoreRow>& rows, const std::string& metric) {
  for (const ScoreRow& row : rows) {
    if (row.metric != metric) continue;
    char text[64];
    std::snprintf(text, sizeof text, "%.2f %s of %lld views", row.value, row.unit.c_str(),
                  static_cast<long long>(row.n));
    return text;
  }
  return {};
}

}  // namespace

ViewsPipelineConfig views_config(const Options& options, const std::filesystem::path& file,
                                 const std::vector<std::string>& assignments) {
  const KeyOption method{"--method", "method", options.method};
  return read_config(options, {method}, [&] {
    ViewsPipelineConfig config;
    if (!file.empty()) read_toml(file, fields(config), MissingKeys::keep_default);
    if (!method.value.empty()) set_field(fields(config), method.assignment());
    for (const std::string& assignment : assignments) set_field(fields(config), assignment);
    validate(config);
    return config;
  });
}

std::vector<StageSource> views_sources(const Options& options) {
  std::vector<StageSource> sources;
  for (const std::string& stage : options.stages)
    sources.push_back(parse_stage_source(stage, options.stage_time_limit_s));
  check_stages(sources, views_stage_order(), "views");
  return sources;
}

std::shared_ptr<const LearnedDistance> learned_of(const Options& o) {
  return o.lpips.empty() ? nullptr : load_learned_distance(o.lpips);
}

std::string no_gaussians_text(const SplatModel& none) {
  return "no Gaussians" + (none.why_none.empty() ? "" : ": " + none.why_none);
}

std::string views_summary(const ViewsRun& run, std::size_t frames) {
  const auto posed =
      std::count_if(run.estimate.poses.begin(), run.estimate.poses.end(),
                    [](const FramePose& pose) { return pose.status == PoseStatus::ok; });
  std::string text = std::to_string(posed) + " of " + std::to_string(frames) + " views posed, " +
                     std::to_string(run.estimate.splats.splats.size()) + " Gaussians";
  for (const auto& [metric, words] :
       {std::pair("train.psnr", "trained on"), std::pair("held_out.psnr", "held out")}) {
    const std::string number = number_of(run.rows, metric);
    if (!number.empty()) text += ", " + std::string(words) + " " + number;
  }
  return text;
}

}  // namespace cousin
