#pragma once

#include <string>

#include "perception/fruit/fruit_lump.h"
#include "perception/fruit/fruit_shape.h"
#include "perception/fruit/fruit_surface.h"

namespace cousin {

/// How a fruit's whole surface, its hidden side too, is found from what is seen of it.
struct FruitFitConfig {
  int iterations = 8;       ///< of each start that is followed
  int followed = 3;         ///< starts, of those that are tried
  int wave_iterations = 3;  ///< of the whole shape; twice that of an odd one
  /// Of an odd shape's waves over the prior's. Free, set with the family of scenes/fruit in view
  /// and tried on seed 105 of it.
  double odd_scale = 12;
  double odd_share = 0.05;  ///< probability of an odd shape before it is seen
  /// Probability of a fruit like none of its kind before it is seen.
  double strange_share = 0.01;
  /// What the best shape of a usual fruit costs at most: a place of the outline, an independent
  /// depth, the prior. More says that a fruit is strange. Free; set on strawberries of seeds 101
  /// and 102, and of another family of seed 105.
  double usual_rim = 0.3, usual_depth = 1, usual_prior = 4;
  double outline_sigma_px = 0.5;  ///< of a place of the outline
  double along_rim = 0.85;        ///< cosine of an edge against the rim; less is no rim
  double unknown_share = 0.3;     ///< weight of an outline with no depth beyond it
  double floor_m = 0.0004;        ///< sigma of a surface finer than the model's
  double unit_sigma = 0.003;      ///< of what all lengths of a unit are off, over them
  /// Sigmas of the axis beside upright in the image: cameras are held level, fruits hang.
  double lean_sigma = 0.5;         ///< sideways, of the axis's unit vector
  double pitch_sigma = 0.8;        ///< towards the camera or away
  double most_rms = 4;             ///< residuals of more sigmas are of no such fruit
  double most_sigma_volume = 0.3;  ///< over the volume; more is too little seen
  double most_odd = 3.5;           ///< sigmas of the prior that a size or shape may be off
  double widen = 0.9;              ///< times all sigmas; fitted to coverage on seeds 101 to 103
};
Fields fields(FruitFitConfig& config);
void validate(const FruitFitConfig& config);

/// A fruit's surface and size. With another status than ok, sizes are what is known of the kind or
/// of a fit that is not trusted, with wide sigmas, or NaN.
struct FruitFit {
  FitStatus status = FitStatus::not_converged;
  std::string reason;  ///< why it is not ok; of one that is, that it is strange
  FruitShape shape;
  FruitCovariance covariance = FruitCovariance::Zero();
  FruitMeasure volume_m3, diameter_m, length_m, mass_kg;
  double rms = kNaN;      ///< of depths about the surface, over their sigmas
  double wave_scale = 1;  ///< of the likelier prior's waves
  double strange = 0;     ///< probability that it is like none of its kind
};

/// Most probable shape by its prior, depths and outline [Levenberg-Marquardt from several axes]:
/// - depths are residuals along the surface's normal, with Huber's weights;
/// - where what is beyond an outline is farther, the outline is the fruit's rim; it may be cut by
///   what is too thin for the sensor, so a fruit larger than its outline costs less [Cauchy];
/// - where what is beyond is nearer, the rim is there or farther out, and no residual pulls it in;
/// - two priors are tried, the kind's and one whose waves are far stronger; each counts by the
///   evidence for it [Laplace's approximation], so fruits of another shape get wider intervals;
/// - what no shape of the kind explains, the outline where it is not the model's rim too, says that
///   the fruit is strange: as likely as that is, it is a lump (fruit_lump.h) whose axis is not
///   known;
/// - sigmas are those of the linearised posterior, times the residuals' spread where that is more
///   than expected, with what other axes that fit as well would give.
FruitFit fit_fruit(const FruitSurface& surface, const FruitKind& kind,
                   const FruitFitConfig& config = {});

/// A fruit that no image shows: it has the prior's means and sigmas.
FruitFit unseen_fruit(const FruitKind& kind, const std::string& reason);

}  // namespace cousin
