#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "benchmarks/app/options.h"
#include "benchmarks/learned/learned_distance.h"
#include "benchmarks/views/perceive_views.h"

namespace cousin {

/// The pipeline views as a command line configures it. @param file  TOML of its keys; empty: the
/// defaults  @param assignments  after it; --method comes before them
/// @throws std::invalid_argument naming the key, its value and its limits
ViewsPipelineConfig views_config(const Options& options, const std::filesystem::path& file,
                                 const std::vector<std::string>& assignments);

/// The network of --lpips; none where it is not given.
std::shared_ptr<const LearnedDistance> learned_of(const Options& o);

/// What is said of an estimate without Gaussians.
std::string no_gaussians_text(const SplatModel& none);

/// @throws std::invalid_argument naming a stage that the pipeline has not: it would be read and
/// never used
std::vector<StageSource> views_sources(const Options& options);

/// "12 of 12 views posed, 900 Gaussians, trained on 25.10 dB of 9 views, held out ...".
std::string views_summary(const ViewsRun& run, std::size_t frames);

}  // namespace cousin
