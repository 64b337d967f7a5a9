#include "calibration/boards/corner_refinement.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

namespace cousin {
namespace {

/// Least squares of one window; nothing if its pixels do not fix a shift.
std::optional<CornerFit> fit_window(const Image<float>& linear, const BoardTemplate& t,
                                    const PixelBox& window, const Eigen::Vector2d& centre_squares,
                                    double half_squares) {
  Eigen::Matrix4d ata = Eigen::Matrix4d::Zero();
  Eigen::Vector4d atb = Eigen::Vector4d::Zero();
  double bb = 0;
  CornerFit fit;
  const auto half = static_cast<float>(half_squares);
  const Eigen::Vector2f centre = centre_squares.cast<float>();
  for (int y = window.y; y < window.y + window.height; ++y) {
    for (int x = window.x; x < window.x + window.width; ++x) {
      const Eigen::Vector2f d = t.in_squares(x, y) - centre;
      if (!(d.x() >= -half && d.x() < half && d.y() >= -half && d.y() < half)) continue;
      const Eigen::Vector2f slope = gradient(t, x, y);
      const Eigen::Vector4d a(1, t.white(x, y), -slope.x(), -slope.y());
      const double b = linear(t.box.x + x, t.box.y + y);
      ata += a * a.transpose();
      atb += a * b;
      bb += b * b;
      ++fit.pixels;
    }
  }
  if (fit.pixels < 8) return std::nullopt;
  const Eigen::LDLT<Eigen::Matrix4d> ldlt(ata);
  const Eigen::Vector4d solution = ldlt.solve(atb);
  if (!solution.allFinite() || !(solution(1) > 0)) return std::nullopt;
  const Eigen::Matrix4d inverse = ldlt.solve(Eigen::Matrix4d::Identity());
  fit.offset = solution(0);
  fit.contrast = solution(1);
  fit.shift_px = solution.tail<2>() / fit.contrast;
  const double squares = std::max(0.0, bb - solution.dot(atb));
  fit.noise = std::sqrt(squares / (fit.pixels - 4)) / fit.contrast;
  fit.covariance_px2 =
      0.5 * (inverse.bottomRightCorner<2, 2>() + inverse.bottomRightCorner<2, 2>().transpose());
  const bool known = fit.covariance_px2.allFinite() && fit.covariance_px2(0, 0) > 0 &&
                     fit.covariance_px2.determinant() > 0;
  if (!known) return std::nullopt;
  return fit;
}

}  // namespace

std::vector<CornerFit> fit_corners(const Image<float>& linear, const SeedBoard& board,
                                   const Camera& camera,
                                   const Eigen::Matrix3d& normalized_from_board,
                                   const BoardTemplate& t, double window_squares) {
  std::vector<CornerFit> fits;
  for (int row = 0; row < board.squares - 1; ++row) {
    for (int column = 0; column < board.squares - 1; ++column) {
      if (!corner_exists(board, column, row)) continue;
      const Eigen::Vector3d corner = corner_in_world_m(board, column, row);
      const auto seen = [&](double du, double dv) {
        return project(
            camera, normalized_from_board * Eigen::Vector3d(corner.x() + du * board.square_m,
                                                            corner.y() + dv * board.square_m, 1));
      };
      // Box around the window; a window that reaches the image's border is not used.
      const std::optional<Eigen::Vector2d> centre = seen(0, 0);
      if (!centre) continue;
      double x0 = centre->x(), y0 = centre->y(), x1 = x0, y1 = y0;
      bool inside = true;
      for (const double du : {-window_squares, window_squares}) {
        for (const double dv : {-window_squares, window_squares}) {
          const std::optional<Eigen::Vector2d> p = seen(du, dv);
          inside = inside && p;
          if (!p) break;
          x0 = std::min(x0, p->x()), x1 = std::max(x1, p->x());
          y0 = std::min(y0, p->y()), y1 = std::max(y1, p->y());
        }
      }
      PixelBox window{static_cast<int>(std::floor(x0)) - t.box.x,
                      static_cast<int>(std::floor(y0)) - t.box.y, 0, 0};
      window.width = static_cast<int>(std::ceil(x1)) - t.box.x - window.x + 1;
      window.height = static_cast<int>(std::ceil(y1)) - t.box.y - window.y + 1;
      inside = inside && window.x >= 1 && window.y >= 1 && window.x + window.width < t.box.width &&
               window.y + window.height < t.box.height;
      if (!inside) continue;
      std::optional<CornerFit> fit =
          fit_window(linear, t, window, Eigen::Vector2d(column + 1, row + 1), window_squares);
      if (!fit) continue;
      fit->column = column;
      fit->row = row;
      fit->window = window;
      fit->pixel_px = *centre + fit->shift_px;
      fits.push_back(*fit);
    }
  }
  return fits;
}

double refined_blur_px(const Image<float>& linear, const BoardTemplate& t,
                       const std::vector<CornerFit>& fits, double window_squares, double blur_px) {
  constexpr double kLeast = 0.25, kMost = 3.0;
  const auto half = static_cast<float>(window_squares);
  double along = 0, squares = 0;
  for (const CornerFit& fit : fits) {
    const Eigen::Vector2f centre(static_cast<float>(fit.column + 1),
                                 static_cast<float>(fit.row + 1));
    const PixelBox& w = fit.window;
    for (int y = w.y; y < w.y + w.height; ++y) {
      for (int x = w.x; x < w.x + w.width; ++x) {
        const Eigen::Vector2f d = t.in_squares(x, y) - centre;
        if (!(d.cwiseAbs().maxCoeff() < half)) continue;
        const double half_laplacian =
            0.5 * (t.white(x + 1, y) + t.white(x - 1, y) + t.white(x, y + 1) + t.white(x, y - 1) -
                   4 * t.white(x, y));
        const double shifted = t.white(x, y) - fit.shift_px.dot(gradient(t, x, y).cast<double>());
        const double left =
            (linear(t.box.x + x, t.box.y + y) - fit.offset) / fit.contrast - shifted;
        along += left * half_laplacian;
        squares += half_laplacian * half_laplacian;
      }
    }
  }
  if (!(squares > 0)) return blur_px;
  return std::sqrt(std::clamp(blur_px * blur_px + along / squares, kLeast * kLeast, kMost * kMost));
}

}  // namespace cousin
