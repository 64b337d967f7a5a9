#include <cmath>

#include "calibration/boards/board_bundle.h"

namespace cousin {

/// Without Ceres each view keeps its own pose, found through the reported lens.
BundleResult bundle_adjust(const std::vector<BundleView>& views, const BoardPosesConfig&, bool) {
  BundleResult result;
  result.converged = true;
  for (const BundleView& view : views) {
    double squares_px2 = 0;
    for (const BoardPoint& p : view.points) {
      squares_px2 +=
          (project(view.reported, view.camera_from_board * p.in_board_m).value_or(p.pixel_px) -
           p.pixel_px)
              .squaredNorm();
    }
    BundleResult::View out{view.camera_from_board, view.reported};
    out.rms_px = std::sqrt(squares_px2 / (2.0 * static_cast<double>(view.points.size())));
    result.views.push_back(out);
  }
  return result;
}

}  // namespace cousin
