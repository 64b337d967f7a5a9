#pragma once

#include <vector>

#include "benchmarks/report/report.h"
#include "benchmarks/score/scores.h"

namespace cousin {

/// Error over wall time of Gaussians and of the radiance field, one plot for each set of
/// photographs, of rows of field_rows.h. The error is the root mean square one that the mean PSNR
/// stands for, 10^(-PSNR / 20): a share of the range of codes.
std::vector<ErrorTimeCurve> splats_curves(const std::vector<ScoreRow>& rows);

}  // namespace cousin
