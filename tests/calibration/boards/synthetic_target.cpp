#include "tests/calibration/boards/synthetic_target.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "scenes/boards/marker_codes.h"

namespace cousin::synthetic {
namespace {

/// Codes of a board's markers; empty where it has none.
std::vector<MarkerCode> codes_of(const CalibrationTarget& t) {
  if (t.kind == TargetKind::charuco) return marker_codes(t.dictionary, t.columns * t.rows / 2);
  if (t.kind == TargetKind::april_grid) return kalibr_codes(t.columns * t.rows);
  return {};
}

/// Whether a point of a marker, (0, 0) upper left to (1, 1), is black.
bool code_ink(const MarkerCode& code, int border, const Eigen::Vector2d& p) {
  const int side = code.bits + 2 * border;
  const int c = static_cast<int>(std::floor(p.x() * side)) - border;
  const int r = static_cast<int>(std::floor(p.y() * side)) - border;
  if (c < 0 || r < 0 || c >= code.bits || r >= code.bits) return true;
  return !code.at(c, r);
}

bool disc_ink(const CalibrationTarget& t, const Eigen::Vector2d& at_m) {
  const Eigen::Vector2d p = at_m / t.pitch_m;
  const bool staggered = t.kind == TargetKind::asymmetric_circles;
  const double row = std::round(0.5 * (t.rows - 1) - p.y());
  const double first =
      staggered ? std::fmod(std::abs(row), 2.0) - (t.columns - 0.5) : -0.5 * (t.columns - 1);
  const double step = staggered ? 2 : 1;
  const double column = std::round((p.x() - first) / step);
  if (row < 0 || row >= t.rows || column < 0 || column >= t.columns) return false;
  const Eigen::Vector2d centre(first + step * column, 0.5 * (t.rows - 1) - row);
  return (p - centre).norm() < t.mark_share;
}

bool tag_ink(const CalibrationTarget& t, const std::vector<MarkerCode>& codes,
             const Eigen::Vector2d& p) {
  const double gap = t.mark_share, step = 1 + gap;  // in tags, from the print's lower left
  const int column = static_cast<int>(std::floor(p.x() / step));
  const int row = static_cast<int>(std::floor(p.y() / step));
  const Eigen::Vector2d q(p.x() - column * step - gap, p.y() - row * step - gap);
  if (q.x() < 0 && q.y() < 0) return true;
  if (q.x() < 0 || q.y() < 0) return false;
  return code_ink(codes[static_cast<std::size_t>(row * t.columns + column)], 2, {q.x(), 1 - q.y()});
}

bool has_ink(const CalibrationTarget& t, const std::vector<MarkerCode>& codes,
             const Eigen::Vector2d& at_m, CharucoLayout layout = CharucoLayout::current) {
  if (t.kind == TargetKind::circles || t.kind == TargetKind::asymmetric_circles)
    return disc_ink(t, at_m);
  const Eigen::Vector2d half = 0.5 * print_size_m(t);
  if (!((at_m.array().abs() < half.array()).all())) return false;
  if (t.kind == TargetKind::april_grid) return tag_ink(t, codes, (at_m + half) / t.pitch_m);
  const Eigen::Vector2d p((at_m.x() + half.x()) / t.pitch_m, (half.y() - at_m.y()) / t.pitch_m);
  const int column = static_cast<int>(p.x()), row = static_cast<int>(p.y());
  if ((column + row) % 2 == (is_first_square_black(t, layout) ? 0 : 1)) return true;
  if (codes.empty()) return false;
  const Eigen::Vector2d q = (p - Eigen::Vector2d(column + 0.5, row + 0.5)) / t.mark_share +
                            Eigen::Vector2d::Constant(0.5);
  if (q.minCoeff() < 0 || q.maxCoeff() >= 1) return false;
  return code_ink(codes[static_cast<std::size_t>((row * t.columns + column) / 2)], 1, q);
}

/// Point of the print that a place of the picture shows; NaN where the ray misses its plane.
Eigen::Vector2d on_print(const Lens& lens, const Pose& target_from_camera,
                         const Eigen::Vector2d& pixel_px) {
  const auto ray = lens.unproject(pixel_px);
  if (!ray) return Eigen::Vector2d::Constant(std::nan(""));
  const Eigen::Vector3d d = target_from_camera.rotation * *ray;
  const Eigen::Vector3d& eye = target_from_camera.translation_m;
  const double t = -eye.z() / d.z();
  if (!(t > 0)) return Eigen::Vector2d::Constant(std::nan(""));
  return (eye + t * d).head<2>();
}

}  // namespace

bool is_ink(const CalibrationTarget& target, const Eigen::Vector2d& at_m) {
  return has_ink(target, codes_of(target), at_m);
}

Pose tilted(double distance_m, double tilt_rad, double axis_rad, double roll_rad,
            const Eigen::Vector2d& shift_m) {
  const Eigen::Quaterniond facing(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()));
  const Eigen::AngleAxisd tilt(tilt_rad,
                               Eigen::Vector3d(std::cos(axis_rad), std::sin(axis_rad), 0));
  return {Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitZ()) * tilt * facing,
          {shift_m.x(), shift_m.y(), distance_m}};
}

