// Where the blade goes, from a fruit's shape and what is known of it.
#include "perception/fruit/fruit_place.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "perception/fruit/fruit_seam.h"
#include "perception/fruit/red_share.h"
#include "tests/perception/fruit/drawn_fruit.h"

namespace cousin {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

/// The mean strawberry at 0.4 m, its stalk up in the image and by so much away from the camera.
FruitShape hanging_strawberry(double away_rad) {
  FruitShape shape = mean_shape(strawberry_prior());
  shape.camera_from_fruit =
      Eigen::Quaterniond::FromTwoVectors(
          Eigen::Vector3d::UnitZ(), Eigen::Vector3d(0, -std::cos(away_rad), std::sin(away_rad)))
          .toRotationMatrix();
  shape.numbers.head<3>() = Eigen::Vector3d(0.01, -0.02, 0.4);
  return shape;
}

TEST(FruitPlace, TheCutIsBeyondTheCalyxAlongTheAxis) {
  const FruitShape shape = hanging_strawberry(0.3);
  const FruitPlaces places = places_of(shape, FruitCovariance::Zero());
  EXPECT_LT((places.cut.point_m - places.calyx.point_m - 0.015 * places.axis).norm(), 1e-12);
  EXPECT_NEAR(distance_to(shape, places.calyx.point_m, true).distance_m, 0, 1e-9);
  // A fruit is widest near its stalk: there its volume's centre is, and the calyx less than half of
  // its length above.
  const double above_m = (places.calyx.point_m - places.centre.point_m).dot(places.axis);
  const double length_m = numbers_of(shape).length_m.value;
  EXPECT_GT(above_m, 0.35 * length_m);
  EXPECT_LT(above_m, 0.5 * length_m);
  EXPECT_NEAR(places.approach.dot(places.axis), 0, 1e-12);
  EXPECT_GT(places.approach.z(), 0.9);
  // A stalk that points at the camera has no side: the gripper comes along the line of sight.
  const FruitPlaces from_above =
      places_of(hanging_strawberry(-std::numbers::pi / 2), FruitCovariance::Zero());
  EXPECT_GT(from_above.approach.dot(from_above.cut.point_m.normalized()), 0.99);
}

TEST(FruitPlace, CovariancesAreThoseOfDrawnShapes) {
  const FruitShape shape = hanging_strawberry(0.2);
  FruitParameters sigmas = FruitParameters::Zero();
  sigmas[kCentreX] = 0.001;
  sigmas[kCentreZ] = 0.002;
  sigmas[kTurnX] = 0.05;
  sigmas[kTurnY] = 0.08;
  sigmas[kLogRadius] = 0.03;
  sigmas[kLogStretch] = 0.04;
  sigmas[kConic] = 0.02;
  const StalkPrior straight{.cut_above_m = 0.015, .sigma_turn_rad = 0, .sigma_base_m = 0};
  const FruitPlaces places =
      places_of(shape, sigmas.cwiseAbs2().asDiagonal().toDenseMatrix(), straight);
  Eigen::Matrix3d drawn = Eigen::Matrix3d::Zero(), centre = Eigen::Matrix3d::Zero();
  Rng rng(3);
  constexpr int kDraws = 4000;
  for (int i = 0; i < kDraws; ++i) {
    FruitParameters by = FruitParameters::Zero();
    for (int k = 0; k < kFruitNumbers; ++k) by[k] = sigmas[k] * normal(rng);
    const FruitPlaces one = places_of(changed(shape, by), FruitCovariance::Zero(), straight);
    const Eigen::Vector3d off = one.cut.point_m - places.cut.point_m;
    const Eigen::Vector3d aside = one.centre.point_m - places.centre.point_m;
    drawn += off * off.transpose() / kDraws;
    centre += aside * aside.transpose() / kDraws;
  }
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(std::sqrt(places.cut.covariance_m2(k, k)), std::sqrt(drawn(k, k)),
                0.06 * std::sqrt(drawn(k, k)))
        << k;
    EXPECT_NEAR(std::sqrt(places.centre.covariance_m2(k, k)), std::sqrt(centre(k, k)),
                0.06 * std::sqrt(centre(k, k)))
        << k;
  }
  const StalkPrior bent{.cut_above_m = 0.015, .sigma_turn_rad = 0.4, .sigma_base_m = 0.002};
  const FruitPlaces wider =
      places_of(shape, sigmas.cwiseAbs2().asDiagonal().toDenseMatrix(), bent, {.widen = 2});
  EXPECT_NEAR(wider.cut.covariance_m2(0, 0),
              4 * places.cut.covariance_m2(0, 0) + std::pow(0.015 * 0.4, 2) + 4e-6, 1e-12);
}

TEST(FruitPlace, WhatAllLengthsOfAUnitAreOffIsAlongTheLineOfSight) {
  const FruitPlaces places =
      places_of(hanging_strawberry(0.2), FruitCovariance::Zero(), {}, {.unit_sigma = 0.01});
  const Eigen::Vector3d& at_m = places.centre.point_m;
  EXPECT_LT((places.centre.covariance_m2 - 1e-4 * at_m * at_m.transpose()).norm(), 1e-15);
}

