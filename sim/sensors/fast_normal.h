#pragma once

#include <array>
#include <cstdint>

namespace cousin {

/// Standard normal from 32 random bits by the inverse distribution function: 4096 bins of equal
/// probability, linear inside a bin, exact in the two outermost bins. The table is scaled to unit
/// variance. About 2 ns a draw, against 20 ns of Box-Muller: a frame takes three million draws.
class NormalTable {
 public:
  NormalTable();

  float operator()(std::uint32_t bits) const {
    const std::uint32_t bin = bits >> kFractionBits;
    if (bin == 0 || bin == kBins - 1) return tail(bits);
    const float fraction = static_cast<float>(bits & kFractionMask) * kFractionUnit;
    return edges_[bin] + fraction * (edges_[bin + 1] - edges_[bin]);
  }

 private:
  static constexpr std::uint32_t kBins = 4096;
  static constexpr int kFractionBits = 20;
  static constexpr std::uint32_t kFractionMask = (1U << kFractionBits) - 1;
  static constexpr float kFractionUnit = 1.0F / (1U << kFractionBits);

  float tail(std::uint32_t bits) const;

  std::array<float, kBins + 1> edges_{};
};

/// The one table of the program; built on first use, in a millisecond.
const NormalTable& normal_table();

/// Quantile of the standard normal: x with P(X < x) = probability, in (0, 1). Newton's method on
/// std::erfc, to the precision of double.
double normal_quantile(double probability);

}  // namespace cousin
