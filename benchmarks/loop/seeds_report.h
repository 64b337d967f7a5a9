#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "benchmarks/loop/report_scene.h"
#include "benchmarks/report/report.h"
#include "benchmarks/score/scores.h"

namespace cousin {

inline constexpr const char* kMeasuredAgainstTruth =
    "Every number here is measured against the exact shape of the specimens. Intervals are 95 % "
    "bootstrap intervals, drawn by run where there are several runs. The scene and the sensor are "
    "verified against theory only; no real device has been compared with them.";

/// What a report of runs of the seeds scene is made of.
struct SeedsReport {
  std::string title = "Cousin: seeds";
  std::string summary = kMeasuredAgainstTruth;  ///< a paragraph below the title
  std::string command_line;
  std::string config_toml;
  std::string plan;
  ScoreFile scores;
  std::vector<ReportScene> scenes;  ///< shown in pictures and in 3D
  // Beside those of the seeds' own rows; made of rows, never kept.
  std::vector<ErrorTimeCurve> curves;
  std::vector<LinePlot> lines;
  std::vector<ReportTable> tables;
};

/// Adds what a scene shows, in pictures and in 3D, to a page. @param prefix  of all names
void add_scene(const ReportScene& scene, const std::string& prefix, ReportInput& input);

/// One self-contained HTML file, written whole or not at all.
void write_report(const std::filesystem::path& file, const SeedsReport& report);

/// Where a result folder keeps what its page shows of scenes.
std::filesystem::path report_scenes_folder(const std::filesystem::path& folder);

/// The tables, config.toml, plan.txt and report.html made of them and of the scenes, which
/// write_report_scene keeps in report/SCENE/. Where header.more["scenes"] names scenes, with a
/// space between them, the page is made of those again.
void write_report_folder(const std::filesystem::path& folder, const SeedsReport& report);

/// What write_report_folder and write_report_scene write, and `more`: names for a FolderClaim.
std::vector<std::string> report_names(std::vector<std::string> more = {});

/// All that write_report_folder wrote but the page; only scores.json must be there.
/// @throws std::runtime_error naming the file and what is wrong.
SeedsReport read_report_folder(const std::filesystem::path& folder);

}  // namespace cousin
