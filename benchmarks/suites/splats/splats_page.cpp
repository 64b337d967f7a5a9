#include "benchmarks/suites/splats/splats_page.h"

#include <algorithm>
#include <cmath>

#include "benchmarks/suites/splats/training_rows.h"

namespace cousin {

std::vector<ErrorTimeCurve> splats_curves(const std::vector<ScoreRow>& rows) {
  std::vector<ErrorTimeCurve> curves;
  for (const ScoreRow& row : rows) {
    if (row.method == kSplatChoices) continue;  // of one length, in no order
    if (row.suite != "splats" || row.metric != "held_out.psnr" || !(row.wall_s > 0)) continue;
    const std::string title = "Views held out, " + row.scene;
    auto curve = std::find_if(curves.begin(), curves.end(),
                              [&](const ErrorTimeCurve& c) { return c.title == title; });
    if (curve == curves.end()) {
      curves.push_back({title, "RMS error of a colour channel, of its range", "1", {}});
      curve = curves.end() - 1;
    }
    WithInterval error;
    error.value = std::pow(10, -row.value / 20);
    curve->points.push_back({row.method, row.case_name, row.wall_s, error});
  }
  return curves;
}

}  // namespace cousin
