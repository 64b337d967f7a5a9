#pragma once

#include <filesystem>
#include <vector>

#include "benchmarks/app/commands.h"
#include "benchmarks/loop/seeds_report.h"
#include "benchmarks/study/shard_scores.h"

namespace cousin {

SeedsReport titled(const char* title, const char* summary, ScoreFile scores);
/// Keeps pictures for the page and notes which it shows.
void keep_scene(SeedsReport& report, const ReportScene& scene, const std::filesystem::path& out);
/// The pictures of the jobs on this page: a --quick run and a full one share the folder.
void show_scenes(const std::vector<ShardResult>& results, const std::filesystem::path& folder,
                 SeedsReport& report);
/// Says on the terminal and on the page how many jobs have no result yet, if any.
void note_missing(const JobContext& context, const std::vector<ShardResult>& results,
                  SeedsReport& report);
/// Heads the tables, writes them and the page.
ScoreFile finish(SeedsReport report, const JobContext& context, const std::filesystem::path& out);

}  // namespace cousin
