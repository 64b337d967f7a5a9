#include "benchmarks/app/bench_output.h"

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <string>
#include <utility>

#include "sim/types/utf8.h"

namespace cousin {
namespace {

void print_scores(const std::vector<ScoreRow>& rows) {
  for (const ScoreRow& row : rows) {
    std::printf("%-9s %-12s %-44s %-13s %-38s %14.6g %-6s",
                std::string(to_string(row.status)).c_str(), terminal_text(row.scene).c_str(),
                terminal_text(row.case_name).c_str(), terminal_text(row.method).c_str(),
                terminal_text(row.metric).c_str(), row.value, terminal_text(row.unit).c_str());
    if (row.ci_low == row.ci_low) std::printf(" [%.6g, %.6g]", row.ci_low, row.ci_high);
    std::printf("\n");
  }
}

}  // namespace

void print_suite(const BenchSuite& suite, const std::vector<ScoreRow>& rows) {
  if (suite.text == nullptr) {
    print_scores(rows);
    return;
  }
  std::printf("%s", suite.text(rows).c_str());
  SeedsReport report;
  report.scores.scores = rows;
  if (suite.plots != nullptr) suite.plots(report);
  for (const ReportTable& table : report.tables) std::printf("\n%s", table_text(table).c_str());
  std::vector<ScoreRow> held;
  std::copy_if(rows.begin(), rows.end(), std::back_inserter(held),
               [](const ScoreRow& row) { return row.status != ScoreStatus::ok; });
  if (held.empty()) return;
  std::printf("\nHeld against limits, and what was not measured\n");
  print_scores(held);
}

}  // namespace cousin
