#pragma once

#include <Eigen/Core>
#include <vector>

#include "benchmarks/suites/stability/stability_row.h"
#include "sim/truth/scene.h"
#include "sim/truth/truth_images.h"

namespace cousin {

/// Lights, materials, shapes, views and files that must be refused by name.
void add_path_refusals(std::vector<StabilityRow>& rows);

/// Light far beyond saturation and none, needles and triangles without area, cameras inside bodies,
/// flesh of any mean free path, water that touches.
void add_path_extremes(std::vector<StabilityRow>& rows, int samples);

/// Private to the cases of light: what their scenes are made of.
namespace path_scenes {

ObjectModel square(double half_m);  ///< about the origin in z = 0, facing +z
/// Closed box; `inside_out`: its inner faces are the fronts.
ObjectModel box(const Eigen::Vector3d& half_m, bool inside_out = false);
Material matt(float albedo);
Material leaf_of(float albedo, float transmittance);
/// One more model, material and instance of them.
void add(Scene& scene, ObjectModel model, Material material, const Eigen::Vector3d& at_m);
Sky even_sky(float radiance);
/// 24 x 24 pixels.
TrueView view_from(const Eigen::Vector3d& eye_m, const Eigen::Vector3d& target_m,
                   double focal_px = 40);

}  // namespace path_scenes
}  // namespace cousin