TEST(FruitPlace, WhatIsNotKnownIsNotANumber) {
  const FruitCovariance none = FruitCovariance::Constant(kNaN);
  EXPECT_TRUE(std::isnan(places_of(hanging_strawberry(0), none).cut.covariance_m2(1, 1)));
  StalkPrior wrong;
  wrong.cut_above_m = -0.01;
  EXPECT_THAT([&] { validate(wrong); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("cut_above_m")));
}

TEST(FruitSeam, AFitComesBackFromItsSeam) {
  FruitFit fit;
  fit.status = FitStatus::ok;
  fit.shape = hanging_strawberry(0.4);
  fit.shape.numbers[kWaves + 5] = 0.01;
  fit.covariance = 1e-6 * FruitCovariance::Identity();
  fit.covariance(kCentreX, kConic) = fit.covariance(kConic, kCentreX) = 2e-7;
  fit.volume_m3 = {2e-5, 1e-6};
  fit.diameter_m = {0.03, 0.001};
  fit.length_m = {0.04, 0.002};
  const ObjectFit seam = seam_of(fit, 7, "strawberry by ours");
  EXPECT_EQ(seam.instance, 7);
  const FruitShape shape = shape_of(seam);
  EXPECT_LT((shape.numbers - fit.shape.numbers).norm(), 1e-15);
  EXPECT_LT((shape.camera_from_fruit - fit.shape.camera_from_fruit).norm(), 1e-12);
  EXPECT_LT((covariance_of(seam) - fit.covariance).norm(), 1e-15);
  EXPECT_DOUBLE_EQ(parameter_of(seam, "length").sigma, 0.002);
  EXPECT_TRUE(std::isnan(parameter_of(seam, "mass").value));
  fit.length_m.sigma = kNaN;  // sizes without sigmas: nothing is said of any number
  EXPECT_TRUE(std::isnan(covariance_of(seam_of(fit, 7, "x"))(0, 0)));
}

/// A fruit whose pixels are red to the right of a column.
Image<Rgb8> painted(const DrawnFruit& drawn, int red_from) {
  Image<Rgb8> color(kFruitCamera.width_px, kFruitCamera.height_px, Rgb8{40, 90, 30});
  for (int y = 0; y < color.height(); ++y) {
    for (int x = 0; x < color.width(); ++x) {
      if (drawn.box.mask(x, y) != 0)
        color(x, y) = x >= red_from ? Rgb8{200, 30, 25} : Rgb8{190, 185, 120};
    }
  }
  return color;
}

TEST(RedShare, HalfOfARoundFruitIsHalf) {
  FruitShape shape = hanging_strawberry(0);
  shape.numbers.head<3>() = Eigen::Vector3d(0, 0, 0.4);
  const DrawnFruit drawn = draw_fruit(shape, 0, Rng(1));
  const FruitMeasure half =
      red_share_seen(painted(drawn, 100), kFruitCamera, drawn.box, shape);  // cx is 99.5
  EXPECT_NEAR(half.value, 0.5, 0.02);
  EXPECT_GT(half.sigma, 0.1);  // the hidden side may be otherwise
  EXPECT_EQ(red_share_seen(painted(drawn, 0), kFruitCamera, drawn.box, shape).value, 1);
  EXPECT_EQ(red_share_seen(painted(drawn, 999), kFruitCamera, drawn.box, shape).value, 0);
  // Slanted pixels show more of the surface: the red rim counts more than its pixels.
  int red = 0, all = 0;
  for (int y = 0; y < drawn.box.mask.height(); ++y) {
    for (int x = 0; x < drawn.box.mask.width(); ++x) {
      if (drawn.box.mask(x, y) == 0) continue;
      ++all;
      red += x >= 108;
    }
  }
  RedShareConfig all_of_it;
  all_of_it.least_cosine = 0.02;
  all_of_it.inset_px = 0;
  EXPECT_GT(red_share_seen(painted(drawn, 108), kFruitCamera, drawn.box, shape, all_of_it).value,
            1.1 * red / all);
}

TEST(RedShare, TooFewPixelsAreNoShare) {
  const FruitShape shape = hanging_strawberry(0);
  DrawnFruit drawn = draw_fruit(shape, 0, Rng(1));
  RedShareConfig config;
  config.least_pixels = 1000000;
  EXPECT_TRUE(
      std::isnan(red_share_seen(painted(drawn, 0), kFruitCamera, drawn.box, shape, config).value));
  EXPECT_TRUE(std::isnan(red_share_seen({}, kFruitCamera, drawn.box, shape).value));
  drawn.box.low_px.x() = -1e300;  // a box far larger than the image costs no more than the image
  drawn.box.high_px.x() = 1e300;
  EXPECT_GT(red_share_seen(painted(drawn, 0), kFruitCamera, drawn.box, shape).value, 0.9);
  config.red_over_green = 0;
  EXPECT_THAT([&] { validate(config); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("red_over_green")));
}

}  // namespace
}  // namespace cousin
