#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sim/types/rng.h"

namespace cousin {

/// From light to numbers for one row of photosites [EMVA 1288 linear model]. A signal s gives the
/// code black + K (e + offset), e a Poisson count of mean s electrons plus dark_e, with read noise.
struct Exposure {
  float electrons = 1;      ///< at unit signal
  float dark_e = 0;         ///< mean of the dark current's electrons; they have shot noise too
  float offset_e = 0;       ///< of every photosite of the row
  float read_variance = 0;  ///< e^2
  float codes_per_e = 1;    ///< K
  float black_code = 0;
  float max_code = 65535;  ///< full well
};

/// Codes of a row of signals (radiance after the lens): shot noise, PRNU, DSNU, read noise,
/// clipping at zero and full well, rounding. Draws from `rng` in order of the samples. Shot noise
/// is an exact Poisson count below 30 electrons, above it a normal with the Poisson's skewness,
/// drawn together with the read noise.
/// @param prnu  relative response of each photosite
/// @param dsnu  offset of each photosite in electrons
void expose_row(std::span<const float> signal, const float* prnu, const float* dsnu,
                const Exposure& exposure, Rng rng, std::uint16_t* codes);

/// Fixed pattern of a row: mean plus sigma times a normal for each photosite, in order.
void fixed_pattern_row(std::span<float> row, double mean, double sigma, Rng rng);

/// Electrons at unit signal by automatic exposure: the 99.5 % quantile of the signals comes to 80 %
/// of full well. Black is exposed as if unit signal were the brightest.
/// @throws std::invalid_argument if there is no signal.
double auto_exposure_electrons(std::vector<float> signals, double full_well_e);
/// Share of full well that automatic exposure aims at.
inline constexpr double kAutoFullWellShare = 0.8;

}  // namespace cousin
