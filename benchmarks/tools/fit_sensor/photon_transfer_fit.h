#pragma once

#include <functional>
#include <string>
#include <vector>

#include "benchmarks/score/trait_statistics.h"
#include "benchmarks/tools/fit_sensor/wall_statistics.h"

namespace cousin {

/// Raw frames of one even field, or of darkness.
struct FlatFrames {
  std::string name;
  int count = 0;
  std::function<Image<std::uint16_t>(int)> frame;
};

/// One brightness: half the variance of the difference of pairs of frames, which leaves out all
/// that is fixed [EMVA 1288].
struct FlatLevel {
  std::string name;
  double mean = 0;       ///< codes, black level in it
  Measured variance;     ///< codes^2; the error from rows, as row noise is alike along a row
  double saturated = 0;  ///< share of pixels at the largest code
  double at_zero = 0;
  std::string left_out;  ///< why it is not in the fit; empty if it is
};

/// Gain and read noise: variance = K (mean - black) + K^2 read^2 + 1/12. Intervals of 95 % from the
/// rows' covariance and the line's.
struct GainFit {
  FlatLevel dark;
  std::vector<FlatLevel> flats;
  double black_code = 0;           ///< mean of the dark frames
  WithInterval gain;               ///< K, codes an electron
  bool read_noise_solved = false;  ///< the dark noise is well above the rounding's
  WithInterval read_noise_e;       ///< row noise in it
  double chi2 = 0, p = 1;
  int degrees = 0;
  double misfit = 0;  ///< RMS of the variances about the line, relative
  std::vector<std::string> problems;
};

inline constexpr int kLeastFlats = 3;

/// @param max_code  largest code that the sensor gives
/// @throws std::runtime_error naming folder and frame for fewer than 2 frames or unequal sizes.
GainFit fit_gain(const FlatFrames& dark, const std::vector<FlatFrames>& flats, int max_code);

}  // namespace cousin
