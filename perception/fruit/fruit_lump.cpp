#include "perception/fruit/fruit_lump.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace cousin {
namespace {

/// Of the outline as the image shows it, by its second moments.
double length_over_width(const std::vector<OutlinePlace>& outline) {
  if (outline.size() < 3) return 1;
  Eigen::Matrix2d moments = Eigen::Matrix2d::Zero();
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  const auto n = static_cast<double>(outline.size());
  for (const OutlinePlace& place : outline) middle += place.ray.hnormalized() / n;
  for (const OutlinePlace& place : outline) {
    const Eigen::Vector2d off = place.ray.hnormalized() - middle;
    moments += off * off.transpose();
  }
  const Eigen::Vector2d values =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(moments, Eigen::EigenvaluesOnly).eigenvalues();
  return std::sqrt(values[1] / std::max(values[0], 1e-30));
}

double share_nearer(const std::vector<OutlinePlace>& outline) {
  if (outline.empty()) return 0;
  const auto nearer = std::count_if(outline.begin(), outline.end(), [](const OutlinePlace& place) {
    return place.beyond == Beyond::nearer;
  });
  return static_cast<double>(nearer) / static_cast<double>(outline.size());
}

}  // namespace

FruitLump lump_of(const FruitSurface& surface, double solid_share) {
  constexpr double kVolumeOfBall = 0.85;
  FruitLump lump;
  double pixel_m = surface.depth_m / surface.focal_px;
  for (int i = 0; i < 2; ++i) {  // the outline is farther than the depths' median
    lump.radius_m = pixel_m * std::sqrt(surface.mask_px / std::numbers::pi);
    pixel_m = (surface.depth_m + 0.5 * lump.radius_m) / surface.focal_px;
  }
  lump.hidden = share_nearer(surface.outline);
  constexpr double kMostHidden = 0.1;  // of what is hidden more, the mask says little
  lump.is_whole = lump.hidden < kMostHidden && !surface.is_cut;
  lump.longer = length_over_width(surface.outline);
  // About half of what may hide a part does.
  const double hidden = 0.5 * lump.hidden, area = 1 + hidden, r = lump.radius_m;
  const auto size = [&](double value, double sigma) {
    return FruitMeasure{value, value * std::hypot(sigma, hidden)};
  };
  const double ball_m3 = 4.0 / 3 * std::numbers::pi * r * r * r;
  lump.volume_m3 = size(kVolumeOfBall * solid_share * ball_m3 * area * area, 0.25);
  lump.diameter_m = size(2 * r * std::sqrt(area), 0.12);
  lump.length_m = size(2 * r * std::sqrt(area), 0.2);
  return lump;
}

FruitCovariance spread_of(const FruitLump& lump) {
  FruitCovariance spread = FruitCovariance::Zero();
  const auto set = [&](int k, double sigma) { spread(k, k) = sigma * sigma; };
  for (const int k : {kCentreX, kCentreY}) set(k, 0.15 * lump.radius_m);
  set(kCentreZ, 0.3 * lump.radius_m);
  for (const int k : {kTurnX, kTurnY}) set(k, 1.2);  // rad
  set(kLogRadius, 0.12);
  set(kLogStretch, 0.2);
  return spread;
}

FruitShape shape_of(const FruitLump& lump, FruitShape start) {
  const double before_m = start.radius_m();
  const double larger = lump.diameter_m.value / numbers_of(start, 12).diameter_m.value;
  start.numbers[kLogRadius] += std::log(larger);
  const Eigen::Vector3d sight = start.centre_m().normalized();
  // The middle of the depths is 0.7 radii before the centre, as Search::start has it.
  start.numbers.head<3>() += 0.7 * (larger - 1) * before_m * sight;
  return start;
}

}  // namespace cousin
