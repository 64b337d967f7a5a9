#pragma once

#include "sim/config/fields.h"
#include "sim/types/rng.h"
#include "sim/types/seams.h"

namespace cousin {

struct SurfaceFitConfig {
  int degree =
      18;  ///< of the spherical harmonics of the radius, about an affine frame of the cluster
  double smoothness = 1.0;  ///< weight of the prior on bending, where nothing is seen
  int subdivisions = 5;     ///< of the icosahedron for the final mesh
  int max_iterations = 15;
  int samples = 64;       ///< drawn from the fit's covariance for the uncertainties
  bool use_cloud = true;  ///< the multi-view stereo points too, for what outlines do not show
  bool use_outlines = true;
  double plane_sigma_m = 1e-5;  ///< the object may not go below z = 0 and touches it
  double cloud_sigma_m = 7e-5;  ///< of the mean of the cloud's points in a patch of the surface
  double cloud_bias_sigma_m = 3.5e-5;   ///< all points too far out or in
  double cloud_rim_m = 0.0025;          ///< points nearer to the footprint's edge are left out
  double outline_bias_sigma_px = 0.03;  ///< all outlines too wide or too narrow
  double view_shift_sigma_px = 0.05;    ///< of a view's outline in the image, from its pose
  double contact_sigma_px = 10;         ///< of outlines at the board, beside their own
  double contact_height_px = 0.6;       ///< height over which that falls by e, in pixels there
  double min_solidity =
      0.88;  ///< volume over its convex hull's; below, it is several objects that touch
};
Fields fields(SurfaceFitConfig& config);
void validate(const SurfaceFitConfig& config);

/// A closed smooth surface per object, fitted by Gauss-Newton to its outlines (tangent rays), to
/// its cloud points and to the board it lies on; what no view sees is completed by least bending.
/// No shape prior of any species or sphere.
///
/// Outlines fix the flanks, but no camera above sees a flat top's outline. Stereo sees tops, but
/// what a coat mirrors pulls its depth down, most near rims (rendered maize: 0.05 mm in the middle,
/// 0.3 mm within a window's reach of the rim; without gloss 0.03 and 0.14 mm). So with outlines
/// only points well inside the footprint, in the upper half of the object, are used, and their
/// sigmas are weights, set on rendered maize (seeds 1 and 7), rather than what stereo errs by.
/// Outlines alone put flat tops 0.2 mm too high; a cloud that is trusted more lowers round ones.
///
/// Where an outline runs low over the board, what is next to it is the gap under the object: dark,
/// and lit from the object itself. Outlines there lie 0.2 to 0.4 px too far out, with a scatter of
/// 0.5 to 0.7 px in views from 15 and 35 degrees (rendered wheat, seed 1), so they are left out in
/// effect: what is added to their sigma is above half a pixel up to 1.8 pixels over the board, for
/// the gap's blur is the image's.
///
/// x(u) = centre + axes u r(u), r(u) = 1 + sum b_lm Y_lm(u): spherical harmonics about an
/// ellipsoid. The prior on b_lm has the variance tau^2 / (l (l + 1))^2 (that is least bending); tau
/// is estimated with the fit, for each object (evidence). An outline point's residual is its
/// distance along its normal from the model's apparent contour; each view may shift by a fraction
/// of a pixel. Samples are drawn from the posterior, with the scatter and the correlation of
/// neighbours that the residuals themselves show, and with errors common to all outlines or all
/// cloud points.
///
/// One surface for each instance of `clusters`, in order. Status: `empty` with fewer than 10
/// cluster points; `too_few_views` with fewer than 3 views (only where outlines are used);
/// `not_converged`; `touching` where the solid is too far from convex for one seed. The mesh is
/// filled for `ok` and `touching` only.
Surfaces fit_surfaces(const Poses& poses, const Clusters& clusters, const Silhouettes& silhouettes,
                      const SurfaceFitConfig& config, Rng rng);

}  // namespace cousin
