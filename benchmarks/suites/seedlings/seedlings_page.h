#pragma once

#include <vector>

#include "benchmarks/report/report.h"
#include "benchmarks/score/scores.h"

namespace cousin {

/// Of rows of seedlings_rows.h: PSNR over wall time by light and set of views scored, means over
/// the samples; PSNR over the share of the surface that enough views see, a point a sample and set
/// of photographs; PSNR beside the published mean.
std::vector<LinePlot> seedlings_plots(const std::vector<ScoreRow>& rows);

/// Tables 2 to 4 of the Seedlings paper, one a light: what it published beside each method after
/// each of its steps on all photographs, means over samples; and what fewer views do.
std::vector<ReportTable> seedlings_tables(const std::vector<ScoreRow>& rows);

/// Held-out error over wall time by light, with its Pareto front: the RMS difference of a colour
/// channel that the mean PSNR stands for, 10^(-PSNR / 20).
std::vector<ErrorTimeCurve> seedlings_curves(const std::vector<ScoreRow>& rows);

}  // namespace cousin
