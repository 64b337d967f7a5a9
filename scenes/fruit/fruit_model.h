#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "sim/geometry/harmonic_radii.h"
#include "sim/truth/scene.h"
#include "sim/types/rng.h"

namespace cousin {

enum class FruitFamily {
  botanical,  ///< the species' own outlines
  harmonics   ///< radii of random spherical harmonics of the same size: nothing of the species'
};

/// By name. @throws std::invalid_argument listing the names.
FruitFamily fruit_family(const std::string& name);

/// A shape and what it is made of.
struct FruitPart {
  ObjectModel model;
  Material material;
};

/// A fruit in its own frame: origin at the flesh's centroid, +z from its tip (or the apple's calyx)
/// to its stalk.
struct FruitModel {
  FruitPart flesh;  ///< closed; with keypoints
  FruitPart calyx;  ///< open sheets
  FruitPart stalk;  ///< closed
  Mesh hull;        ///< convex, of the flesh to 0.2 mm: for contacts
  /// length, diameter (m), volume (m3), area (m2), red_share (1), mass (kg), of the flesh without
  /// achenes, calyx and stalk.
  std::vector<TrueTrait> traits;
  double mass_kg = 0;
  Eigen::Vector3d stalk_base_m = Eigen::Vector3d::Zero();  ///< where the stalk enters the flesh
};

/// Value of a trait. @throws std::invalid_argument naming it if it is not there.
double trait(const FruitModel& fruit, const std::string& name);

/// Classes of maturity, by red share: 0, 1, 2.
inline constexpr std::array<const char*, 3> kMaturities = {"low", "medium", "high"};
/// 0 below `medium`, 2 above `high`, else 1.
int maturity_of(double red_share, double medium, double high);
/// @throws std::invalid_argument if `medium` is above `high`.
void check_maturity(double medium, double high);
/// Labels of a fruit, and its maturity as its category.
void set_labels(Instance& fruit, const std::string& variety, int maturity);

/// Mean over 36 directions across z of a shape's extent: what a caliper turned about the axis
/// reads.
double mean_width_m(const std::vector<Eigen::Vector3d>& points_m);

/// Area of the part of a closed mesh on which the texture is red over the whole: red >= 2 green of
/// linear albedo, exactly, as both are linear on each triangle.
double red_share(const Mesh& mesh, const std::vector<Rgbf>& vertex_albedo);
/// Whether a colour counts as red there.
inline constexpr double kRedOverGreen = 2;

/// Colours of a mesh by how early each vertex ripens: vertex i gets color(i, ripe) with ripe =
/// (early[i] - front) / width, for the front at which `wanted` of the area is red, where color
/// turns red at ripe = `turning`. 0 and 1 put the front beyond the last and the first vertex.
std::vector<Rgbf> color_to_share(const Mesh& mesh, const std::vector<double>& early, double width,
                                 double turning, double wanted,
                                 const std::function<Rgbf(std::size_t, double)>& color);

/// A closed tube about a centre line.
/// @param radii_m  one for each point
Mesh tube(const std::vector<Eigen::Vector3d>& points_m, const std::vector<double>& radii_m,
          int sides);

/// What of a ripe fruit is drawn before its shape.
struct FruitSize {
  double mass_kg = 0;
  double shape_index = 0;  ///< length over diameter
  double density_kg_m3 = 0;
};

/// A normal cut at two standard deviations and widened so that the cut leaves `sigma` as stated.
double cut_normal(Rng& rng, double mean, double sigma);

/// Cut normals, as a variety or cultivar says.
template <class Kind>
FruitSize draw_size(const Kind& kind, Rng rng) {
  FruitSize size;
  size.mass_kg = kind.mass_kg * cut_normal(rng, 1, kind.cv_mass);
  size.shape_index = cut_normal(rng, kind.shape_index, kind.sigma_shape_index);
  size.density_kg_m3 = cut_normal(rng, kind.density_kg_m3, kind.sigma_density_kg_m3);
  return size;
}

/// Convex hull of a finely meshed fruit for contacts: of every fifth vertex, thinned to 0.2 mm.
Mesh contact_hull(const Mesh& flesh);

/// Stretches a closed mesh along and across z to a ratio of length to mean width, then evenly to a
/// volume, and moves its centroid to the origin.
void fit_shape(Mesh& mesh, double length_over_width, double volume_m3);

/// The six traits of a fruit's flesh.
std::vector<TrueTrait> fruit_traits(const Mesh& flesh, double red_share, double mass_kg);

}  // namespace cousin
