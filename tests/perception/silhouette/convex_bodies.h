#pragma once

#include <functional>
#include <vector>

#include "sim/types/mesh.h"
#include "sim/types/rng.h"
#include "sim/types/seams.h"

namespace cousin {

/// A finely meshed convex body that stands on z = 0: `point` takes unit vectors to points of its
/// surface.
Mesh make_body(const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& point);
Mesh make_ellipsoid(const Eigen::Vector3d& semi_axes_m);
/// |x/a|^p + |y/b|^p + |z/c|^p = 1, tapered towards +x, turned by `tilt_rad` about y: like a kernel
/// of maize.
Mesh make_wedge(const Eigen::Vector3d& semi_axes_m, double power, double taper, double tilt_rad);

/// Views from three rings at 15, 35 and 60 degrees, 0.30-0.55 m, 1280 x 720, aimed near the origin.
Poses make_poses(int views);

/// Exact silhouette of a convex body: the convex hull of its projected vertices, a point a pixel,
/// plus noise along the normals.
Silhouettes make_outlines(const Mesh& body, const Poses& poses, double sigma_px, Rng rng);

/// Points of the body's side that is seen from above, with noise; one object.
Clusters make_cloud(const Mesh& body, double sigma_m, Rng rng);

double volume_m3(const Mesh& mesh);
double area_m2(const Mesh& mesh);
/// Extent of the vertices along a direction.
double width_m(const Mesh& mesh, const Eigen::Vector3d& direction);

}  // namespace cousin
