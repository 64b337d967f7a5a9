#pragma once

#include <cstdint>
#include <limits>
#include <string_view>

namespace cousin {

/// A stream fixed by its seed; a small value. Meets UniformRandomBitGenerator.
/// Generator: splitmix64 over a 64-bit key [Steele, Lea & Flood, OOPSLA 2014].
class Rng {
 public:
  using result_type = std::uint64_t;
  explicit Rng(std::uint64_t seed);
  Rng fork(std::string_view purpose) const;  ///< own stream; the parent does not advance
  Rng fork(std::uint64_t index) const;
  result_type operator()();
  static constexpr result_type min() { return 0; }
  static constexpr result_type max() { return std::numeric_limits<result_type>::max(); }

 private:
  std::uint64_t key_;    ///< names the stream; forks derive from it
  std::uint64_t state_;  ///< advances
};

double uniform(Rng& rng);                                    ///< in [0, 1), 53 bits
double uniform(Rng& rng, double low, double high);           ///< in [low, high)
std::uint64_t uniform_index(Rng& rng, std::uint64_t count);  ///< in [0, count); count > 0
double normal(Rng& rng);  ///< zero mean, unit variance; same on every standard library
/// Normal of the given mean and sigma, redrawn until within `limit_sigma` sigmas of the mean.
double truncated_normal(Rng& rng, double mean, double sigma, double limit_sigma = 2.5);
/// Poisson count of the given mean >= 0: inversion below 30, else a rounded normal with
/// the Cornish-Fisher skewness term (relative error of the variance below 0.2 %).
double poisson(Rng& rng, double mean);

}  // namespace cousin
