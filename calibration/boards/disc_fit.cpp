#include "calibration/boards/disc_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace cousin {
namespace {

// The shape is L L' of a lower triangle (l11, l21, l22).
enum Unknown { kX, kY, k11, k21, k22, kBlur, kBlack, kRise, kCount };
using Vector = Eigen::Matrix<double, kCount, 1>;
using Matrix = Eigen::Matrix<double, kCount, kCount>;

struct Pixel {
  Eigen::Vector2d at_px;
  double signal = 0;
};

struct Sum {
  Matrix jtj = Matrix::Zero();
  Vector jtr = Vector::Zero();
  double squares = 0, weighted = 0, weights = 0;
};

/// Distance to the outline, to first order f / |grad f| with f = (q - 1/q)/2 for q = |L' (x - c)|,
/// whose slope is right at the outline and finite at the centre's side of it.
double model(const Vector& p, const Eigen::Vector2d& at_px, Vector& d) {
  const Eigen::Vector2d away = at_px - p.head<2>();
  Eigen::Matrix2d l;
  l << p(k11), 0, p(k21), p(k22);
  const Eigen::Vector2d w = l.transpose() * away;
  const double q = std::max(1e-9, w.norm());
  const Eigen::Vector2d slope = l * w / q;  // of q
  const double steep = std::max(1e-12, slope.norm());
  const double distance = (q - 1) / steep;
  const double t = distance / p(kBlur);
  const double value = 0.5 * (1 + std::erf(t / std::numbers::sqrt2));
  const double density = std::exp(-0.5 * t * t) / std::sqrt(2 * std::numbers::pi);
  // The steepness changes slowly: its own derivative is left out, which costs steps, not accuracy.
  const double front = p(kRise) * density / (p(kBlur) * steep);
  const Eigen::Vector2d dq_dw = w / q;
  d.head<2>() = -front * slope;
  d(k11) = front * dq_dw.x() * away.x();
  d(k21) = front * dq_dw.x() * away.y();
  d(k22) = front * dq_dw.y() * away.y();
  d(kBlur) = -p(kRise) * density * t / p(kBlur);
  d(kBlack) = 1;
  d(kRise) = value;
  return p(kBlack) + p(kRise) * value;
}

Sum sum_over(const std::vector<Pixel>& pixels, const Vector& p) {
  Sum sum;
  Vector d;
  for (const Pixel& pixel : pixels) {
    const double r = pixel.signal - model(p, pixel.at_px, d);
    sum.jtj += d * d.transpose();
    sum.jtr += d * r;
    sum.squares += r * r;
    const double weight = d.head<2>().squaredNorm();
    sum.weighted += weight * r * r;
    sum.weights += weight;
  }
  return sum;
}

bool descend(const std::vector<Pixel>& pixels, double most_shift_px, Vector& p, Sum& sum) {
  const Eigen::Vector2d start = p.head<2>();
  double damping = 1e-3;
  sum = sum_over(pixels, p);
  for (int i = 0; i < 60; ++i) {
    Matrix a = sum.jtj;
    a.diagonal() *= 1 + damping;
    const Vector step = a.ldlt().solve(sum.jtr);
    if (!step.allFinite()) return false;
    Vector next = p + step;
    next(kBlur) = std::clamp(next(kBlur), 0.25, 8.0);
    const bool allowed =
        (next.head<2>() - start).norm() < most_shift_px && next(k11) > 0 && next(k22) > 0;
    const Sum tried = allowed ? sum_over(pixels, next) : Sum{};
    if (!allowed || !(tried.squares <= sum.squares)) {
      damping *= 10;
      if (damping > 1e8) return allowed;
      continue;
    }
    const bool done =
        step.head<2>().norm() < 1e-6 && sum.squares - tried.squares <= 1e-9 * sum.squares;
    p = next;
    sum = tried;
    damping = std::max(1e-9, 0.1 * damping);
    if (done) return true;
  }
  return true;
}

/// Pixels looked at, both ends included.
struct DiscWindow {
  int x0, x1, y0, y1;
};

DiscWindow window_about(const Eigen::Vector2d& start_px, double half) {
  const int x0 = static_cast<int>(std::floor(start_px.x() - half)),
            x1 = x0 + static_cast<int>(2 * half) + 1;
  const int y0 = static_cast<int>(std::floor(start_px.y() - half)),
            y1 = y0 + static_cast<int>(2 * half) + 1;
  return {x0, x1, y0, y1};
}

struct DiscLevels {
  double black = 0, white = 0;
};

/// Black at the start, white as the brightest on a ring about it.
DiscLevels disc_levels(const Image<float>& signal, const Eigen::Vector2d& start_px,
                       double ring_px) {
  DiscLevels levels;
  levels.black =
      static_cast<double>(signal(static_cast<int>(std::lround(start_px.x())) < signal.width()
                                     ? static_cast<int>(std::lround(start_px.x()))
                                     : signal.width() - 1,
                                 static_cast<int>(std::lround(start_px.y())) < signal.height()
                                     ? static_cast<int>(std::lround(start_px.y()))
                                     : signal.height() - 1));
  levels.white = levels.black;
  for (int k = 0; k < 16; ++k) {
    const double a = 2 * std::numbers::pi * k / 16;
    const int x = static_cast<int>(std::lround(start_px.x() + ring_px * std::cos(a)));
    const int y = static_cast<int>(std::lround(start_px.y() + ring_px * std::sin(a)));
    if (signal.contains(x, y))
      levels.white = std::max(levels.white, static_cast<double>(signal(x, y)));
  }
  return levels;
}

/// Moments of the dark pixels.
struct DarkMoments {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Matrix2d second = Eigen::Matrix2d::Zero();
};

std::optional<DarkMoments> dark_moments(const Image<float>& signal, const Eigen::Vector2d& start_px,
                                        double ring_px, const DiscLevels& levels,
                                        const DiscWindow& window) {
  const double black = levels.black, white = levels.white;
  const auto dark_at = [&](int x, int y) {
    const double away = (Eigen::Vector2d(x, y) - start_px).norm();
    if (!signal.contains(x, y) || away > ring_px) return 0.0;
    return std::clamp(
        (0.75 * white + 0.25 * black - static_cast<double>(signal(x, y))) / (white - black), 0.0,
        0.5);
  };
  double mass = 0;
  DarkMoments moments;
  for (int y = window.y0; y <= window.y1; ++y) {
    for (int x = window.x0; x <= window.x1; ++x) {
      const double dark = dark_at(x, y);
      mass += dark;
      moments.mean += dark * Eigen::Vector2d(x, y);
    }
  }
  if (!(mass > 2)) return std::nullopt;
  moments.mean /= mass;
  for (int y = window.y0; y <= window.y1; ++y) {
    for (int x = window.x0; x <= window.x1; ++x) {
      const Eigen::Vector2d away = Eigen::Vector2d(x, y) - moments.mean;
      moments.second += dark_at(x, y) / mass * away * away.transpose();
    }
  }
  return moments;
}

/// Pixels near the outline |l' (x - mean)| = 1, and some of the inside.
std::vector<Pixel> pixels_near_outline(const Image<float>& signal, const DiscWindow& window,
                                       const Eigen::Vector2d& mean, const Eigen::Matrix2d& l,
                                       double reach_px) {
  std::vector<Pixel> pixels;
  for (int y = window.y0; y <= window.y1; ++y) {
    for (int x = window.x0; x <= window.x1; ++x) {
      if (!signal.contains(x, y)) continue;
      const Eigen::Vector2d w = l.transpose() * (Eigen::Vector2d(x, y) - mean);
      const double q = std::max(1e-9, w.norm());
      const double distance = (q - 1) / std::max(1e-12, (l * w).norm() / q);
      if (distance > reach_px || distance < -std::max(3.0, reach_px)) continue;
      pixels.push_back({Eigen::Vector2d(x, y), static_cast<double>(signal(x, y))});
    }
  }
  return pixels;
}

/// What the unknowns and the sums at the minimum say; nothing if they do not fix the centre.
std::optional<DiscFit> disc_fit_of(const Vector& p, const Sum& sum, int pixels) {
  const Matrix inverse = sum.jtj.ldlt().solve(Matrix::Identity());
  DiscFit fit;
  fit.centre_px = p.head<2>();
  Eigen::Matrix2d fitted;
  fitted << p(k11), 0, p(k21), p(k22);
  fit.shape = fitted * fitted.transpose();
  fit.unit_covariance_px2 =
      0.5 * (inverse.topLeftCorner<2, 2>() + inverse.topLeftCorner<2, 2>().transpose());
  if (!fit.unit_covariance_px2.allFinite() || !(fit.unit_covariance_px2(0, 0) > 0) ||
      !(sum.weights > 0))
    return std::nullopt;
  fit.pixels = pixels;
  fit.noise = std::sqrt(sum.weighted / sum.weights * fit.pixels / (fit.pixels - kCount));
  fit.contrast = p(kRise);
  fit.blur_px = p(kBlur);
  return fit;
}

}  // namespace

