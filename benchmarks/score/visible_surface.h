#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "benchmarks/score/surface_distance.h"
#include "sim/types/camera.h"
#include "sim/types/pose.h"

namespace cousin {

/// A camera that looks at a surface.
struct SurfaceView {
  Camera camera;
  Pose camera_from_world;
};

/// Points of a true surface, and whether cameras could see each: what nobody saw, no method can
/// measure.
struct VisibleSamples {
  std::vector<Eigen::Vector3d> seen_m;
  std::vector<Eigen::Vector3d> unseen_m;
};

/// A sample is seen by a view if it lies in the image and no triangle of `scene` is between it and
/// the camera's centre, the last `skin_m` before it left out: its own surface does not hide it, and
/// a sheet's is seen from both sides.
/// @param least_views  that must see a sample
/// @throws std::invalid_argument if the mesh is empty, least_views < 1, or skin_m is not a length.
VisibleSamples visible_samples(const Mesh& scene, std::span<const Eigen::Vector3d> samples_m,
                               std::span<const SurfaceView> views, int least_views = 2,
                               double skin_m = 1e-5);

/// Scores a measured cloud against what could be seen: completeness is of the seen samples, and
/// measured points that are nearer to an unseen sample than to every seen one do not count.
/// @throws as score_cloud; nothing seen is an error too.
CloudScore score_visible_cloud(std::span<const Eigen::Vector3d> cloud_m, const Mesh& surface,
                               const VisibleSamples& samples, std::span<const double> tolerances_m);

/// The same of a measured mesh: `measured_samples_m` are points spread over it.
CloudScore score_visible_mesh(const Mesh& measured,
                              std::span<const Eigen::Vector3d> measured_samples_m,
                              const Mesh& surface, const VisibleSamples& samples,
                              std::span<const double> tolerances_m);

/// Chamfer distance: half the sum of the mean distances both ways.
double chamfer_m(const CloudScore& score);

}  // namespace cousin
