#pragma once

#include <string>
#include <vector>

#include "sim/truth/scene.h"
#include "sim/truth/truth_images.h"

namespace cousin::closed_form {

inline constexpr int kSide = 32;  ///< pixels along an image

/// A scene whose mean radiance over the view is known.
struct Case {
  std::string name;
  Scene scene;
  TrueView view;
  double truth = 0;
  int max_bounces = 4;
};

/// Unit sphere, a cube's faces pushed out; `smooth`: with the sphere's own normals for shading.
ObjectModel sphere(int cells, bool smooth, bool inside_out = false);
ObjectModel square(double half_m);
/// Closed, about the origin.
ObjectModel box(const Eigen::Vector3d& half_m);
Material grey(float albedo, SurfaceKind kind = SurfaceKind::coated, double ior = 1,
              double roughness = 0.5);
Scene scene_of(ObjectModel model, Material material, std::vector<Light> lights);
TrueView view_from(const Eigen::Vector3d& eye_m, const Eigen::Vector3d& target_m, double focal_px);
Sky even_sky(float radiance);

/// Bodies that light goes into: water, and flesh below a skin.
void add_media(std::vector<Case>& cases);

}  // namespace cousin::closed_form
