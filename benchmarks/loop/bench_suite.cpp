#include "benchmarks/loop/bench_suite.h"

#include <set>
#include <utility>

namespace cousin {
namespace fs = std::filesystem;

SuitePage suite_page(ScoreFile scores) {
  SuitePage page;
  page.report.summary = {};
  page.report.scores = std::move(scores);
  return page;
}

SuitePage suite_page(std::vector<ScoreRow> rows) {
  ScoreFile scores;
  scores.scores = std::move(rows);
  return suite_page(std::move(scores));
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

}  // namespace cousin
