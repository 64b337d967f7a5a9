#pragma once

namespace cousin {

/// Regularised incomplete beta function I_x(a, b) for a, b > 0 and x in [0, 1], by its continued
/// fraction [DLMF 8.17.22, modified Lentz]; relative error about 1e-13.
double incomplete_beta(double a, double b, double x);

/// P(|T| > |t|) of Student's t with `degrees` > 0 of freedom.
double student_t_two_sided(double t, double degrees);
/// t with P(|T| > t) = `two_sided`, in (0, 1), by bisection to rounding.
double student_t_quantile(double two_sided, double degrees);

/// P(X < x) of the standard normal.
double normal_cdf(double x);

/// P(X > x) of the chi-square distribution with `degrees` > 0 whole degrees of freedom, by its
/// finite sum [Abramowitz & Stegun 26.4.4, 26.4.5].
double chi_square_above(double x, int degrees);

/// 1.96: half width of a 95 % interval in sigmas.
inline constexpr double kSigmas95 = 1.959963984540054;

struct BinomialInterval {
  double share = 0;  ///< successes / trials; NaN without trials
  double low = 0;
  double high = 1;
};
/// 95 % score interval of a share [Wilson, JASA 1927].
BinomialInterval binomial_interval(long long successes, long long trials);

}  // namespace cousin
