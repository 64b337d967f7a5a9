// calibration/boards/saddle_fit.h and disc_fit.h: values, derivatives, and what noise does to a
// place.
#include "calibration/boards/saddle_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "calibration/boards/disc_fit.h"
#include "sim/types/rng.h"

namespace cousin {
namespace {

/// By brute force: the mean of sgn(u + m) sgn(v + n) over a fine lattice of the two normals.
double by_lattice(double u, double v, double rho) {
  constexpr int kSide = 2000;
  constexpr double kReach = 7;
  double sum = 0, weights = 0;
  for (int i = 0; i < kSide; ++i) {
    const double m = kReach * (2 * (i + 0.5) / kSide - 1);
    const double weight = std::exp(-0.5 * m * m);
    // Given m, n is normal about rho m.
    const double mean = (v + rho * m) / std::sqrt(2 * (1 - rho * rho));
    sum += weight * (u + m > 0 ? 1 : -1) * std::erf(mean);
    weights += weight;
  }
  return sum / weights;
}

TEST(BlurredSaddle, IsTheMeanOfTheSignsUnderAGaussian) {
  for (const double rho : {0.0, 0.3, -0.6, 0.85}) {
    for (const double u : {-1.3, 0.0, 0.4, 2.2}) {
      for (const double v : {-0.7, 0.0, 1.1}) {
        // A lattice of 2000 misses the sign's step by half a cell of 0.007 times the density 0.4.
        EXPECT_NEAR(blurred_saddle(u, v, rho).value, by_lattice(u, v, rho), 0.003)
            << u << " " << v << " " << rho;
      }
    }
  }
}

TEST(BlurredSaddle, DerivativesAreThoseOfTheValue) {
  constexpr double kStep = 1e-5;
  for (const double rho : {0.0, 0.5, -0.8}) {
    for (const double u : {-0.9, 0.2}) {
      for (const double v : {-0.3, 1.4}) {
        const SaddleValue s = blurred_saddle(u, v, rho);
        const auto slope = [&](double du, double dv, double dr) {
          return (blurred_saddle(u + du, v + dv, rho + dr).value -
                  blurred_saddle(u - du, v - dv, rho - dr).value) /
                 (2 * kStep);
        };
        // Central differences of a function with third derivatives near 1, and quadrature of 1e-8.
        EXPECT_NEAR(s.d_u, slope(kStep, 0, 0), 1e-7);
        EXPECT_NEAR(s.d_v, slope(0, kStep, 0), 1e-7);
        EXPECT_NEAR(s.d_correlation, slope(0, 0, kStep), 1e-7);
      }
    }
  }
}

/// A corner of two lines at any angle, by the closed form; the pixel's square counts as blur.
Image<float> corner_image(const Eigen::Vector2d& at, double first_rad, double second_rad,
                          double blur) {
  Image<float> image(40, 40);
  const Eigen::Vector2d n1(-std::sin(first_rad), std::cos(first_rad)),
      n2(-std::sin(second_rad), std::cos(second_rad));
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 40; ++x) {
      const Eigen::Vector2d d = (Eigen::Vector2d(x, y) - at) / blur;
      image(x, y) =
          static_cast<float>(0.5 + 0.4 * blurred_saddle(n1.dot(d), n2.dot(d), n1.dot(n2)).value);
    }
  }
  return image;
}

TEST(FitSaddle, GivesBackANoiselessCornerAtAnyAngle) {
  for (const double second : {0.6, 1.2, 1.7, 2.4}) {
    const Eigen::Vector2d at(19.3, 20.8);
    const auto fit = fit_saddle(corner_image(at, 0.15, second, 1.1),
                                {.pixel_px = {20, 20},
                                 .along_first = {1, 0},
                                 .along_second = {std::cos(second), std::sin(second)}});
    ASSERT_TRUE(fit);
    // Pixels are floats: 121 of them with errors of 3e-8 over a contrast of 0.8.
    EXPECT_LT((fit->pixel_px - at).norm(), 1e-5) << second;
    EXPECT_NEAR(fit->blur_px, 1.1, 1e-4);
    EXPECT_NEAR(fit->contrast, 0.8, 1e-4);
  }
}

