#include "sim/sensors/lens_unit.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace cousin {

double focus_breathing(double focal_m, double distance_m) {
  if (!(distance_m > 2 * focal_m)) {
    throw std::invalid_argument("focus distance " + std::to_string(distance_m) +
                                " m must exceed twice the focal length " + std::to_string(focal_m) +
                                " m");
  }
  return 1 + focal_m / (distance_m - focal_m);
}

Camera with_focus(Camera camera, double breathing) {
  camera.fx_px *= breathing;
  camera.fy_px *= breathing;
  return camera;
}

LensUnit draw_lens(const Camera& nominal, const LensSpread& spread, const Rng& rng) {
  LensUnit unit;
  Camera camera = nominal;
  Rng lens = rng.fork("lens");
  camera.cx_px += truncated_normal(lens, 0, spread.centre_px);
  camera.cy_px += truncated_normal(lens, 0, spread.centre_px);
  validate(camera);
  unit.at_infinity = camera;

  Rng report = rng.fork("report");
  camera = with_focus(camera, 1 + truncated_normal(report, 0, spread.report_focal));
  camera.cx_px += truncated_normal(report, 0, spread.report_centre_px);
  camera.cy_px += truncated_normal(report, 0, spread.report_centre_px);
  for (double& k : camera.distortion)
    k *= 1 + truncated_normal(report, 0, spread.report_distortion);
  if (!camera.spline.delta_u.empty()) {
    const double factor = 1 + truncated_normal(report, 0, spread.report_distortion);
    for (double& delta : camera.spline.delta_u) delta *= factor;
  }
  validate(camera);
  unit.reported_at_infinity = camera;
  return unit;
}

Camera report_at_focus(const LensUnit& unit, const Camera& now, double focal_m, double focus_error,
                       const Rng& rng) {
  const double breathing = now.fx_px / unit.at_infinity.fx_px;
  if (!(breathing > 1)) return unit.reported_at_infinity;
  Rng focus = rng.fork("reported_focus");
  const double distance_m = focal_m * (1 + 1 / (breathing - 1));
  const double reported_m =
      std::max(distance_m * (1 + truncated_normal(focus, 0, focus_error)), 3 * focal_m);
  return with_focus(unit.reported_at_infinity, focus_breathing(focal_m, reported_m));
}

}  // namespace cousin
