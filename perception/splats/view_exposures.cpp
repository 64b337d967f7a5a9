#include "perception/splats/view_exposures.h"

#include <tbb/parallel_for.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>

#include "perception/splats/exposure_fit.h"

namespace cousin {
namespace {

/// sRGB's curve, which goes on above 1 where sim/imaging/color.h ends.
double light_of(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}
double encoded(double light) {
  return light <= 0.0031308 ? light * 12.92 : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}

double radius2(const Camera& camera, double x_px, double y_px) {
  const double dx = x_px - camera.cx_px, dy = y_px - camera.cy_px;
  const double w = camera.width_px, h = camera.height_px;
  return 4 * (dx * dx + dy * dy) / (w * w + h * h);
}

/// Looks at surfaces in all views.
class SurfaceLight {
 public:
  SurfaceLight(std::span<const SplatView> views, std::span<const Image<float>> depths_m,
               const ExposureConfig& config)
      : views_(views), depths_m_(depths_m), config_(config) {
    for (const SplatView& view : views) lenses_.emplace_back(view.full.camera);
  }

  /// Of the surfaces that a view has depths of, in the views that have the same; in those of
  /// `unsure` also where these have no depth, so that something may be before the surface.
  LightSightings of_view(std::size_t view, const std::vector<std::uint8_t>& unsure) const {
    LightSightings found;
    const Image<float>& depth_m = depths_m_[view];
    const Pose world_from_camera = inverse(views_[view].camera_from_world);
    for (int y = 0; y < depth_m.height(); y += config_.stride_px) {
      for (int x = 0; x < depth_m.width(); x += config_.stride_px) {
        const double z_m = depth_m(x, y);
        if (!(z_m > 0) || !std::isfinite(z_m)) continue;
        const auto ray = lenses_[view].unproject({x, y});
        if (!ray) continue;
        const Eigen::Vector3d at_m = world_from_camera * Eigen::Vector3d(*ray * (z_m / ray->z()));
        add_point(at_m, unsure, found);
      }
    }
    return found;
  }

 private:
  void add_point(const Eigen::Vector3d& at_m, const std::vector<std::uint8_t>& unsure,
                 LightSightings& found) const {
    for (std::size_t v = 0; v < views_.size(); ++v) {
      if (const auto sighting = in_view(v, at_m, unsure[v] != 0)) found.all.push_back(*sighting);
    }
    if (found.all.size() - found.first.back() < kLeastSharingViews)
      found.all.resize(found.first.back());
    else
      found.first.push_back(found.all.size());
  }

  std::optional<LightSighting> in_view(std::size_t v, const Eigen::Vector3d& at_m,
                                       bool is_unsure) const {
    const Image<float>& depth_m = depths_m_[v];
    if (depth_m.empty() && !is_unsure) return std::nullopt;
    const Eigen::Vector3d in_camera_m = views_[v].camera_from_world * at_m;
    if (!(in_camera_m.z() > 0)) return std::nullopt;
    const auto pixel = lenses_[v].project(in_camera_m);
    if (!pixel) return std::nullopt;
    const double x0 = std::floor(pixel->x()), y0 = std::floor(pixel->y());
    const SplatViewLevel& level = views_[v].full;
    if (!(x0 >= 0 && y0 >= 0 && x0 + 1 < level.camera.width_px && y0 + 1 < level.camera.height_px))
      return std::nullopt;
    const int x = static_cast<int>(x0), y = static_cast<int>(y0);
    const double right = pixel->x() - x0, down = pixel->y() - y0;
    const double there_m =
        depth_m.empty()
            ? kNaN
            : static_cast<double>(depth_m(x + (right >= 0.5 ? 1 : 0), y + (down >= 0.5 ? 1 : 0)));
    const double most_m = config_.depth_agreement * in_camera_m.z();
    if (!(std::abs(there_m - in_camera_m.z()) <= most_m || (is_unsure && std::isnan(there_m))))
      return std::nullopt;
    double light = 0, sum = 0;
    for (int corner = 0; corner < 4; ++corner) {
      const int i = corner % 2, j = corner / 2;
      const double share = (i ? right : 1 - right) * (j ? down : 1 - down);
      if (!level.weight.empty() && !(level.weight(x + i, y + j) > 0.999F)) return std::nullopt;
      if (!level.behind.empty() && level.behind(x + i, y + j) > 0.001F) return std::nullopt;
      for (const Image<float>& channel : level.color.channel) {
        const double value = channel(x + i, y + j);
        if (!(value <= config_.brightest)) return std::nullopt;
        light += share * light_of(value);
        sum += share * value;
      }
    }
    if (!(sum >= 3 * config_.darkest)) return std::nullopt;
    const int nearest = (y + (down >= 0.5 ? 1 : 0)) * level.camera.width_px + x + (right >= 0.5);
    return LightSighting{static_cast<int>(v), nearest, std::log(light),
                         radius2(level.camera, pixel->x(), pixel->y())};
  }

