#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "benchmarks/score/trait_statistics.h"
#include "benchmarks/tools/fit_sensor/wall_statistics.h"

namespace cousin {

/// value(Z) = at_reference (Z / reference_m)^exponent: least squares of logarithms with the walls'
/// standard errors.
struct PowerLaw {
  double reference_m = 1;
  double log_value = 0, exponent = 0;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of both, widened by chi2 / degrees
  double chi2 = 0;
  int degrees = 0;  ///< walls less two
};
/// @throws std::invalid_argument if there are fewer than two points or one is not positive.
struct PowerPoint {
  double z_m = 1;
  Measured value;
};
PowerLaw fit_power_law(const std::vector<PowerPoint>& points, double reference_m);
double value_at(const PowerLaw& law, double z_m);

/// A distance left out of the fit and predicted from the others.
struct HeldOut {
  std::string wall;
  double depth_m = 0;
  double ratio = 1;  ///< predicted sigma_Z over the measured one
  double sigma = 0;  ///< standard error of its logarithm
};

/// What a depth camera's recordings say of it. Intervals are of 95 %, from covariances: tiles of
/// the image give those of a wall's numbers, walls those of the laws.
struct DepthFit {
  std::vector<WallStatistics> walls;  ///< all; those with a problem are in no law
  double reference_m = 1;             ///< geometric mean of the laws' distances
  PowerLaw spatial, temporal;         ///< of the disparity, px
  bool temporal_solved = false;       ///< at three distances above a twentieth of its quantum
  WithInterval sigma_d_px;            ///< of a frame, at reference_m
  WithInterval sigma_z_exponent;      ///< d log sigma_Z / d log Z at reference_m: 2 if sigma_d is
                                      ///< the same everywhere
  double chi2 = 0, p = 1;             ///< of sigma_d about the law
  int degrees = 0;
  std::vector<HeldOut> held_out;
  double held_out_rms = 0;      ///< RMS of log ratio
  bool ripple_solved = false;   ///< enough fractions of a disparity were seen
  WithInterval ripple_px;       ///< amplitude of a sine of the disparity
  double ripple_phase_rad = 0;  ///< of A sin(2 pi d + phase)
  bool bias_solved = false;     ///< the stated distances tell it to 0.1 px
  WithInterval bias_px;         ///< disparity = scale f B / Z + bias
  WithInterval scale;
  double distance_p = 1;              ///< of the stated distances about that
  std::vector<std::string> problems;  ///< why the model is rejected; empty if it is not
};

inline constexpr int kLeastWalls = 4, kLeastFrames = 4;
inline constexpr double kLeastExponent = 1.6, kLargestExponent = 2.8;
inline constexpr double kHeldOutLimit = 0.1;

/// sigma_Z of a frame at a distance, without the rounding to steps. Metres.
double sigma_z_m(const DepthFit& fit, const DepthGeometry& geometry, double z_m);

/// The laws of the walls that share the commonest light and albedo; others only keep their own
/// numbers. Rejects, as `problems`: fewer than kLeastWalls distances that span a factor of 1.5; an
/// exponent of sigma_Z whose interval lies outside kLeastExponent .. kLargestExponent; noise that
/// is off the law (chi-square p < 0.01 and held-out RMS above kHeldOutLimit); a wall that bends by
/// more than 0.3 of its noise; stated distances that the depths contradict; first of all depths 1.5
/// times as large or small as those, and the unit that would fit.
DepthFit fit_depth(std::vector<WallStatistics> walls, const DepthGeometry& geometry);

}  // namespace cousin
