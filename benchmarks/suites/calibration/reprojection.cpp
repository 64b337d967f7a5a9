#include "benchmarks/suites/calibration/reprojection.h"

#include <cmath>
#include <limits>
#include <map>

namespace cousin {

ReprojectionErrors reprojection_errors(const CalibrationResult& result) {
  struct View {
    double squares = 0;
    int count = 0;
  };
  std::map<int, View> views;
  double squares = 0, distances = 0;
  int count = 0;
  for (const CalibrationResidual& r : result.residuals) {
    if (r.rejected) continue;
    const double square = r.residual_px.squaredNorm();
    squares += square;
    distances += std::sqrt(square);
    ++count;
    View& view = views[r.view];
    view.squares += square;
    ++view.count;
  }
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  if (count == 0) return {kNone, kNone, kNone, kNone};
  ReprojectionErrors errors;
  errors.rms_coordinate_px = std::sqrt(squares / (2 * count));
  errors.rms_point_px = std::sqrt(squares / count);
  errors.mean_distance_px = distances / count;
  for (const auto& [index, view] : views) {
    errors.tutorial_px += std::sqrt(view.squares) / view.count / static_cast<double>(views.size());
  }
  return errors;
}

}  // namespace cousin
