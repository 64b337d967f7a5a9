// FLIP for images of limited range [Andersson, Nilsson, Akenine-Moller, Oskarsson, Astrom &
// Fairchild, "FLIP: A Difference Evaluator for Alternating Images", Proc. ACM CGIT 3(2), 2020].

#include <tbb/parallel_for.h>

#include <Eigen/Core>
#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "benchmarks/score/image_fidelity.h"
#include "benchmarks/score/separable_filter.h"

namespace cousin {
namespace {

constexpr double kColorPower = 0.7;      ///< q_c, section 4.1.3
constexpr double kLargeFrom = 0.4;       ///< p_c: share of the largest difference
constexpr double kLargeTo = 0.95;        ///< p_t: what that share maps to
constexpr double kFeaturePower = 0.5;    ///< q_f, section 4.2
constexpr double kFeatureWidth = 0.082;  ///< w, degrees

/// Calls use(index) for each pixel, on all threads.
template <class Plane, class Use>
void each_pixel(const Plane& plane, const Use& use) {
  const auto width = static_cast<std::size_t>(plane.width());
  tbb::parallel_for(0, plane.height(), [&](int y) {
    for (std::size_t i = static_cast<std::size_t>(y) * width, end = i + width; i < end; ++i) use(i);
  });
}

/// std::hypot without its care for overflow, which took a twelfth of a map's time.
double length(double x, double y) { return std::sqrt(x * x + y * y); }

/// Three planes of doubles.
struct Planes3 {
  std::array<Image<double>, 3> plane;
  Planes3(int width, int height) {
    for (Image<double>& p : plane) p = Image<double>(width, height);
  }
  Eigen::Vector3d at(std::size_t i) const {
    return {plane[0].data()[i], plane[1].data()[i], plane[2].data()[i]};
  }
  void set(std::size_t i, const Eigen::Vector3d& value) {
    for (std::size_t c = 0; c < 3; ++c) plane[c].data()[i] = value[static_cast<int>(c)];
  }
};

/// Linear sRGB to XYZ [IEC 61966-2-1]: exact ratios of the primaries' chromaticities.
Eigen::Matrix3d xyz_from_rgb() {
  Eigen::Matrix3d m;
  m << 10135552.0 / 24577794.0, 8788810.0 / 24577794.0, 4435075.0 / 24577794.0,
      2613072.0 / 12288897.0, 8788810.0 / 12288897.0, 887015.0 / 12288897.0, 1425312.0 / 73733382.0,
      8788810.0 / 73733382.0, 70074185.0 / 73733382.0;
  return m;
}
const Eigen::Matrix3d kXyzFromRgb = xyz_from_rgb();
const Eigen::Matrix3d kRgbFromXyz = xyz_from_rgb().inverse();
const Eigen::Vector3d kWhite = xyz_from_rgb() * Eigen::Vector3d::Ones();

double linear_from_code(float code) {
  const double c = static_cast<double>(code);
  const double s = c < 0 ? 0 : c > 1 ? 1 : c;  // keeps NaN
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

/// The opponent space of the filters: CIELAB's axes without its cube roots.
Eigen::Vector3d opponent_from_linear(const Eigen::Vector3d& rgb) {
  const Eigen::Vector3d t = (kXyzFromRgb * rgb).cwiseQuotient(kWhite);
  return {116 * t.y() - 16, 500 * (t.x() - t.y()), 200 * (t.y() - t.z())};
}
Eigen::Vector3d linear_from_opponent(const Eigen::Vector3d& opponent) {
  const double y = (opponent.x() + 16) / 116;
  const Eigen::Vector3d t(y + opponent.y() / 500, y, y - opponent.z() / 200);
  return kRgbFromXyz * t.cwiseProduct(kWhite);
}

/// CIELAB with the chroma of dark colours made less (Hunt).
Eigen::Vector3d hunt_lab(const Eigen::Vector3d& rgb) {
  const Eigen::Vector3d t = (kXyzFromRgb * rgb).cwiseQuotient(kWhite);
  constexpr double kDelta = 6.0 / 29.0;
  const Eigen::Vector3d f = t.unaryExpr([](double v) {
    return v > kDelta * kDelta * kDelta ? std::cbrt(v) : v / (3 * kDelta * kDelta) + 4.0 / 29.0;
  });
  const double lightness = 116 * f.y() - 16;
  return {lightness, 0.01 * lightness * 500 * (f.x() - f.y()),
          0.01 * lightness * 200 * (f.y() - f.z())};
}

/// City-block distance in lightness, Euclidean in chroma.
double hyab(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::abs(a.x() - b.x()) + length(a.y() - b.y(), a.z() - b.z());
}

/// Differences to 0..1, small ones stretched.
double redistributed(double power) {
  static const double largest =
      std::pow(hyab(hunt_lab({0, 1, 0}), hunt_lab({0, 0, 1})), kColorPower);
  const double from = kLargeFrom * largest;
  if (power < from) return kLargeTo / from * power;
  return kLargeTo + (power - from) / (largest - from) * (1 - kLargeTo);
}

Planes3 opponent_of(const FidelityPlanes& image) {
  Planes3 result(image[0].width(), image[0].height());
  each_pixel(image[0], [&](std::size_t i) {
    result.set(i, opponent_from_linear({linear_from_code(image[0].data()[i]),
                                        linear_from_code(image[1].data()[i]),
                                        linear_from_code(image[2].data()[i])}));
  });
  return result;
}

/// A contrast sensitivity function in space: a sum of Gaussians, section 4.1.1 and table 1.
struct Sensitivity {
  double a1, b1, a2, b2;
};
constexpr std::array<Sensitivity, 3> kSensitivities = {
    {{1, 0.0047, 0, 1e-5}, {1, 0.0053, 0, 1e-5}, {34.1, 0.04, 13.5, 0.025}}};

Image<double> seen(const Image<double>& plane, const Sensitivity& s, double pixels_per_degree) {
  constexpr double kPi = std::numbers::pi;
  const int radius =
      static_cast<int>(std::ceil(3 * std::sqrt(0.04 / (2 * kPi * kPi)) * pixels_per_degree));
  // exp(-pi^2 x^2 / b) is a Gaussian of sigma sqrt(b / 2) / pi; its share is what it sums to.
  const auto sigma = [&](double b) { return std::sqrt(b / 2) / kPi * pixels_per_degree; };
  const auto sum = [&](double a, double b) {
    double line = 0;
    for (int k = -radius; k <= radius; ++k) line += std::exp(-k * k / (2 * sigma(b) * sigma(b)));
    return a * std::sqrt(kPi / b) * line * line;
  };
  const FilterTaps first = gaussian_taps(sigma(s.b1), radius);
  Image<double> result = filtered(plane, first, first, FilterBorder::replicate);
  if (s.a2 == 0) return result;
  const FilterTaps second = gaussian_taps(sigma(s.b2), radius);
  const Image<double> other = filtered(plane, second, second, FilterBorder::replicate);
  const double share = sum(s.a1, s.b1) / (sum(s.a1, s.b1) + sum(s.a2, s.b2));
  each_pixel(result, [&](std::size_t i) {
    result.data()[i] = share * result.data()[i] + (1 - share) * other.data()[i];
  });
  return result;
}

/// What is seen of an image, in Hunt-adjusted CIELAB.
Planes3 perceived(const Planes3& opponent, double pixels_per_degree) {
  Planes3 result(opponent.plane[0].width(), opponent.plane[0].height());
  for (std::size_t c = 0; c < 3; ++c)
    result.plane[c] = seen(opponent.plane[c], kSensitivities[c], pixels_per_degree);
  each_pixel(result.plane[0], [&](std::size_t i) {
    Eigen::Vector3d rgb = linear_from_opponent(result.at(i));
    rgb = rgb.unaryExpr([](double v) { return v < 0 ? 0.0 : v > 1 ? 1.0 : v; });
    result.set(i, hunt_lab(rgb));
  });
  return result;
}

/// Strength of edges (first derivative) or points (second) of the lightness, section 4.2.
Image<double> feature_strength(const Image<double>& opponent_y, const FilterTaps& derivative,
                               const FilterTaps& smooth) {
  Image<double> lightness(opponent_y.width(), opponent_y.height());
  each_pixel(lightness,
             [&](std::size_t i) { lightness.data()[i] = (opponent_y.data()[i] + 16) / 116; });
  Image<double> x = filtered(lightness, derivative, smooth, FilterBorder::replicate);
  const Image<double> y = filtered(lightness, smooth, derivative, FilterBorder::replicate);
  each_pixel(x, [&](std::size_t i) { x.data()[i] = length(x.data()[i], y.data()[i]); });
  return x;
}

/// Positive taps sum to one, negative ones to minus one.
FilterTaps balanced(FilterTaps taps) {
  double above = 0, below = 0;
  for (const double tap : taps) (tap > 0 ? above : below) += std::abs(tap);
  for (double& tap : taps) tap /= tap > 0 ? above : below;
  return taps;
}

struct FeatureTaps {
  FilterTaps smooth, edge, point;
};
FeatureTaps feature_taps(double pixels_per_degree) {
  const double sigma = 0.5 * kFeatureWidth * pixels_per_degree;
  const int radius = static_cast<int>(std::ceil(3 * sigma));
  FeatureTaps taps{gaussian_taps(sigma, radius), {}, {}};
  for (int k = -radius; k <= radius; ++k) {
    const double g = taps.smooth[static_cast<std::size_t>(k + radius)];
    taps.edge.push_back(-k * g);
    taps.point.push_back((k * k / (sigma * sigma) - 1) * g);
  }
  taps.edge = balanced(taps.edge);
  taps.point = balanced(taps.point);
  return taps;
}

}  // namespace

Image<float> flip_map(const FidelityPlanes& image, const FidelityPlanes& photograph,
                      double pixels_per_degree) {
  if (!(pixels_per_degree >= 1 && pixels_per_degree <= 1000)) {
    throw std::invalid_argument("flip: pixels_per_degree = " + std::to_string(pixels_per_degree) +
                                " is not in 1..1000");
  }
  for (std::size_t c = 0; c < 3; ++c) {
    for (const FidelityPlanes* planes : {&image, &photograph}) {
      if ((*planes)[c].width() != image[0].width() || (*planes)[c].height() != image[0].height())
        throw std::invalid_argument("flip: the channels of both images have different sizes");
    }
  }
  Image<float> result(image[0].width(), image[0].height());
  if (result.empty()) return result;
  const Planes3 a = opponent_of(image), b = opponent_of(photograph);
  const Planes3 seen_a = perceived(a, pixels_per_degree), seen_b = perceived(b, pixels_per_degree);
  const FeatureTaps taps = feature_taps(pixels_per_degree);
  const Image<double> edge_a = feature_strength(a.plane[0], taps.edge, taps.smooth);
  const Image<double> edge_b = feature_strength(b.plane[0], taps.edge, taps.smooth);
  const Image<double> point_a = feature_strength(a.plane[0], taps.point, taps.smooth);
  const Image<double> point_b = feature_strength(b.plane[0], taps.point, taps.smooth);
  each_pixel(result, [&](std::size_t i) {
    const double color = redistributed(std::pow(hyab(seen_a.at(i), seen_b.at(i)), kColorPower));
    const double feature = std::pow(std::max(std::abs(edge_a.data()[i] - edge_b.data()[i]),
                                             std::abs(point_a.data()[i] - point_b.data()[i])) /
                                        std::numbers::sqrt2,
                                    kFeaturePower);
    result.data()[i] = static_cast<float>(std::pow(color, 1 - feature));
  });
  return result;
}

}  // namespace cousin