std::optional<DiscFit> fit_disc(const Image<float>& signal, const Eigen::Vector2d& start_px,
                                double radius_px, double reach_px) {
  const double half = 1.4 * radius_px + reach_px;
  if (!start_px.allFinite() || !(radius_px > 1.5) || !(half < 4000)) return std::nullopt;
  const DiscWindow window = window_about(start_px, half);
  if (!signal.contains(static_cast<int>(start_px.x()), static_cast<int>(start_px.y())))
    return std::nullopt;
  // Levels, and the shape from the dark pixels' moments.
  const double ring_px = radius_px + reach_px;
  const DiscLevels levels = disc_levels(signal, start_px, ring_px);
  if (!(levels.white > levels.black)) return std::nullopt;
  const std::optional<DarkMoments> dark = dark_moments(signal, start_px, ring_px, levels, window);
  if (!dark) return std::nullopt;
  // A uniform ellipse has a quarter of its squared half axes as second moments.
  const Eigen::Matrix2d shape = (4 * dark->second).inverse();
  if (!shape.allFinite() || !(shape.determinant() > 0)) return std::nullopt;
  const Eigen::LLT<Eigen::Matrix2d> llt(shape);
  const Eigen::Matrix2d l = llt.matrixL();

  const std::vector<Pixel> pixels = pixels_near_outline(signal, window, dark->mean, l, reach_px);
  if (static_cast<int>(pixels.size()) < 3 * kCount) return std::nullopt;
  Vector p;
  p << dark->mean, l(0, 0), l(1, 0), l(1, 1), 1, levels.black, levels.white - levels.black;
  Sum sum;
  if (!descend(pixels, 0.5 * radius_px, p, sum)) return std::nullopt;
  return disc_fit_of(p, sum, static_cast<int>(pixels.size()));
}

Eigen::Vector2d disc_centre_shift_px(const Eigen::Matrix3d& pixel_from_plane,
                                     const Eigen::Vector2d& centre_m, double radius_m) {
  // The dual conic of the outline; the ellipse's centre is what it makes of the line at infinity.
  Eigen::Matrix3d circle = Eigen::Matrix3d::Identity();
  circle(2, 2) = -radius_m * radius_m;
  Eigen::Matrix3d dual = circle.inverse();
  Eigen::Matrix3d to_centre = Eigen::Matrix3d::Identity();
  to_centre.topRightCorner<2, 1>() = centre_m;
  const Eigen::Matrix3d m = pixel_from_plane * to_centre;
  dual = m * dual * m.transpose();
  const Eigen::Vector2d ellipse = dual.col(2).head<2>() / dual(2, 2);
  const Eigen::Vector3d seen = m.col(2);
  return seen.head<2>() / seen.z() - ellipse;
}

}  // namespace cousin