TEST(FitSaddle, CovarianceIsTheSpreadOverDraws) {
  const Eigen::Vector2d at(20.2, 19.7);
  const Image<float> clean = corner_image(at, 0.2, 1.3, 1.04);
  constexpr int kDraws = 600;
  constexpr double kNoise = 0.01;
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero(), predicted = Eigen::Matrix2d::Zero();
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (int k = 0; k < kDraws; ++k) {
    Image<float> image = clean;
    Rng rng = Rng(7).fork(static_cast<std::uint64_t>(k));
    for (float& v : image) v += static_cast<float>(kNoise * normal(rng));
    const auto fit = fit_saddle(
        image, {.pixel_px = {20.5, 19.5}, .along_first = {1, 0.2}, .along_second = {0.3, 1}});
    ASSERT_TRUE(fit);
    const Eigen::Vector2d error = fit->pixel_px - at;
    mean += error / kDraws;
    spread += error * error.transpose() / kDraws;
    predicted += fit->noise * fit->noise * fit->unit_covariance_px2 / kDraws;
  }
  // A variance of 600 draws is known to sqrt(2 / 600) = 6 %; four times that.
  for (int k = 0; k < 2; ++k) EXPECT_NEAR(spread(k, k) / predicted(k, k), 1, 0.23);
  // The mean of 600, four deviations.
  EXPECT_LT(mean.norm(), 4 * std::sqrt(spread.trace() / kDraws));
}

TEST(FitSaddle, RefusesWhatIsNoCorner) {
  Image<float> even(40, 40, 0.5F), edge(40, 40, 0.2F);
  for (int y = 0; y < 40; ++y) {
    for (int x = 20; x < 40; ++x) edge(x, y) = 0.9F;
  }
  const SaddleStart start{
      .pixel_px = {20, 20}, .along_first = {1, 0}, .along_second = {0, 1}, .blur_px = 1};
  const auto flat = fit_saddle(even, start);
  EXPECT_FALSE(flat && flat->contrast > 1e-3);
  const auto step = fit_saddle(edge, start);
  // Any place along the edge does as well: none is predicted to better than pixels.
  EXPECT_FALSE(step && step->contrast > 0.3 && step->unit_covariance_px2.trace() < 1);
  EXPECT_FALSE(fit_saddle(
      even, {.pixel_px = {std::nan(""), 0}, .along_first = {1, 0}, .along_second = {0, 1}}));
  EXPECT_FALSE(
      fit_saddle(even, {.pixel_px = {500, 500}, .along_first = {1, 0}, .along_second = {0, 1}}));
}

TEST(DiscCentreShift, IsZeroWithoutPerspectiveAndClosedOnASlope) {
  Eigen::Matrix3d h;
  h << 900, 30, 12, -20, 850, 7, 0, 0, 1;
  EXPECT_LT(disc_centre_shift_px(h, {0.02, 0.01}, 0.01).norm(), 1e-9);
  // A plane turned about y at distance D: x / z = X cos / (D + X sin). The ends of the diameter on
  // x = 0 are at -+R cos / (D -+ R sin); their mean is the ellipse's middle.
  const double turn = 0.6, far = 0.5, radius = 0.01, f = 1000;
  Eigen::Matrix3d turned;
  turned << f * std::cos(turn), 0, 0, 0, f, 0, std::sin(turn), 0, far;
  const double a = f * radius * std::cos(turn) / (far + radius * std::sin(turn));
  const double b = -f * radius * std::cos(turn) / (far - radius * std::sin(turn));
  EXPECT_NEAR(disc_centre_shift_px(turned, {0, 0}, radius).x(), -0.5 * (a + b), 1e-9);
}

}  // namespace
}  // namespace cousin
