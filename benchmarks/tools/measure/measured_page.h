#pragma once

#include <string>
#include <vector>

#include "benchmarks/loop/report_scene.h"
#include "benchmarks/report/report.h"
#include "benchmarks/tools/measure/measured_table.h"
#include "perception/pipelines/estimate.h"
#include "sim/types/capture.h"

namespace cousin {

/// What a page shows of one sample: seeds by number in the view that looks down most, outlines that
/// were found in two views, the measured surfaces.
ReportScene measured_scene(const std::string& name, const Capture& capture,
                           const Estimate& estimate);

struct MeasuredPage {
  std::string title;
  std::string command_line;
  std::string config_toml;
  std::string group;  ///< what groups are called, "cultivar"; "" = samples are not compared
  std::vector<MeasuredSample> samples;
  std::vector<ReportScene> scenes;  ///< one a sample
  std::vector<std::string> notes;   ///< warnings
};

/// The table's rows, sample after sample.
std::vector<MeasuredRow> all_rows(const MeasuredPage& page);

/// The page: a sentence of what was measured, a table a sample in millimetres with 95 % intervals,
/// how traits are spread, groups compared, pictures.
ReportInput measured_page(const MeasuredPage& page);

/// Comparison of groups as tables, for the page and for a terminal. Nothing for one group.
std::vector<ReportTable> group_tables(const MeasuredPage& page);

}  // namespace cousin
