#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "scenes/seeds/cultivar.h"

namespace cousin {

/// Where a surface point lies on the seed, for colouring and keypoints. Seed axes: x from the tip
/// (maize: tip cap, wheat: embryo end, rice: pedicel) to the crown (maize: dent, wheat: brush,
/// rice: apiculus); y across the width; z across the height (maize: towards the embryo's face,
/// wheat: dorsal, rice: one of the two like sides).
struct SeedSkinPoint {
  double along = 0;   ///< 0 at the tip, 1 at the crown
  double across = 0;  ///< y over the half-width, about [-1, 1]
  double up = 0;      ///< z over the half-height, about [-1, 1]
  double groove = 0;  ///< 0..1: how deep in the groove (hollow, crease, seam)
  double relief = 0;  ///< 0..1: how much on the relief (dent, rim, nerve)
};

struct SeedShape {
  Mesh mesh;                           ///< closed, outward; not yet centred
  std::vector<SeedSkinPoint> surface;  ///< one for each vertex
};

/// Angle about the axis of rice from the lemma's keel at which lemma clasps palea.
double rice_seam_rad(double along);

/// A seed of about `size_m` (length, width, height along x, y, z): a body of superellipse sections
/// along the cultivar's profiles, star-shaped about its middle, then the species' details as smooth
/// displacements.
/// @param rng  individual lopsidedness, bow and strength of the details
/// @param harmonics  share of a body of random spherical harmonics in its place: at 1 nothing of
/// the species' shape is left
SeedShape make_seed_shape(const CultivarConfig& config, const Eigen::Vector3d& size_m, Rng rng,
                          double harmonics = 0);

}  // namespace cousin
