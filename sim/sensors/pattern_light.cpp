#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include "sim/sensors/active_stereo.h"
#include "sim/sensors/depth_model.h"
#include "sim/sensors/row_occlusion.h"

namespace cousin {
namespace {

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

double dot_cover(const DotProjectorConfig& projector, double blur_rad) {
  const double variance = projector.dot_sigma_rad * projector.dot_sigma_rad + blur_rad * blur_rad;
  const double plane =
      4 * std::tan(0.5 * projector.view_x_rad) * std::tan(0.5 * projector.view_y_rad);
  return 2 * std::numbers::pi * variance * projector.dots / plane;
}

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
  Image<std::uint8_t> hidden = hidden_along_rows(depth_m, focal_px, config.baseline_m);
  static_assert(kHiddenFromRight == 1);
  if (!config.has_projector) return hidden;
  const auto from_projector = hidden_along_rows(depth_m, focal_px, config.projector_x_m);
  std::transform(hidden.begin(), hidden.end(), from_projector.begin(), hidden.begin(),
                 [](std::uint8_t right, std::uint8_t projector) {
                   return static_cast<std::uint8_t>(right | projector * kHiddenFromProjector);
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
  light.signal_e = light.dots_e = light.ambient_e = Image<float>(width, height);
  const auto electrons = static_cast<float>(imager.electrons_at_unit_radiance * exposure.share);
  const auto texture = static_cast<float>(inputs.texture);
  tbb::parallel_for(0, height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      const float own = texture * inputs.ambient(x, y), p = projected(x, y);
      light.signal_e(x, y) = electrons * std::sqrt(p * p + own * own);
      light.dots_e(x, y) = electrons * p;
      light.ambient_e(x, y) = electrons * inputs.ambient(x, y);
    }
  });
  return light;
}

float log2_pattern_snr(float signal_e, float dots_e, float ambient_e, const PatternLight& light,
                       const PatternNoise& noise) {
  if (!(signal_e > 0)) return -std::numeric_limits<float>::infinity();
  const auto still =
      static_cast<float>(light.still_e2 + noise.margin * light.margin_e * light.margin_e);
  const float variance = static_cast<float>(noise.dots) * dots_e + ambient_e + still;
  return 0.5F * std::log2(signal_e * signal_e / variance);
}

Image<float> log2_pattern_snr(const PatternLight& light, const PatternNoise& noise) {
  Image<float> snr(light.signal_e.width(), light.signal_e.height());
  tbb::parallel_for(0, snr.height(), [&](int y) {
    for (int x = 0; x < snr.width(); ++x) {
      snr(x, y) = log2_pattern_snr(light.signal_e(x, y), light.dots_e(x, y), light.ambient_e(x, y),
                                   light, noise);
    }
  });
  return snr;
}

}  // namespace cousin
