#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "sim/config/fields.h"

namespace cousin {

/// How the fruits of a kind differ in shape, before one is seen. A fruit is a sphere that is
/// stretched along its axis, has a dent at both ends and waves a little [the deformed sphere of
/// Apples 2.3.2, eq. 17 to 28]. The defaults are the numbers that scenes/apples/cultivars.toml
/// draws its Fuji from, as if they had been measured on many fruits; sigma_diameter and those of
/// the waves are free, and wider. Lengths in metres; means, and standard deviations of normal
/// distributions.
struct FruitPrior {
  double diameter_m = 0.088;     ///< mean extent across the axis
  double sigma_diameter = 0.09;  ///< over the mean: wide, trees and years differ
  double shape_index = 0.86;     ///< length along the axis over diameter
  double sigma_shape_index = 0.035;
  double conic = 0.08;  ///< wider to the stalk, over the radius
  double sigma_conic = 0.02;
  /// Zonal waves of degree 3 and 4 about the axis: the outline of a kind that is no sphere.
  double zonal_3 = 0, zonal_4 = 0;
  double sigma_lopsided = 0.021;  ///< one side's excess over the radius, each of two directions
  double stalk_dent = 0.44;       ///< depth over the radius
  double stalk_dent_rad = 0.24;   ///< where it is e times shallower
  double calyx_dent = 0.25;
  double calyx_dent_rad = 0.18;
  double sigma_dents = 0.12;  ///< of both depths, over their means
  /// Of each wave (spherical harmonic of unit mean square) of degree 2, 3 and 4, over the radius.
  double sigma_waves_2 = 0.002;
  double sigma_waves_3 = 0.0015;
  double sigma_waves_4 = 0.001;
  /// Lumps and dimples: outlines are those of the highest places, so a rough fruit has less volume
  /// than the smooth one with its outline.
  double solid_share = 1;
  double density_kg_m3 = 858;  ///< [Korean Journal of Food Preservation 21(5), 618, 2014]
  double sigma_density_kg_m3 = 14;
};
Fields fields(FruitPrior& prior);
/// @throws std::invalid_argument naming key, value and limit
void validate(const FruitPrior& prior);

/// Places of a fruit's numbers in FruitParameters. The first five say where it is.
enum FruitEntry {
  kCentreX,
  kCentreY,
  kCentreZ,
  kTurnX,  ///< of the axis, about the fruit's own x and y: zero, but for increments
  kTurnY,
  kLogRadius,
  kLogStretch,
  kConic,
  kLopsidedX,
  kLopsidedY,
  kStalkDent,
  kCalyxDent,
  kWaves  ///< the first of them
};
inline constexpr int kWaveCount = 18;  ///< two of degree 2, seven of degree 3, nine of degree 4
inline constexpr int kFruitNumbers = kWaves + kWaveCount;
using FruitParameters = Eigen::Matrix<double, kFruitNumbers, 1>;
using FruitCovariance = Eigen::Matrix<double, kFruitNumbers, kFruitNumbers>;

/// A closed surface: points p with |y| = rho(y / |y|) for y = diag(1, 1, 1/stretch) x / radius and
/// x = p in the fruit's own frame, whose z goes from calyx to stalk.
struct FruitShape {
  FruitParameters numbers = FruitParameters::Zero();
  Eigen::Matrix3d camera_from_fruit = Eigen::Matrix3d::Identity();
  double stalk_dent_rad = 0.24, calyx_dent_rad = 0.18;

  Eigen::Vector3d centre_m() const { return numbers.head<3>(); }
  double radius_m() const;
  double stretch() const;
};

/// The prior's mean at the origin, upright in its own frame.
FruitShape mean_shape(const FruitPrior& prior);
/// Standard deviations of the numbers; infinite for those that say where it is.
FruitParameters prior_sigmas(const FruitPrior& prior);

/// A prior and what follows from it, found once for all fruits of a kind.
struct FruitKind {
  FruitPrior prior;
  FruitShape mean;
  FruitParameters sigmas;
};
FruitKind kind_of(const FruitPrior& prior);
/// Strawberries of any variety and maturity. Means and sigmas of the outline are those of the three
/// varieties of scenes/strawberries; sizes are wider, for fruits grow.
FruitPrior strawberry_prior();

/// The signed distance of a point from the surface, to first order, and its derivative by all
/// numbers. Positive outside.
struct FruitDistance {
  double distance_m = 0;
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< unit, outward, in the camera
  FruitParameters derivative;
};
/// @param waves  whether waves count; without, only the zonal ones do, which have no derivative
FruitDistance distance_to(const FruitShape& shape, const Eigen::Vector3d& point_m, bool waves);

/// The same shape after small changes of its numbers; turns go into camera_from_fruit.
FruitShape changed(const FruitShape& shape, const FruitParameters& by);

/// A number of a shape and how it changes with the shape's.
struct FruitNumber {
  double value = 0;
  FruitParameters derivative = FruitParameters::Zero();
};
struct FruitNumbers {
  FruitNumber volume_m3, diameter_m, length_m;
};
/// Volume, mean extent across the axis and extent along it.
/// @param rows  from pole to pole, on which the surface is sampled, and as many about the axis;
/// even
FruitNumbers numbers_of(const FruitShape& shape, int rows = 36);

/// A point in a fruit's own axes, from the shape's own centre, and how it moves with the numbers.
struct FruitVector {
  Eigen::Vector3d value_m = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, 3, kFruitNumbers> derivative =
      Eigen::Matrix<double, 3, kFruitNumbers>::Zero();
};
/// Centre of the volume.
FruitVector centroid_in_fruit(const FruitShape& shape, int rows = 16);
/// How far the surface is from the shape's centre along the axis, at the stalk.
FruitNumber pole_m(const FruitShape& shape);
/// The surface's unit normal, outward, where a ray from the camera meets it; the ray's own opposite
/// where it passes. Waves are left out.
Eigen::Vector3d normal_on_ray(const FruitShape& shape, const Eigen::Vector3d& ray);

/// Points of the surface, in the camera: `rows` from pole to pole by `columns` about the axis.
std::vector<Eigen::Vector3d> points_of(const FruitShape& shape, int rows, int columns);

}  // namespace cousin
