#include "benchmarks/score/distributions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "benchmarks/score/order_statistics.h"

namespace cousin {
namespace {

TEST(IncompleteBeta, HasItsClosedForms) {
  for (const double x : {0.0, 1e-9, 0.2, 0.5, 0.9, 1.0}) {
    EXPECT_NEAR(incomplete_beta(1, 1, x), x, 1e-14);
    EXPECT_NEAR(incomplete_beta(3, 1, x), x * x * x, 1e-14);
    EXPECT_NEAR(incomplete_beta(1, 4, x), 1 - std::pow(1 - x, 4), 1e-14);
    EXPECT_NEAR(incomplete_beta(0.5, 0.5, x), 2 / std::numbers::pi * std::asin(std::sqrt(x)),
                1e-13);
  }
  EXPECT_THROW(incomplete_beta(0, 1, 0.5), std::invalid_argument);
  EXPECT_THROW(incomplete_beta(1, 1, 1.5), std::invalid_argument);
}

TEST(StudentT, AgreesWithClosedFormsAndTables) {
  // One degree of freedom is Cauchy's distribution, two have a root.
  EXPECT_NEAR(student_t_two_sided(3, 1), 1 - 2 / std::numbers::pi * std::atan(3), 1e-13);
  EXPECT_NEAR(student_t_two_sided(3, 2), 1 - 3 / std::sqrt(11.0), 1e-13);
  EXPECT_NEAR(student_t_quantile(0.05, 1), 12.7062047, 1e-6);
  EXPECT_NEAR(student_t_quantile(0.05, 4), 2.77644511, 1e-7);
  // Many degrees: z + (z^3 + z) / (4 nu).
  EXPECT_NEAR(student_t_quantile(0.05, 1e5), kSigmas95 + (std::pow(kSigmas95, 3) + kSigmas95) / 4e5,
              1e-8);
  // The seeds paper: t = -2.539 gives p = .0143 with 49 degrees of freedom (50 seeds).
  EXPECT_NEAR(student_t_two_sided(-2.539, 49), 0.0143, 5e-5);
}

TEST(BinomialInterval, IsWilsons) {
  // Newcombe 1998, table I: 81 of 263 gives 0.2553 to 0.3662; 0 of 20 gives 0 to 0.1611.
  const BinomialInterval a = binomial_interval(81, 263);
  EXPECT_NEAR(a.low, 0.2553, 5e-5);
  EXPECT_NEAR(a.high, 0.3662, 5e-5);
  const BinomialInterval b = binomial_interval(0, 20);
  EXPECT_EQ(b.low, 0);
  EXPECT_NEAR(b.high, 0.1611, 5e-5);
  EXPECT_TRUE(std::isnan(binomial_interval(0, 0).share));
}

TEST(ChiSquare, TailAgreesWithTables) {
  // Abramowitz & Stegun, table 26.8: 5 % and 1 % points.
  EXPECT_NEAR(chi_square_above(3.84146, 1), 0.05, 1e-6);
  EXPECT_NEAR(chi_square_above(5.99146, 2), 0.05, 1e-6);
  EXPECT_NEAR(chi_square_above(7.81473, 3), 0.05, 1e-6);
  EXPECT_NEAR(chi_square_above(23.2093, 10), 0.01, 1e-6);
  EXPECT_EQ(chi_square_above(0, 4), 1);
  EXPECT_LT(chi_square_above(1e4, 4), 1e-300);
}

TEST(Quantile, IsLinearBetweenOrderStatistics) {
  EXPECT_EQ(quantile({4, 1, 3, 2}, 0), 1);
  EXPECT_EQ(quantile({4, 1, 3, 2}, 0.5), 2.5);
  EXPECT_EQ(quantile({4, 1, 3, 2}, 1), 4);
  EXPECT_EQ(quantile({7}, 0.95), 7);
  EXPECT_TRUE(std::isnan(quantile({}, 0.5)));
  EXPECT_TRUE(std::isnan(mean({})));
  EXPECT_TRUE(std::isnan(rms({})));
}

}  // namespace
}  // namespace cousin
