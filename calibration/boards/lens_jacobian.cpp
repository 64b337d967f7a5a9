#include "calibration/boards/lens_jacobian.h"

#include <cmath>

namespace cousin {

Eigen::Matrix<double, 2, Eigen::Dynamic> d_pixel_d_distortion(const Camera& camera,
                                                              const Eigen::Vector3d& point) {
  const int count = distortion_count(camera.model);
  Eigen::Matrix<double, 2, Eigen::Dynamic> j(2, count);
  const auto& k = camera.distortion;
  if (camera.model == LensModel::kannala_brandt4) {
    const double r = point.head<2>().norm();
    const double theta = std::atan2(r, point.z());
    const Eigen::Vector2d direction =
        r > 0 ? Eigen::Vector2d(point.head<2>() / r) : Eigen::Vector2d::Zero();
    double power = theta * theta * theta;
    for (int i = 0; i < count; ++i, power *= theta * theta) j.col(i) = power * direction;
  } else if (count > 0) {
    const double x = point.x() / point.z(), y = point.y() / point.z();
    const double r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2;
    const double numerator = 1 + k[0] * r2 + k[1] * r4 + k[4] * r6;
    const double denominator = 1 + k[5] * r2 + k[6] * r4 + k[7] * r6;
    const Eigen::Vector2d radial = Eigen::Vector2d(x, y) / denominator;
    j.col(0) = r2 * radial;
    j.col(1) = r4 * radial;
    j.col(2) << 2 * x * y, r2 + 2 * y * y;
    j.col(3) << r2 + 2 * x * x, 2 * x * y;
    j.col(4) = r6 * radial;
    if (count >= 8) {
      const Eigen::Vector2d below = -numerator / denominator * radial;
      j.col(5) = r2 * below;
      j.col(6) = r4 * below;
      j.col(7) = r6 * below;
    }
    if (count >= 12) {
      j.col(8) << r2, 0;
      j.col(9) << r4, 0;
      j.col(10) << 0, r2;
      j.col(11) << 0, r4;
    }
  }
  j.row(0) *= camera.fx_px;
  j.row(1) *= camera.fy_px;
  return j;
}

}  // namespace cousin
