#pragma once

#include <Eigen/Core>

#include "perception/fruit/fruit_shape.h"

namespace cousin {

/// Where stalks leave fruits and how they turn; no stalk is looked for in the image.
struct StalkPrior {
  double cut_above_m = 0.015;  ///< from the calyx to the cut, along the stalk; robots cut 10-20 mm
  double sigma_turn_rad =
      0.15;  ///< of the stalk's way to the cut beside the fruit's axis, each way
  double sigma_base_m = 0.0015;  ///< of where the stalk leaves the fruit, beside its end; each way
};
Fields fields(StalkPrior& prior);
/// @throws std::invalid_argument naming key, value and limit
void validate(const StalkPrior& prior);

/// A point in the camera with what is known of it.
struct LocatedPoint {
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();
};

/// Where a picker's gripper and blade go, in the camera.
struct FruitPlaces {
  LocatedPoint centre;  ///< of the volume
  LocatedPoint calyx;   ///< where the axis leaves the surface at the stalk
  LocatedPoint cut;     ///< on the stalk
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();      ///< unit, from tip to calyx
  double sigma_axis_rad = 0;                            ///< each way across
  Eigen::Vector3d approach = Eigen::Vector3d::UnitZ();  ///< as approach_to(cut, axis)
};

/// The way of a gripper to a cut: along the camera's line of sight, less its part along the stalk,
/// so that it closes on the stalk from before. Along the line of sight itself where the stalk
/// points at the camera. Unit, in the camera.
Eigen::Vector3d approach_to(const Eigen::Vector3d& cut_m, const Eigen::Vector3d& axis);

/// What the covariance of a shape does not say; FruitFitConfig has both.
struct PlaceSpread {
  double widen = 1;       ///< times all sigmas of the shape
  double unit_sigma = 0;  ///< of what all lengths of a sensor's unit are off, over them
};

/// To first order in the numbers' covariance. The stalk is taken to leave along the fruit's axis.
FruitPlaces places_of(const FruitShape& shape, const FruitCovariance& covariance,
                      const StalkPrior& stalk = {}, const PlaceSpread& more = {});

}  // namespace cousin
