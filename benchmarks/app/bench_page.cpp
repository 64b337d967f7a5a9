#include "benchmarks/app/bench_page.h"

#include <algorithm>
#include <set>
#include <string>

#include "benchmarks/app/suite_plots.h"
#include "benchmarks/loop/result_folder.h"
#include "benchmarks/loop/score_seeds.h"
#include "perception/sfm/colmap_run.h"

namespace cousin {
namespace fs = std::filesystem;

SeedsReport titled(const char* title, const char* summary, ScoreFile scores) {
  SeedsReport report;
  report.title = title;
  report.summary = summary;
  report.scores = std::move(scores);
  return report;
}

void keep_scene(SeedsReport& report, const ReportScene& scene, const fs::path& out) {
  if (scene.pictures.empty()) return;
  write_report_scene(report_scenes_folder(out), scene);
  report.scores.header.more["scenes"] = scene.name;
  report.scenes = {scene};
}

void show_scenes(const std::vector<ShardResult>& results, const fs::path& folder,
                 SeedsReport& report) {
  std::set<std::string> shown;
  for (const ShardResult& result : results) {
    if (!result.text.empty()) shown.insert(fs::path(result.name).stem());
  }
  report.scenes =
      read_report_scenes(folder, [&](const std::string& name) { return shown.contains(name); });
  std::string& names = report.scores.header.more["scenes"];
  for (const ReportScene& scene : report.scenes) names += (names.empty() ? "" : " ") + scene.name;
}

void note_missing(const JobContext& context, const std::vector<ShardResult>& results,
                  SeedsReport& report) {
  const auto missing = std::count_if(results.begin(), results.end(), is_missing);
  if (missing == 0) return;
  const std::string note =
      std::to_string(missing) + " of " + std::to_string(results.size()) + " jobs are not there yet";
  context.progress.line(note);
  report.scores.header.more["note"] = note;
}

ScoreFile finish(SeedsReport report, const JobContext& context, const fs::path& out) {
  add_plots(report);
  ScoreHeader& header = report.scores.header;
  header.program_version = COUSIN_VERSION;
  if (header.machine.empty()) header.machine = machine_text();
  const auto& rows = report.scores.scores;
  const bool is_by_colmap = std::any_of(rows.begin(), rows.end(), [](const ScoreRow& row) {
    return row.suite == "sfm" || row.suite == "splats" || is_posed_by_tracks(row);
  });
  if (is_by_colmap) header.more["colmap"] = colmap_version();
  header.more["command"] = report.command_line = context.command_line;
  header.more["title"] = report.title;
  header.more["summary"] = report.summary;
  write_report_folder(out, report);
  context.progress.line("scores: " + (out / "scores.csv").string() +
                        ", report: " + (out / "report.html").string());
  return report.scores;
}

}  // namespace cousin
