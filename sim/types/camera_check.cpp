#include <Eigen/Geometry>
#include <cmath>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>

#include "sim/types/camera.h"

namespace cousin {
namespace {

std::string describe(const char* field, double value) {
  std::ostringstream text;
  text.precision(17);
  text << field << " = " << value;
  return text.str();
}

/// The spline's own numbers, and that it does not fold where it lands inside the image.
void check_spline(const Camera& camera) {
  if (camera.model != LensModel::splined_stereographic) {
    if (camera.spline == SplineLens{}) return;
    throw std::invalid_argument("camera: spline is set, but the lens is " +
                                std::string(to_string(camera.model)));
  }
  validate(camera.spline);
  const Eigen::Vector2d f(camera.fx_px, camera.fy_px), c(camera.cx_px, camera.cy_px);
  const Eigen::Vector2d size(camera.width_px, camera.height_px);
  const Eigen::Vector2d low = (-0.5 - c.array()) / f.array();
  const std::optional<Eigen::Vector2d> fold =
      fold_within(camera.spline, low, low + size.cwiseQuotient(f));
  if (!fold) return;
  const Eigen::Vector2d pixel = c + f.cwiseProduct(*fold);
  std::ostringstream text;
  text << "camera: the splined_stereographic lens is not one-to-one at pixel (" << pixel.x() << ", "
       << pixel.y() << "): its surface folds inside the image";
  throw std::invalid_argument(text.str());
}

}  // namespace

void validate(const Camera& camera) {
  const auto fail = [](const std::string& what) { throw std::invalid_argument("camera: " + what); };
  const auto size_ok = [](int size) { return size >= 1 && size <= 65535; };
  if (!size_ok(camera.width_px))
    fail(describe("width_px", camera.width_px) + " is outside 1..65535");
  if (!size_ok(camera.height_px))
    fail(describe("height_px", camera.height_px) + " is outside 1..65535");
  if (static_cast<double>(camera.width_px) * camera.height_px > 0x1p28) {
    fail("width_px * height_px is above 2^28 pixels");
  }
  const auto focal_ok = [](double f) { return std::isfinite(f) && f > 0 && f < 1e7; };
  if (!focal_ok(camera.fx_px)) fail(describe("fx_px", camera.fx_px) + " is not in (0, 1e7)");
  if (!focal_ok(camera.fy_px)) fail(describe("fy_px", camera.fy_px) + " is not in (0, 1e7)");
  const auto centre_ok = [](double c, int size) {
    return std::isfinite(c) && c > -size && c < 2.0 * size;
  };
  if (!centre_ok(camera.cx_px, camera.width_px)) {
    fail(describe("cx_px", camera.cx_px) + " is more than one width from the image");
  }
  if (!centre_ok(camera.cy_px, camera.height_px)) {
    fail(describe("cy_px", camera.cy_px) + " is more than one height from the image");
  }
  for (std::size_t i = 0; i < camera.distortion.size(); ++i) {
    const std::string name = "distortion[" + std::to_string(i) + "]";
    const double value = camera.distortion[i];
    if (!std::isfinite(value)) fail(describe(name.c_str(), value) + " is not finite");
    if (static_cast<int>(i) >= distortion_count(camera.model) && value != 0) {
      fail(describe(name.c_str(), value) + " is not a coefficient of " +
           std::string(to_string(camera.model)) + " and must be 0");
    }
  }
  check_spline(camera);
  if (camera.model == LensModel::pinhole) return;

  const Lens lens(camera);
  constexpr int kGrid = 16;
  const auto check = [&](double x, double y) {
    const Eigen::Vector2d pixel(x, y);
    const std::optional<Eigen::Vector3d> ray = lens.unproject(pixel);
    const std::optional<Projection> back = ray ? lens.project_with_jacobian(*ray) : std::nullopt;
    // The image is not mirrored: the pixel's gradients turn about the ray as x and y do.
    const bool ok = back && (back->pixel_px - pixel).norm() < 1e-6 &&
                    Eigen::Vector3d(back->d_point.row(0))
                            .cross(Eigen::Vector3d(back->d_point.row(1)))
                            .dot(*ray) > 0;
    if (!ok) {
      std::ostringstream text;
      text << "the " << to_string(camera.model) << " lens is not one-to-one at pixel (" << x << ", "
           << y << "): its distortion folds inside the image (the radial map increases up to "
           << lens.monotone_limit() << ")";
      fail(text.str());
    }
  };
  for (int i = 0; i <= kGrid; ++i) {
    for (int j = 0; j <= kGrid; ++j) {
      check(-0.5 + static_cast<double>(camera.width_px) * i / kGrid,
            -0.5 + static_cast<double>(camera.height_px) * j / kGrid);
    }
  }
}

}  // namespace cousin
