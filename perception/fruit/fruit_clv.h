#pragma once

#include <cstdint>

#include "perception/fruit/fruit_fit.h"
#include "sim/types/rng.h"

namespace cousin {

/// The Apples paper's Collaborative Local Volume [2.3]. What its text leaves open is said here.
struct ClvConfig {
  int points = 2000;            ///< of the deformed sphere; not published
  int waves = 5;                ///< directions of deformation; not published
  double wave_strength = 0.02;  ///< of the slowest, over the radius; not published
  double noise = 0.005;         ///< sigma of the random radius, over it; not published
  double stalk_dent = 0.2, calyx_dent = 0.12, dent_rad = 0.35;  ///< not published
  /// The corrected volume is hull * (1 - correction * (1 - sphericity)), sphericity = least over
  /// largest eigenvalue of the cloud. Fitted to no
  /// bias of unoccluded apples of seeds 101 to 103, which no suite scores; it is not published.
  double correction = 1.8;
  double density_kg_m3 = 858;
};
Fields fields(ClvConfig& config);
void validate(const ClvConfig& config);

/// Depth in the middle of the box (the median of 5 x 5 pixels) and the box's sides give the base
/// radius by the pinhole [eq. 10 to 16]; a deformed sphere of this radius is sampled [17 to 28];
/// its convex hull [29, 30], corrected by the sphericity of its covariance [31 to 34], times
/// density is the mass. It looks at the box alone, and says nothing of its error.
/// A box that spans more than its distance is no fruit's: too_few_points, with the reason.
/// @param rng  of the deformation
FruitFit fit_clv(const FrameDepth& depth, const Camera& camera, const DetectedBox& box,
                 const ClvConfig& config, Rng rng);

}  // namespace cousin
