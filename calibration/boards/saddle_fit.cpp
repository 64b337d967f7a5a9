#include "calibration/boards/saddle_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "sim/types/pi.h"

namespace cousin {
namespace {

constexpr double kLeastBlur_px = 0.25, kMostBlur_px = 8;

// Gauss-Legendre, ten nodes on [-1, 1]: the positive five.
constexpr std::array<double, 5> kNodes = {0.14887433898163122, 0.43339539412924719,
                                          0.67940956829902441, 0.86506336668898451,
                                          0.97390652851717172};
constexpr std::array<double, 5> kWeights = {0.29552422471475287, 0.26926671930999636,
                                            0.21908636251598204, 0.14945134915058059,
                                            0.06667134430868814};

enum Unknown { kX, kY, kFirst, kSecond, kBlur, kLevel, kRise, kBend, kCount };
using Vector = Eigen::Matrix<double, kCount, 1>;
using Matrix = Eigen::Matrix<double, kCount, kCount>;

struct Pixel {
  Eigen::Vector2d at_px;
  double signal = 0;
};

struct Sum {
  Matrix jtj = Matrix::Zero();
  Vector jtr = Vector::Zero();
  double squares = 0;
  double weighted = 0, weights = 0;  ///< squares where the place shows
};

/// The model's signal at a pixel and its derivatives.
double model(const Vector& p, const Eigen::Vector2d& at_px, Vector& d) {
  const double blur = p(kBlur);
  const Eigen::Vector2d away = (at_px - p.head<2>()) / blur;
  const Eigen::Vector2d n1(std::cos(p(kFirst)), std::sin(p(kFirst)));
  const Eigen::Vector2d n2(std::cos(p(kSecond)), std::sin(p(kSecond)));
  const double u = n1.dot(away), v = n2.dot(away);
  const SaddleValue s = blurred_saddle(u, v, n1.dot(n2));
  const double slope = p(kRise) - 2 * p(kBend) * s.value;
  const double turn = std::sin(p(kFirst) - p(kSecond));
  d.head<2>() = -slope / blur * (s.d_u * n1 + s.d_v * n2);
  d(kFirst) = slope * (s.d_u * (n1.x() * away.y() - n1.y() * away.x()) - s.d_correlation * turn);
  d(kSecond) = slope * (s.d_v * (n2.x() * away.y() - n2.y() * away.x()) + s.d_correlation * turn);
  d(kBlur) = -slope / blur * (s.d_u * u + s.d_v * v);
  d(kLevel) = 1;
  d(kRise) = s.value;
  d(kBend) = 1 - s.value * s.value;
  return p(kLevel) + p(kRise) * s.value + p(kBend) * d(kBend);
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

/// Level, rise and bend for the place, edges and blur given: linear.
void set_levels(const std::vector<Pixel>& pixels, Vector& p) {
  Eigen::Matrix3d ata = Eigen::Matrix3d::Zero();
  Eigen::Vector3d atb = Eigen::Vector3d::Zero();
  Vector d;
  p.tail<3>().setZero();
  for (const Pixel& pixel : pixels) {
    model(p, pixel.at_px, d);
    ata += d.tail<3>() * d.tail<3>().transpose();
    atb += d.tail<3>() * pixel.signal;
  }
  ata.diagonal().array() += 1e-9 * ata.trace();
  p.tail<3>() = ata.ldlt().solve(atb);
}

/// Levenberg-Marquardt; false where the place or the edges leave their bounds.
bool descend(const std::vector<Pixel>& pixels, const SaddleStart& start,
             const SaddleFitConfig& config, Vector& p, Sum& sum) {
  double damping = 1e-3;
  sum = sum_over(pixels, p);
  for (int i = 0; i < config.max_iterations; ++i) {
    Matrix a = sum.jtj;
    a.diagonal() *= 1 + damping;
    a.diagonal().array() += 1e-12 * sum.jtj.trace();
    const Vector step = a.ldlt().solve(sum.jtr);
    if (!step.allFinite()) return false;
    Vector next = p + step;
    next(kBlur) = std::clamp(next(kBlur), kLeastBlur_px, kMostBlur_px);
    if (std::abs(std::sin(next(kFirst) - next(kSecond))) < config.min_edge_angle ||
        (next.head<2>() - start.pixel_px).norm() > config.max_shift_px) {
      damping *= 10;
      if (damping > 1e8) return false;
      continue;
    }
    const Sum tried = sum_over(pixels, next);
    if (!(tried.squares <= sum.squares)) {
      damping *= 10;
      if (damping > 1e8) return true;  // as low as numbers go
      continue;
    }
    const bool done =
        step.head<2>().norm() < 1e-6 && sum.squares - tried.squares <= 1e-9 * sum.squares;
    p = next;
    sum = tried;
    damping = std::max(1e-9, 0.1 * damping);
    if (done) return true;
  }
  return true;  // slow only along blur and bend, which leave the place alone
}

Eigen::Vector2d along(double normal_rad, const Eigen::Vector2d& direction) {
  const Eigen::Vector2d t(-std::sin(normal_rad), std::cos(normal_rad));
  return t.dot(direction) < 0 ? Eigen::Vector2d(-t) : t;
}

}  // namespace

SaddleValue blurred_saddle(double u, double v, double correlation) {
  const double end = std::asin(std::clamp(correlation, -0.999, 0.999));
  const double rho = std::sin(end), rest = std::cos(end);
  double integral = 0;
  for (std::size_t i = 0; i < kNodes.size(); ++i) {
    for (const double sign : {-1.0, 1.0}) {
      const double t = 0.5 * end * (1 + sign * kNodes[i]);
      const double c = std::cos(t);
      integral += kWeights[i] * std::exp(-(u * u + v * v - 2 * u * v * std::sin(t)) / (2 * c * c));
    }
  }
  const double root = std::numbers::sqrt2;
  SaddleValue s;
  s.value = std::erf(u / root) * std::erf(v / root) + end / kPi * integral;
  const double density = 2 / std::sqrt(2 * kPi);
  s.d_u = density * std::exp(-0.5 * u * u) * std::erf((v - rho * u) / (root * rest));
  s.d_v = density * std::exp(-0.5 * v * v) * std::erf((u - rho * v) / (root * rest));
  s.d_correlation =
      2 / (kPi * rest) * std::exp(-(u * u + v * v - 2 * rho * u * v) / (2 * rest * rest));
  return s;
}

std::optional<SaddleFit> fit_saddle(
    const Image<float>& signal, const SaddleStart& start, const SaddleFitConfig& config,
    const std::function<bool(const Eigen::Vector2d& offset_px)>& is_clear) {
  if (!start.pixel_px.allFinite() || !(start.pixel_px.cwiseAbs().maxCoeff() < 1e6))
    return std::nullopt;
  const Eigen::Vector2d first = start.along_first.normalized(),
                        second = start.along_second.normalized();
  if (!(std::abs(first.x() * second.y() - first.y() * second.x()) > config.min_edge_angle))
    return std::nullopt;
  // The window's pixels.
  const int cx = static_cast<int>(std::lround(start.pixel_px.x()));
  const int cy = static_cast<int>(std::lround(start.pixel_px.y()));
  const int h = config.half_window_px;
  std::vector<Pixel> pixels;
  for (int y = cy - h; y <= cy + h; ++y) {
    for (int x = cx - h; x <= cx + h; ++x) {
      const Eigen::Vector2d at(x, y);
      if (!signal.contains(x, y) || (is_clear && !is_clear(at - start.pixel_px))) continue;
      pixels.push_back({at, static_cast<double>(signal(x, y))});
    }
  }
  if (static_cast<int>(pixels.size()) < std::max(config.min_pixels, kCount + 1))
    return std::nullopt;

  Vector p;
  p << start.pixel_px, std::atan2(-first.x(), first.y()), std::atan2(-second.x(), second.y()),
      std::clamp(start.blur_px, kLeastBlur_px, kMostBlur_px), 0, 0, 0;
  set_levels(pixels, p);
  Sum sum;
  if (!descend(pixels, start, config, p, sum)) return std::nullopt;

  // What the window tells of the place, all else unknown.
  Matrix damped = sum.jtj;
  damped.diagonal().array() += 1e-12 * damped.trace();
  const Matrix inverse = damped.ldlt().solve(Matrix::Identity());
  SaddleFit fit;
  fit.pixels = static_cast<int>(pixels.size());
  fit.pixel_px = p.head<2>();
  fit.unit_covariance_px2 =
      0.5 * (inverse.topLeftCorner<2, 2>() + inverse.topLeftCorner<2, 2>().transpose());
  if (!fit.unit_covariance_px2.allFinite() || !(fit.unit_covariance_px2(0, 0) > 0) ||
      !(sum.weights > 0))
    return std::nullopt;
  const double share = static_cast<double>(fit.pixels) / (fit.pixels - kCount);
  fit.noise = std::sqrt(sum.weighted / sum.weights * share);
  fit.contrast = 2 * std::abs(p(kRise));
  fit.black = p(kLevel) - std::abs(p(kRise));
  fit.blur_px = p(kBlur);
  fit.along_first = along(p(kFirst), first);
  fit.along_second = along(p(kSecond), second);
  // Signs of both distances on the side between the two directions.
  const Eigen::Vector2d between = fit.along_first + fit.along_second;
  const double sign_u = std::cos(p(kFirst)) * between.x() + std::sin(p(kFirst)) * between.y();
  const double sign_v = std::cos(p(kSecond)) * between.x() + std::sin(p(kSecond)) * between.y();
  fit.dark_ahead = p(kRise) * sign_u * sign_v < 0;
  return fit;
}

}  // namespace cousin