  std::span<const SplatView> views_;
  std::span<const Image<float>> depths_m_;
  ExposureConfig config_;
  std::vector<Lens> lenses_;
};

/// TBB over views; in their order.
LightSightings all_sightings(const SurfaceLight& light, const std::vector<std::uint8_t>& unsure) {
  std::vector<LightSightings> by_view(unsure.size());
  tbb::parallel_for(std::size_t{0}, unsure.size(),
                    [&](std::size_t v) { by_view[v] = light.of_view(v, unsure); });
  LightSightings all;
  for (const LightSightings& of_one : by_view) all.append(of_one);
  return all;
}

std::int64_t sightings_of(const LightSightings& sightings, std::size_t view) {
  return std::count_if(sightings.all.begin(), sightings.all.end(),
                       [&](const LightSighting& s) { return s.view == static_cast<int>(view); });
}

void check(const char* name, double value, double low, double high) {
  if (value >= low && value <= high) return;
  throw std::invalid_argument("exposures: " + std::string(name) + " = " + std::to_string(value) +
                              " is not in " + std::to_string(low) + " .. " + std::to_string(high));
}

template <typename Curve>
void for_colors(ColorPlanes& planes, const Camera& camera, const Curve& curve) {
  const Image<float>& first = planes.channel[0];
  tbb::parallel_for(0, first.height(), [&](int y) {
    for (int x = 0; x < first.width(); ++x) {
      const double r2 = radius2(camera, x, y);
      for (Image<float>& channel : planes.channel)
        channel(x, y) = static_cast<float>(curve(static_cast<double>(channel(x, y)), r2));
    }
  });
}

}  // namespace

double ViewExposures::gain_of(std::size_t view) const {
  return view < log_gain.size() && std::isfinite(log_gain[view]) ? log_gain[view] : 0;
}

void validate(const ExposureConfig& config) {
  check("stride_px", config.stride_px, 1, 1e6);
  check("depth_agreement", config.depth_agreement, 1e-9, 1);
  check("darkest", config.darkest, 1e-3, 1);
  check("brightest", config.brightest, config.darkest, 1);
  check("least_sightings", config.least_sightings, 1, 1e9);
}

ViewExposures estimate_exposures(std::span<const SplatView> views,
                                 std::span<const Image<float>> depths_m,
                                 const ExposureConfig& config) {
  validate(config);
  if (views.size() != depths_m.size())
    throw std::invalid_argument("exposures: " + std::to_string(depths_m.size()) +
                                " depth images for " + std::to_string(views.size()) + " views");
  for (std::size_t v = 0; v < views.size(); ++v) {
    const std::string name = "exposures: view " + std::to_string(v);
    check_sizes(views[v].full, name);
    if (!depths_m[v].empty()) check_size(views[v].full.camera, depths_m[v], name + ": depth");
  }
  if (views.size() < kLeastSharingViews) {
    ViewExposures none;
    none.log_gain.assign(views.size(), kNaN);
    none.sigma.assign(views.size(), kNaN);
    return none;
  }
  const SurfaceLight light(views, depths_m, config);
  std::vector<std::uint8_t> unsure(views.size(), 0);
  LightSightings sightings = all_sightings(light, unsure);
  for (std::size_t v = 0; v < views.size(); ++v)
    unsure[v] = sightings_of(sightings, v) < config.least_sightings ? 1 : 0;
  if (std::count(unsure.begin(), unsure.end(), 1) > 0) sightings = all_sightings(light, unsure);
  return fit_exposures(sightings, views.size(), config.least_sightings);
}

SplatViewLevel at_mean_exposure(SplatViewLevel level, double log_gain,
                                const Vignetting& vignetting) {
  for_colors(level.color, level.camera, [&](double value, double r2) {
    return encoded(light_of(value) * std::exp(-log_gain - vignetting.log_at(r2)));
  });
  return level;
}

ColorPlanes as_exposed(ColorPlanes image, const Camera& camera, double log_gain,
                       const Vignetting& vignetting) {
  for_colors(image, camera, [&](double value, double r2) {
    const double light =
        light_of(std::max(value, 0.0)) * std::exp(log_gain + vignetting.log_at(r2));
    return std::clamp(encoded(light), 0.0, 1.0);
  });
  return image;
}

}  // namespace cousin
