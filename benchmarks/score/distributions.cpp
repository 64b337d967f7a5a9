#include "benchmarks/score/distributions.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace cousin {
namespace {

/// The continued fraction of I_x(a, b), fast for x < (a + 1) / (a + b + 2).
double beta_fraction(double a, double b, double x) {
  constexpr double kTiny = 1e-300;
  double c = 1;
  double d = 1 / std::max(std::abs(1 - (a + b) * x / (a + 1)), kTiny);
  double value = d;
  for (int m = 1; m <= 10000; ++m) {
    const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
    double change = 1;
    for (const double term : {even, odd}) {
      d = 1 + term * d;
      c = 1 + term / c;
      if (std::abs(d) < kTiny) d = kTiny;
      if (std::abs(c) < kTiny) c = kTiny;
      d = 1 / d;
      change = c * d;
      value *= change;
    }
    if (std::abs(change - 1) < 1e-15) break;
  }
  return value;
}

}  // namespace

double incomplete_beta(double a, double b, double x) {
  if (!(a > 0 && b > 0 && x >= 0 && x <= 1)) {
    throw std::invalid_argument("incomplete_beta: needs a, b > 0 and x in [0, 1]");
  }
  if (x == 0 || x == 1) return x;
  const double front = std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) +
                                a * std::log(x) + b * std::log1p(-x));
  if (x < (a + 1) / (a + b + 2)) return front * beta_fraction(a, b, x) / a;
  return 1 - front * beta_fraction(b, a, 1 - x) / b;
}

double student_t_two_sided(double t, double degrees) {
  return incomplete_beta(0.5 * degrees, 0.5, degrees / (degrees + t * t));
}

double student_t_quantile(double two_sided, double degrees) {
  double low = 0;
  double high = 1;
  while (student_t_two_sided(high, degrees) > two_sided && high < 1e12) high *= 2;
  for (int step = 0; step < 200 && high - low > 1e-14 * high; ++step) {
    const double middle = 0.5 * (low + high);
    (student_t_two_sided(middle, degrees) > two_sided ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double normal_cdf(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }

double chi_square_above(double x, int degrees) {
  if (!(x > 0)) return 1;
  const double half = 0.5 * x;
  const bool is_odd = degrees % 2 != 0;
  double sum = is_odd ? std::erfc(std::sqrt(half)) : std::exp(-half);
  // Q(k + 2) = Q(k) + half^(k/2) exp(-half) / Gamma(k/2 + 1)
  for (int k = is_odd ? 1 : 2; k + 2 <= degrees; k += 2)
    sum += std::exp(0.5 * k * std::log(half) - half - std::lgamma(0.5 * k + 1));
  return std::min(sum, 1.0);
}

BinomialInterval binomial_interval(long long successes, long long trials) {
  if (trials == 0) return {std::numeric_limits<double>::quiet_NaN(), 0, 1};
  const auto n = static_cast<double>(trials);
  const double p = static_cast<double>(successes) / n;
  const double z2 = kSigmas95 * kSigmas95;
  const double centre = (p + z2 / (2 * n)) / (1 + z2 / n);
  const double half = kSigmas95 / (1 + z2 / n) * std::sqrt(p * (1 - p) / n + z2 / (4 * n * n));
  return {p, std::max(0.0, centre - half), std::min(1.0, centre + half)};
}

}  // namespace cousin
