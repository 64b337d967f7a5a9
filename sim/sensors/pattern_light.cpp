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

/// Over pixels of one surface: their depths differ by less than a twentieth.
Image<float> signal_rise(const Image<float>& signal_e, const Image<float>& depth_m) {
  constexpr int kApart_px = 4;
  constexpr float kSame = 0.05F;
  const int width = signal_e.width(), height = signal_e.height();
  Image<float> rise(width, height, 0.0F);
  const auto along = [&](int x0, int y0, int x1, int y1, float z) {
    const float before = signal_e(x0, y0), after = signal_e(x1, y1);
    const bool is_one =
        std::abs(depth_m(x0, y0) - z) < kSame * z && std::abs(depth_m(x1, y1) - z) < kSame * z;
    const int steps = x1 - x0 + y1 - y0;
    if (!is_one || !(before > 0) || !(after > 0) || steps == 0) return 0.0F;
    return std::log2(after / before) / static_cast<float>(steps);
  };
  tbb::parallel_for(0, height, [&](int y) {
    const int above = std::max(y - kApart_px, 0), below = std::min(y + kApart_px, height - 1);
    for (int x = 0; x < width; ++x) {
      const float z = depth_m(x, y);
      if (!(signal_e(x, y) > 0)) continue;
      const int left = std::max(x - kApart_px, 0), right = std::min(x + kApart_px, width - 1);
      rise(x, y) = std::hypot(along(left, y, right, y, z), along(x, above, x, below, z));
    }
  });
  return rise;
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
  light.signal_e = light.ambient_e = Image<float>(width, height);
  const auto electrons = static_cast<float>(imager.electrons_at_unit_radiance * exposure.share);
  const auto texture = static_cast<float>(inputs.texture);
  tbb::parallel_for(0, height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      const float own = texture * inputs.ambient(x, y), p = projected(x, y);
      light.signal_e(x, y) = electrons * std::sqrt(p * p + own * own);
      light.ambient_e(x, y) = electrons * inputs.ambient(x, y);
    }
  });
  light.rise = signal_rise(light.signal_e, inputs.depth_m);
  return light;
}

float signal_in_reach(float signal_e, float rise, float reach_px) {
  return signal_e * std::exp2(std::min(reach_px * rise, 2.0F));
}

}  // namespace cousin