TargetShot shoot_target(const CalibrationTarget& target, const Camera& camera,
                        const Pose& camera_from_target, const TargetImageConfig& config, Rng rng) {
  const Lens lens(camera);
  const Pose target_from_camera = inverse(camera_from_target);
  const std::vector<MarkerCode> codes = codes_of(target);
  const Eigen::Vector2d half =
      0.5 * print_size_m(target) + Eigen::Vector2d::Constant(0.6 * target.pitch_m);
  const int width = camera.width_px, height = camera.height_px;
  cv::Mat picture(height, width, CV_32F);
  const auto signal = [&](const Eigen::Vector2d& at_m) {
    if (!((at_m.array().abs() < half.array()).all())) return config.background;
    return has_ink(target, codes, at_m, config.layout) != config.swap_colors ? config.black
                                                                             : config.white;
  };
  tbb::parallel_for(0, height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      // The print is nearly affine within a pixel: its corners span the rest.
      std::array<Eigen::Vector2d, 4> corner;
      for (std::size_t k = 0; k < 4; ++k) {
        corner[k] =
            on_print(lens, target_from_camera,
                     {x - 0.5 + static_cast<double>(k % 2), y - 0.5 + static_cast<double>(k / 2)});
      }
      const auto mean_of = [&](int side) {
        double sum = 0;
        for (int j = 0; j < side; ++j) {
          for (int i = 0; i < side; ++i) {
            const double u = (i + 0.5) / side, v = (j + 0.5) / side;
            sum += signal((1 - v) * ((1 - u) * corner[0] + u * corner[1]) +
                          v * ((1 - u) * corner[2] + u * corner[3]));
          }
        }
        return sum / (side * side);
      };
      double value = mean_of(3);
      const double first = signal(corner[0]);
      const bool even = value == first && signal(corner[1]) == first &&
                        signal(corner[2]) == first && signal(corner[3]) == first;
      if (!even) value = mean_of(config.samples);
      picture.at<float>(y, x) = static_cast<float>(value);
    }
  });
  if (config.blur_px > 0) cv::GaussianBlur(picture, picture, {0, 0}, config.blur_px);
  TargetShot shot;
  shot.light = Image<float>(width, height);
  for (int y = 0; y < height; ++y) {
    Rng row = rng.fork("row").fork(static_cast<std::uint64_t>(y));
    for (int x = 0; x < width; ++x) {
      const double noise =
          config.noise > 0 ? config.noise * (config.white - config.black) * normal(row) : 0;
      shot.light(x, y) = picture.at<float>(y, x) + static_cast<float>(noise);
    }
  }
  for (const TargetPoint& p : target_points(target)) {
    const auto at = lens.project(camera_from_target * Eigen::Vector3d(p.at_m.x(), p.at_m.y(), 0));
    if (at && at->x() > -0.5 && at->y() > -0.5 && at->x() < width - 0.5 && at->y() < height - 0.5)
      shot.true_px[p.id] = *at;
  }
  return shot;
}

}  // namespace cousin::synthetic
