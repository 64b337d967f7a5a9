#include "benchmarks/app/suite_plots.h"

#include "benchmarks/app/bench_output.h"
#include "benchmarks/suites/calibration/studies.h"
#include "benchmarks/suites/renderers/renderers_page.h"
#include "benchmarks/suites/seedlings/seedlings_page.h"
#include "benchmarks/suites/seeds/cousins_suite.h"
#include "benchmarks/suites/seeds/trained_plots.h"
#include "benchmarks/suites/sensors/sensors_page.h"
#include "benchmarks/suites/splats/splats_page.h"

namespace cousin {

void add_plots(SeedsReport& report) {
  report.curves = renderers_curves(report.scores.scores);
  report.lines = sensors_plots(report.scores.scores);
  for (LinePlot& plot : cousins_plots(report.scores.scores))
    report.lines.push_back(std::move(plot));
  for (LinePlot& plot : study_plots(report.scores.scores)) report.lines.push_back(std::move(plot));
  for (ErrorTimeCurve& curve : study_times(report.scores.scores))
    report.curves.push_back(std::move(curve));
  for (ErrorTimeCurve& curve : splats_curves(report.scores.scores))
    report.curves.push_back(std::move(curve));
  for (LinePlot& plot : trained_plots(report.scores.scores))
    report.lines.push_back(std::move(plot));
  for (LinePlot& plot : seedlings_plots(report.scores.scores))
    report.lines.push_back(std::move(plot));
  for (ErrorTimeCurve& curve : seedlings_curves(report.scores.scores))
    report.curves.push_back(std::move(curve));
  report.tables = papers_tables(report.scores.scores);
}

void require_plots(const SeedsReport&) {}

}  // namespace cousin
