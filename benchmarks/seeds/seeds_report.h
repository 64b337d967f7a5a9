#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "benchmarks/metrics/scores.h"
#include "benchmarks/seeds/simulate.h"
#include "perception/pipelines/seeds.h"

namespace cousin {

/// A picture for the report.
struct ReportPicture {
  std::string name;
  std::string caption;
  Image<Rgb8> image;
};

/// What a report of runs of the seeds scene is made of.
struct SeedsReport {
  std::string title = "Cousin: seeds";
  std::string command_line;
  std::string config_toml;
  std::string plan;
  ScoreFile scores;
  std::vector<ReportPicture> pictures;
  Cloud cloud;                 ///< of the scene that is shown in 3D
  std::vector<Mesh> measured;  ///< fitted surfaces, in the world
  std::vector<Mesh> truth;     ///< true surfaces, in the world
};

/// Adds the scene's images, with the measured outlines drawn on one of them, and the shapes for the
/// 3D view.
void add_pictures(SeedsReport& report, const SimulatedRun& run, const SeedsEstimate& estimate);

/// One self-contained HTML file, written whole or not at all.
void write_report(const std::filesystem::path& file, const SeedsReport& report);

}  // namespace cousin
