#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "perception/silhouette/apparent_contour.h"
#include "perception/silhouette/spherical_harmonics.h"
#include "perception/silhouette/surface_fit.h"
#include "perception/silhouette/surface_frame.h"

namespace cousin {

/// One object's outline in one view: the points that lie on the object, in order.
struct OutlineView {
  FramePose pose;
  std::vector<OutlinePoint> points;
  std::vector<int> positions;  ///< of the points along the closed outline, to tell neighbours
};

/// Mean of the cloud's points in a patch of the surface.
struct CloudPatch {
  Eigen::Vector3d point_m;
  double sigma_m = 0;
};

/// The harmonics of one degree at the vertices of the mesh that the fit works on. Shared by all
/// objects.
struct SurfaceBasis {
  RealHarmonics harmonics;
  Mesh sphere;             ///< icosphere
  Eigen::MatrixXd values;  ///< vertex x harmonic
  SurfaceBasis(int degree, int subdivisions);
};

/// The unknowns. Those below `radius` absorb errors of the measurements.
struct SurfaceState {
  SurfaceFrame frame;
  Eigen::VectorXd radius;      ///< b_lm
  double outline_bias_px = 0;  ///< outlines are this much too wide
  double cloud_bias_m = 0;     ///< cloud points are this far out
  std::vector<Eigen::Vector2d> view_shifts_px;
  double roughness = 1;  ///< tau of the prior
};

/// What the residuals say about the measurements.
struct ResidualScale {
  double outline = 1;      ///< scatter over the predicted sigma
  double correlation = 1;  ///< points that count as one
  double cloud = 1;
  double matched = 0;  ///< share of outline points that met the model's contour
  double inliers = 0;  ///< share of those within 4.5 scatters
};

/// The surface of a state at the basis's vertices.
SampledSurface sample_surface(const SurfaceBasis& basis, const SurfaceState& state);

/// One Gauss-Newton step: changes `state` and `scale`; returns the relative change of the radius
/// (root mean square). Sums over views run in fixed chunks, so threads change nothing.
struct SurfaceProblem {
  const SurfaceBasis& basis;
  const SurfaceFitConfig& config;
  std::vector<OutlineView> views;
  std::vector<CloudPatch> patches;

  /// @param relaxation  share of the step that is taken
  double step(SurfaceState& state, ResidualScale& scale, double match_limit_px,
              double relaxation = 1) const;
  /// Inverse covariance of (b, outline bias, cloud bias) at a state, other unknowns eliminated.
  Eigen::MatrixXd information(const SurfaceState& state, const ResidualScale& scale,
                              double match_limit_px) const;
};

}  // namespace cousin
