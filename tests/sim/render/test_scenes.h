#pragma once

#include <Eigen/Core>

#include "benchmarks/suites/render/corner_position.h"
#include "sim/truth/scene.h"
#include "sim/truth/truth_images.h"

namespace cousin::test {

/// Closed sphere-like mesh: a cube's faces of cells x cells squares pushed onto an ellipsoid. Its
/// corners lie on the surface.
ObjectModel ellipsoid(const Eigen::Vector3d& semi_axes_m, int cells);
/// Axis-aligned closed box, two triangles a face, from `low` to `high`.
ObjectModel box(const Eigen::Vector3d& low_m, const Eigen::Vector3d& high_m);
/// Open square of two triangles about the origin in z = 0, facing +z.
ObjectModel square(double half_m);
/// Triangles turned inside out.
ObjectModel inside_out(ObjectModel model);

/// Adds a model and one instance of it; returns the instance's id.
int add(Scene& scene, ObjectModel model, const Material& material,
        const Pose& world_from_object = {}, bool is_specimen = false);

/// Purely diffuse grey.
Material matt(float albedo);

/// A global-shutter view.
TrueView view_from(const Camera& camera, const Eigen::Vector3d& eye_m,
                   const Eigen::Vector3d& target_m,
                   const Eigen::Vector3d& up = Eigen::Vector3d::UnitZ());

/// Board of 100 mm, green screen, `seeds` ellipsoids, sky and two lamps.
Scene table_top(int seeds, int cells);

}  // namespace cousin::test
