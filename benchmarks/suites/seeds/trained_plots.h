#pragma once

#include <vector>

#include "benchmarks/report/report.h"
#include "benchmarks/score/scores.h"

namespace cousin {

/// PSNR over the seconds of training, on views trained on and on views held out, of each capture of
/// seeds that models were trained on.
std::vector<LinePlot> trained_plots(const std::vector<ScoreRow>& rows);

}  // namespace cousin
