#include "benchmarks/suites/calibration/cause_rows.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "benchmarks/score/distributions.h"
#include "benchmarks/score/order_statistics.h"
#include "benchmarks/suites/calibration/calibration_causes.h"
#include "benchmarks/suites/calibration/calibration_row.h"

namespace cousin {
namespace {

constexpr const char* kMethod = "ceres opencv5";
/// Printed by the paper, whichever they are.
constexpr double kOpencv_px = 0.05, kMatlab_px = 0.11;

ScoreRow row_of(const char* scene, const std::string& case_name, std::uint64_t seed,
                std::int64_t n) {
  ScoreRow row = calibration_row(scene, case_name, kMethod, seed);
  row.n = n;
  return row;
}

ScoreRow number(ScoreRow row, const char* metric, const char* unit, double value) {
  row.metric = metric;
  row.unit = unit;
  row.value = value;
  return row;
}

template <class Get>
std::vector<double> finite(const std::vector<CauseOutcome>& outcomes, Get get) {
  std::vector<double> values;
  for (const CauseOutcome& o : outcomes) {
    if (const double v = get(o); std::isfinite(v)) values.push_back(v);
  }
  return values;
}

/// What sigma, in px a coordinate, makes a definition's error what the paper prints: the error
/// is proportional to it.
void definition_rows(std::vector<ScoreRow>& rows, std::uint64_t seed, int count) {
  CalibrationCause noise;
  noise.set = [](double v, CornerViewsConfig& c) { c.noise_px = v; };
  constexpr double kSigma_px = 0.1;
  const std::vector<CauseOutcome> outcomes =
      run_cause(noise, kSigma_px, count, Rng(seed).fork("definitions"));
  struct Definition {
    const char* name;
    double (*get)(const CauseOutcome&);
  };
  for (const Definition& d :
       {Definition{"OpenCV's tutorial: root of the sum of squares over the number of points",
                   [](const CauseOutcome& o) { return o.tutorial_px; }},
        Definition{"MATLAB: mean distance",
                   [](const CauseOutcome& o) { return o.mean_distance_px; }},
        Definition{"cv::calibrateCamera: RMS a point",
                   [](const CauseOutcome& o) { return o.rms_point_px; }}}) {
    const double error_px = mean(finite(outcomes, d.get));
    const ScoreRow row = row_of("reprojection error of 40 corners", d.name, seed, count);
    rows.push_back(number(row, "with corners found to 0.1 px", "px", error_px));
    for (const double printed : {kOpencv_px, kMatlab_px}) {
      char metric[64];
      std::snprintf(metric, sizeof metric, "deviation of the corners where it is %.2f px", printed);
      rows.push_back(number(row, metric, "px", kSigma_px * printed / error_px));
    }
    const double rms_px = mean(finite(outcomes, [](const auto& o) { return o.rms_point_px; }));
    rows.push_back(
        number(row, "RMS a point where it is 0.05 px", "px", kOpencv_px * rms_px / error_px));
  }
}

std::string amount_text(const CalibrationCause& cause, double amount) {
  char text[48];
  std::snprintf(text, sizeof text, " %g%s%s", amount, cause.unit == "1" ? "" : " ",
                cause.unit == "1" ? "" : cause.unit.c_str());
  return cause.name + text;
}

void add_outcomes(std::vector<ScoreRow>& rows, const std::string& name,
                  const std::vector<CauseOutcome>& outcomes, std::uint64_t seed) {
  const auto n = static_cast<std::int64_t>(outcomes.size());
  const ScoreRow row = row_of("causes of a wrong calibration", name, seed, n);
  const std::vector<double> p1 = finite(outcomes, [](const auto& o) { return o.p1_error; });
  const std::vector<double> centre = finite(outcomes, [](const auto& o) { return o.centre_px; });
  rows.push_back(number(row, "p1, RMS error", "1", rms(p1)));
  rows.push_back(number(row, "principal point, RMS distance", "px", rms(centre)));
  const auto projection = finite(outcomes, [](const auto& o) { return o.projection_px; });
  rows.push_back(number(row, "projection error, median of those that do not fold", "px",
                        quantile(projection, 0.5)));
  const auto tutorial = finite(outcomes, [](const auto& o) { return o.tutorial_px; });
  rows.push_back(number(row, "reprojection error, tutorial, mean", "px", mean(tutorial)));
  rows.push_back(number(row, "reprojection error, mean distance", "px",
                        mean(finite(outcomes, [](const auto& o) { return o.mean_distance_px; }))));
  const auto share = [&](const char* metric, auto counts) {
    const auto k = std::count_if(outcomes.begin(), outcomes.end(), counts);
    const BinomialInterval interval = binomial_interval(k, n);
    ScoreRow r = number(row, metric, "1", interval.share);
    r.ci_low = interval.low;
    r.ci_high = interval.high;
    rows.push_back(r);
  };
  share("as far off as the paper's: p1 by .014, principal point by 20 px, share",
        [](const CauseOutcome& o) { return o.is_like_paper(); });
  share("so far off with a tutorial error of at most 0.05 px, share",
        [](const CauseOutcome& o) { return o.is_like_paper() && o.tutorial_px <= kOpencv_px; });
  share("refused by our check of the same solution, share",
        [](const CauseOutcome& o) { return o.is_refused; });
}

}  // namespace

std::vector<ScoreRow> cause_rows(std::uint64_t seed, bool quick) {
  const int count = quick ? 10 : 40;
  std::vector<ScoreRow> rows;
  definition_rows(rows, seed, count);
  for (const CalibrationCause& cause : calibration_causes()) {
    for (const double amount : cause.amounts) {
      const std::string name = amount_text(cause, amount);
      add_outcomes(rows, name, run_cause(cause, amount, count, Rng(seed).fork("causes").fork(name)),
                   seed);
    }
  }
  return rows;
}

}  // namespace cousin
