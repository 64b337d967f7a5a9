#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include "sim/sensors/active_stereo.h"
#include "sim/sensors/depth_model.h"

namespace cousin {
namespace {

/// Share of the mean projected light that counts as noise: most of it lies in the dots themselves.
/// Of 0, 0.1, 0.25, 0.5 and 1 it makes noise and fill of 36 walls most nearly functions of one
/// number.
constexpr float kNoiseOfDots = 0.25F;

/// Dots per solid angle times 2 pi sigma^2: a Gaussian dot is brighter than a share v of its peak
/// on an area of this times -log(v).
double dot_cover(const DotProjectorConfig& projector, double blur_rad) {
  const double variance = projector.dot_sigma_rad * projector.dot_sigma_rad + blur_rad * blur_rad;
  return 2 * std::numbers::pi * variance * projector.dots /
         (projector.view_x_rad * projector.view_y_rad);
}

/// Mean radiance of projected light; 0 where the projector does not reach.
float projected_radiance(const DepthModelInputs& in, const ActiveStereoConfig& config,
                         const Camera& camera, int x, int y) {
  const float z = in.depth_m(x, y);
  if (!config.has_projector || !(z > 0) || (in.hidden(x, y) & kHiddenFromProjector)) return 0;
  const Eigen::Vector3f p(z * (static_cast<float>(x) - static_cast<float>(camera.cx_px)) /
                              static_cast<float>(camera.fx_px),
                          z * (static_cast<float>(y) - static_cast<float>(camera.cy_px)) /
                              static_cast<float>(camera.fy_px),
                          z);
  const Eigen::Vector3f way = Eigen::Vector3f(static_cast<float>(config.projector_x_m), 0, 0) - p;
  const float half_x = static_cast<float>(std::tan(0.5 * config.projector.view_x_rad));
  const float half_y = static_cast<float>(std::tan(0.5 * config.projector.view_y_rad));
  if (std::abs(way.x()) > half_x * z || std::abs(way.y()) > half_y * z) return 0;
  const float squared = way.squaredNorm(), distance = std::sqrt(squared);
  const float cosine = std::max(0.0F, in.normal(x, y).dot(way) / distance);
  return in.albedo(x, y) * std::numbers::inv_pi_v<float> *
         static_cast<float>(config.projector.irradiance_at_1m) * cosine / squared;
}

/// A thinned image with dots as bright as the imager would see them, spread evenly over their
/// distribution of brightness.
Image<float> seen_through_dots(const Image<float>& ambient, const Image<float>& projected,
                               double cover, double background) {
  const int width = (ambient.width() + 3) / 4, height = (ambient.height() + 3) / 4;
  Image<float> bright(width, height);
  double u = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      u += std::numbers::phi - 1;
      if (u >= 1) u -= 1;
      const double dot = background + (1 - background) / cover * std::exp(-u / cover);
      bright(x, y) = ambient(4 * x, 4 * y) + static_cast<float>(dot) * projected(4 * x, 4 * y);
    }
  }
  return bright;
}

}  // namespace

void validate(const DepthModelInputs& in, const Camera& camera) {
  const auto fits = [&](const auto& image) {
    return image.width() == camera.width_px && image.height() == camera.height_px;
  };
  if (!fits(in.depth_m) || !fits(in.normal) || !fits(in.albedo) || !fits(in.ambient) ||
      !fits(in.hidden)) {
    throw std::invalid_argument("depth model: an input is not of " +
                                std::to_string(camera.width_px) + " x " +
                                std::to_string(camera.height_px) + " pixels");
  }
}

Image<std::uint8_t> stereo_occlusion(const Image<float>& depth_m,
                                     const ActiveStereoConfig& config) {
  const double focal_px = depth_camera(config).fx_px;
  Image<std::uint8_t> hidden(depth_m.width(), depth_m.height(), std::uint8_t{0});
  constexpr float kTolerance_px = 0.25F;  //  neighbours on a steep slope meet one pixel
  const auto mark = [&](int y, double x_m, std::uint8_t bit) {
    const int width = depth_m.width(), step = x_m >= 0 ? -1 : 1;
    const auto scale = static_cast<float>(focal_px * x_m);
    float nearest = std::numeric_limits<float>::infinity();
    for (int k = 0, x = step < 0 ? width - 1 : 0; k < width; ++k, x += step) {
      const float z = depth_m(x, y);
      if (!(z > 0)) continue;
      const float seen = -static_cast<float>(step) * (static_cast<float>(x) - scale / z);
      if (seen > nearest + kTolerance_px) hidden(x, y) |= bit;
      nearest = std::min(nearest, seen);
    }
  };
  tbb::parallel_for(0, depth_m.height(), [&](int y) {
    mark(y, config.baseline_m, kHiddenFromRight);
    if (config.has_projector) mark(y, config.projector_x_m, kHiddenFromProjector);
  });
  return hidden;
}

PatternLight pattern_light(const DepthModelInputs& inputs, const ActiveStereoConfig& config) {
  const Camera camera = depth_camera(config);
  validate(inputs, camera);
  const InfraredImagerConfig& imager = config.imager;
  const int width = camera.width_px, height = camera.height_px;
  Image<float> projected(width, height);
  tbb::parallel_for(0, height, [&](int y) {
    for (int x = 0; x < width; ++x)
      projected(x, y) = projected_radiance(inputs, config, camera, x, y);
  });
  const InfraredExposure exposure = auto_exposure(
      seen_through_dots(inputs.ambient, projected,
                        dot_cover(config.projector, imager.blur_sigma_px / camera.fx_px),
                        config.projector.background),
      imager);
  const double e_per_code = imager.full_well_e / (exposure.gain * ((1 << imager.bits) - 1));
  PatternLight light;
  light.still_e2 = imager.read_noise_e * imager.read_noise_e + e_per_code * e_per_code / 12;
  light.margin_e = config.match.margin * e_per_code;
  light.signal_e = light.light_e = Image<float>(width, height);
  const auto electrons = static_cast<float>(imager.electrons_at_unit_radiance * exposure.share);
  const auto texture = static_cast<float>(inputs.texture);
  tbb::parallel_for(0, height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      const float own = texture * inputs.ambient(x, y), p = projected(x, y);
      light.signal_e(x, y) = electrons * std::sqrt(p * p + own * own);
      light.light_e(x, y) = electrons * (kNoiseOfDots * p + inputs.ambient(x, y));
    }
  });
  return light;
}

Image<float> pattern_snr(const PatternLight& light, double margin_weight) {
  Image<float> snr(light.signal_e.width(), light.signal_e.height());
  const auto still =
      static_cast<float>(light.still_e2 + margin_weight * light.margin_e * light.margin_e);
  std::transform(light.signal_e.begin(), light.signal_e.end(), light.light_e.begin(), snr.begin(),
                 [&](float s, float all) { return s > 0 ? s / std::sqrt(all + still) : 0.0F; });
  return snr;
}

}  // namespace cousin
