#include "benchmarks/suites/real/real_report.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/dataset/atomic_file.h"

namespace cousin {
namespace {

/// Least and most of a metric over the rows that have it.
struct Range {
  double least = std::numeric_limits<double>::infinity();
  double most = -std::numeric_limits<double>::infinity();
  std::int64_t n = 0;
};
Range range_of(const std::vector<ScoreRow>& rows, const std::string& method,
               const std::string& metric) {
  Range range;
  for (const ScoreRow& row : rows) {
    if (row.method != method || row.metric != metric || !std::isfinite(row.value)) continue;
    range.least = std::min(range.least, row.value);
    range.most = std::max(range.most, row.value);
    ++range.n;
  }
  return range;
}

std::vector<Headline> headlines_of(const std::vector<ScoreRow>& rows) {
  std::vector<Headline> tiles;
  const auto add = [&](const std::string& label, const std::string& method,
                       const std::string& metric, const std::string& unit) {
    const Range range = range_of(rows, method, metric);
    if (range.n == 0) return;
    const WithInterval value =
        range.n == 1 ? WithInterval{.value = range.least}
                     : WithInterval{0.5 * (range.least + range.most), range.least, range.most};
    tiles.push_back(
        {label, value, unit, range.n == 1 ? "" : "middle [least, most]", ScoreStatus::ok});
  };
  add("maize: IoU with the published carving, no view may miss", "hull, no miss",
      "iou_with_published", "1");
  add("maize: IoU with the published carving, one view may miss", "hull, one miss",
      "iou_with_published", "1");
  const std::string fox = "plane sweep and slanted refinement";
  add("fox: pixels with depth", fox, "pixels_with_depth", "%");
  add("fox: depths within 1 % of another view's", fox, "seen_depths_within_1_percent", "%");
  add("rice: spread of length over its mean, photographed", "photograph", "length.cv", "%");
  add("rice: spread of length over its mean, scene", "scene", "length.cv", "%");
  add("rice: spread of width over its mean, photographed", "photograph", "width.cv", "%");
  add("rice: spread of width over its mean, scene", "scene", "width.cv", "%");
  return tiles;
}

}  // namespace

void write_real_report(const std::filesystem::path& file, const RealResult& result,
                       const std::string& command_line) {
  ReportInput input;
  input.title = "Cousin: bench real";
  input.summary =
      "Real captures through the readers and stages that simulated ones go through. Nobody "
      "measured "
      "these plants, grains or the fox: the numbers say how well two programs or two views agree, "
      "and how real lots compare with the scene's, not how accurate anything is.";
  if (!command_line.empty()) input.commands = {command_line};
  input.scores = result.file;
  input.headlines = headlines_of(result.file.scores);
  input.images = result.page.images;
  input.shapes = result.page.shapes;
  input.distributions = result.page.distributions;
  for (const ScoreRow& row : result.file.scores) {
    if (row.status == ScoreStatus::not_solved || row.status == ScoreStatus::error)
      input.notes.push_back(row.scene + ", " + row.case_name + ": " + row.metric);
  }
  write_file(file, make_report(input));
}

}  // namespace cousin
