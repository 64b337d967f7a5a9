#include "perception/fruit/fruit_place.h"

#include <algorithm>
#include <cmath>

#include "sim/config/limits.h"

namespace cousin {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Slope = Eigen::Matrix<double, 3, kFruitNumbers>;

/// How a point that is fixed in the fruit's frame moves with where the fruit is and how it stands.
Slope rigid_slope(const FruitShape& shape, const Vector3d& in_fruit_m) {
  Slope slope = Slope::Zero();
  slope.block<3, 3>(0, kCentreX).setIdentity();
  slope.col(kTurnX) = shape.camera_from_fruit * Vector3d::UnitX().cross(in_fruit_m);
  slope.col(kTurnY) = shape.camera_from_fruit * Vector3d::UnitY().cross(in_fruit_m);
  return slope;
}

Matrix3d spread(const Slope& slope, const FruitCovariance& covariance) {
  const Matrix3d m = slope * covariance * slope.transpose();
  return 0.5 * (m + m.transpose());
}

/// Sigmas of two directions across the axis, as a covariance.
Matrix3d across(const Vector3d& axis, double sigma_m) {
  return sigma_m * sigma_m * (Matrix3d::Identity() - axis * axis.transpose());
}

}  // namespace

Fields fields(StalkPrior& p) {
  return {{"cut_above_m", &p.cut_above_m, "from the calyx to the cut along the stalk", 0, 0.2},
          {"sigma_turn_rad", &p.sigma_turn_rad, "sigma of its way beside the fruit's axis", 0, 2},
          {"sigma_base_m", &p.sigma_base_m, "sigma of where it leaves the fruit", 0, 0.1}};
}

void validate(const StalkPrior& prior) {
  StalkPrior copy = prior;
  check_limits(fields(copy), "stalk");
}

FruitPlaces places_of(const FruitShape& shape, const FruitCovariance& covariance,
                      const StalkPrior& stalk, const PlaceSpread& more) {
  const FruitCovariance wide = more.widen * more.widen * covariance;
  FruitPlaces places;
  places.axis = shape.camera_from_fruit * Vector3d::UnitZ();
  places.sigma_axis_rad =
      std::sqrt(std::max(0.0, 0.5 * (wide(kTurnX, kTurnX) + wide(kTurnY, kTurnY))));

  const FruitVector middle = centroid_in_fruit(shape);
  places.centre.point_m = shape.centre_m() + shape.camera_from_fruit * middle.value_m;
  places.centre.covariance_m2 = spread(
      rigid_slope(shape, middle.value_m) + shape.camera_from_fruit * middle.derivative, wide);

  const FruitNumber height = pole_m(shape);
  const auto on_axis = [&](double above_m) {
    Slope slope = rigid_slope(shape, Vector3d(0, 0, height.value + above_m));
    slope += places.axis * height.derivative.transpose();
    return LocatedPoint{shape.centre_m() + (height.value + above_m) * places.axis,
                        spread(slope, wide) + across(places.axis, stalk.sigma_base_m)};
  };
  places.calyx = on_axis(0);
  places.cut = on_axis(stalk.cut_above_m);
  places.cut.covariance_m2 += across(places.axis, stalk.cut_above_m * stalk.sigma_turn_rad);

  for (LocatedPoint* place : {&places.centre, &places.calyx, &places.cut})
    place->covariance_m2 +=
        more.unit_sigma * more.unit_sigma * place->point_m * place->point_m.transpose();
  places.approach = approach_to(places.cut.point_m, places.axis);
  return places;
}

Vector3d approach_to(const Vector3d& cut_m, const Vector3d& axis) {
  constexpr double kLeastSine = 0.1;  // of the angle between sight and stalk
  const Vector3d sight = cut_m.normalized();
  const Vector3d across_axis = sight - sight.dot(axis) * axis;
  return across_axis.norm() > kLeastSine ? across_axis.normalized() : sight;
}

}  // namespace cousin
