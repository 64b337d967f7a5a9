#include "sim/sensors/metering.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "sim/sensors/camera_sensor.h"

namespace cousin {

MeteredSpot metered_spot(const View& seen, const TrueView& view, double metered_m) {
  if (!(metered_m > 0)) return {};
  const Eigen::Vector3d focus_in_camera_m = view.camera_from_world * seen.focus_in_world_m;
  const std::optional<Eigen::Vector2d> at = project(view.camera, focus_in_camera_m);
  if (!at) return {};
  return {at->x(), at->y(), view.camera.fx_px * metered_m / focus_in_camera_m.norm()};
}

double spot_exposure_electrons(const Image<Rgbf>& radiance, const MeteredSpot& spot,
                               double highlights_e, double full_well_e) {
  constexpr double kMidGrey = 0.25, kLeast = 0.5, kMost = 8;
  if (!(spot.radius_px > 0)) return highlights_e;
  double sum = 0;
  std::size_t count = 0;
  for (int y = 0; y < radiance.height(); ++y) {
    const auto row = radiance.row(y);
    for (std::size_t x = 0; x < row.size(); ++x) {
      if (std::hypot(static_cast<double>(x) - spot.x_px, y - spot.y_px) > spot.radius_px) continue;
      sum += static_cast<double>(std::max({row[x].r, row[x].g, row[x].b}));
      ++count;
    }
  }
  if (count == 0) return highlights_e;
  const double mean = std::max(sum / static_cast<double>(count), 1e-12);
  return std::clamp(kMidGrey * full_well_e / mean, kLeast * highlights_e, kMost * highlights_e);
}

CameraSensorConfig metered(CameraSensorConfig config, const Image<Rgbf>& radiance,
                           const MeteredSpot& spot) {
  PhotositesConfig& p = config.photosites;
  if (p.electrons_at_unit_radiance > 0 || !(spot.radius_px > 0)) return config;
  p.electrons_at_unit_radiance = spot_exposure_electrons(
      radiance, spot, electrons_per_radiance(config, radiance), p.full_well_e);
  return config;
}

PhoneConfig metered(PhoneConfig config, const Image<Rgbf>& radiance, const MeteredSpot& spot) {
  if (config.electrons_at_unit_radiance > 0 || !(spot.radius_px > 0)) return config;
  config.electrons_at_unit_radiance = spot_exposure_electrons(
      radiance, spot, electrons_per_radiance(config, radiance), config.full_well_e);
  return config;
}

}  // namespace cousin
