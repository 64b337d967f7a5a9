#pragma once

#include <Eigen/Core>
#include <functional>
#include <span>

#include "sim/types/image.h"

namespace cousin {

/// Responses of the CIE 1931 observer at a wavelength, by the fit of sums of two-sided Gaussians
/// [Wyman, Sloan & Shirley, JCGT 2013]. Below 1 % of the peak in error.
Eigen::Vector3d cie_xyz(double wavelength_m);

/// Linear sRGB of CIE XYZ; parts may be negative outside the gamut.
Eigen::Vector3d linear_srgb(const Eigen::Vector3d& xyz);

/// CIE XYZ of a spectrum given per metre of wavelength, 360..830 nm in steps of 1 nm.
Eigen::Vector3d xyz_of(const std::function<double(double wavelength_m)>& spectrum_per_m);

/// One emission line of a lamp, Gaussian in wavelength.
struct LedPeak {
  double wavelength_m = 450e-9;
  double fwhm_m = 20e-9;
  double power = 1;  ///< relative, in watts
};

/// Linear sRGB of luminance 1 of a lamp with these lines. A colour outside the gamut (violet grow
/// lamps are) is mixed with white of the same luminance until no part is negative.
/// @throws std::invalid_argument for no peaks, or one that is not finite, dark, or outside 360..830
/// nm.
Rgbf led_color(std::span<const LedPeak> peaks);

}  // namespace cousin
