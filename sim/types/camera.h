#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "sim/types/spline_lens.h"

namespace cousin {

/// Central lens models. `opencv5`: k1 k2 p1 p2 k3; `opencv8` adds k4 k5 k6 (rational); `opencv12`
/// adds s1 s2 s3 s4 (thin prism) [OpenCV 4.6 calib3d documentation, "Camera Calibration and 3D
/// Reconstruction"]. `kannala_brandt4`: theta_d = theta (1 + k1 theta^2 + ... + k4 theta^8)
/// [Kannala & Brandt, TPAMI 2006; the form of cv::fisheye]. `splined_stereographic`: mrcal's, whose
/// control points are in Camera::spline.
enum class LensModel {
  pinhole,
  opencv5,
  opencv8,
  opencv12,
  kannala_brandt4,
  splined_stereographic
};

std::string_view to_string(LensModel model);
/// @throws std::invalid_argument naming the text and the names that exist.
LensModel lens_model_from_string(std::string_view text);
/// Of Camera::distortion.
int distortion_count(LensModel model);

/// A lens and its imager, as plain numbers. Pixel (0, 0) is a pixel's centre.
struct Camera {
  LensModel model = LensModel::pinhole;
  int width_px = 0;
  int height_px = 0;
  double fx_px = 0;
  double fy_px = 0;
  double cx_px = 0;
  double cy_px = 0;
  std::array<double, 12> distortion{};  ///< in the order above; unused ones are zero
  SplineLens spline;                    ///< of a splined lens; else as it is by default

  bool operator==(const Camera&) const = default;
};

/// Checks numbers (finite, focal lengths > 0, size 1..65535 and at most 2^28 pixels, principal
/// point within one image size of the image, unused coefficients zero) and that distortion is
/// one-to-one inside the image: every border and grid pixel unprojects, projects back within 1e-6
/// px, and the Jacobian determinant of the distortion is positive there. A splined lens must have a
/// valid spline that does not fold wherever it lands inside the image. @throws
/// std::invalid_argument naming field, value and limit.
void validate(const Camera& camera);

/// Pixel of a point in camera coordinates, or nothing where the model is not valid (depth <= 0 for
/// all but Kannala-Brandt and splines; denominator of the rational model <= 0; beyond the radius
/// where the radial polynomial folds; where the spline's surface does not reach). The pixel may lie
/// outside the image.
std::optional<Eigen::Vector2d> project(const Camera& camera,
                                       const Eigen::Vector3d& point_in_camera_m);

/// d(pixel)/d(point) where `project` gives a value.
struct Projection {
  Eigen::Vector2d pixel_px;
  Eigen::Matrix<double, 2, 3> d_point;  ///< pixels per metre
};
std::optional<Projection> project_with_jacobian(const Camera& camera,
                                                const Eigen::Vector3d& point_in_camera_m);

/// Unit direction in camera coordinates of a pixel, by Newton's method safeguarded by a bracket on
/// the radius and step halving; nothing where no direction reprojects within 1e-9 of the focal
/// length.
std::optional<Eigen::Vector3d> unproject(const Camera& camera, const Eigen::Vector2d& pixel_px);

/// Largest undistorted radius (or, for Kannala-Brandt, angle) up to which the radial map increases;
/// infinity if it never folds (pi for Kannala-Brandt) or the lens is splined.
double monotone_limit(const Camera& camera);

/// A camera for many points: where its radial map folds is found once, not for every point as by
/// the functions above, which give the same values.
class Lens {
 public:
  explicit Lens(const Camera& camera);

  const Camera& camera() const { return camera_; }
  double monotone_limit() const { return limit_; }
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& point_in_camera_m) const;
  std::optional<Projection> project_with_jacobian(const Eigen::Vector3d& point_in_camera_m) const;
  std::optional<Eigen::Vector3d> unproject(const Eigen::Vector2d& pixel_px) const;

 private:
  Camera camera_;
  double limit_ = 0;
};

/// The same lens at another image size: intrinsics scale about the image corner (-0.5, -0.5).
Camera resized(const Camera& camera, int width_px, int height_px);

}  // namespace cousin
