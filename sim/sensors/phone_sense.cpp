#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "sim/imaging/color.h"
#include "sim/imaging/image_io.h"
#include "sim/sensors/optics.h"
#include "sim/sensors/phone.h"
#include "sim/sensors/photosites.h"

namespace cousin {
namespace {

/// Pixels are handled as rows of 3 * width floats: red, green, blue of each pixel in turn.
static_assert(sizeof(Rgbf) == 3 * sizeof(float) && sizeof(LinearCode) == 3 * sizeof(std::uint16_t));

const float* row_samples(const Image<Rgbf>& image, int y) { return &image.row(y).front().r; }

void require_size(int width, int height, const PhoneConfig& config, const char* what) {
  if (width == config.width_px && height == config.height_px) return;
  throw std::invalid_argument("phone: " + std::string(what) + " is " + std::to_string(width) +
                              " x " + std::to_string(height) + ", the preset " +
                              std::to_string(config.width_px) + " x " +
                              std::to_string(config.height_px));
}

Optics optics_of(const PhoneConfig& config) {
  return {.vignetting_a = config.vignetting_a,
          .vignetting_b = config.vignetting_b,
          .vignetting_c = config.vignetting_c,
          .red = {},
          .blue = {},
          .blur_sigma_px = config.blur_sigma_px};
}

std::vector<std::uint8_t> srgb8_of_codes(int bits) {
  const int count = 1 << bits;
  std::vector<std::uint8_t> table(static_cast<std::size_t>(count));
  for (int code = 0; code < count; ++code) {
    table[static_cast<std::size_t>(code)] =
        srgb8_from_linear(static_cast<float>(code) / static_cast<float>(count - 1));
  }
  return table;
}

}  // namespace

double electrons_per_radiance(const PhoneConfig& config, const Image<Rgbf>& radiance) {
  if (config.electrons_at_unit_radiance > 0) return config.electrons_at_unit_radiance;
  // Every second pixel of every second row is plenty for a quantile.
  std::vector<float> brightest;
  brightest.reserve(radiance.size() / 4 + 1);
  for (int y = 0; y < radiance.height(); y += 2) {
    const auto row = radiance.row(y);
    for (std::size_t x = 0; x < row.size(); x += 2)
      brightest.push_back(std::max({row[x].r, row[x].g, row[x].b}));
  }
  return auto_exposure_electrons(std::move(brightest), config.full_well_e);
}

Image<LinearCode> expose(const Image<Rgbf>& radiance, const PhoneConfig& config,
                         const PhoneUnit& unit, const TrueView& view, Rng rng) {
  require_size(radiance.width(), radiance.height(), config, "radiance");
  require_size(unit.prnu_gain.width(), unit.prnu_gain.height(), config, "the unit's fixed pattern");
  require_size(unit.dsnu_e.width(), unit.dsnu_e.height(), config, "the unit's fixed pattern");
  const int width = config.width_px;
  const int height = config.height_px;
  const Optics optics = optics_of(config);
  const std::vector<float> weights = gaussian_weights(optics.blur_sigma_px);
  const Image<Rgbf> shaded = shade_and_blur_rows(radiance, optics, view.camera, weights, "phone");

  Exposure exposure;
  exposure.electrons = static_cast<float>(electrons_per_radiance(config, radiance));
  exposure.read_variance = static_cast<float>(config.read_noise_e * config.read_noise_e);
  exposure.codes_per_e = static_cast<float>(((1 << config.bits) - 1) / config.full_well_e);
  exposure.max_code = static_cast<float>(config.full_well_e) * exposure.codes_per_e;

  Image<LinearCode> codes(width, height);
  tbb::parallel_for(
      tbb::blocked_range<int>(0, height, 16), [&](const tbb::blocked_range<int>& rows) {
        std::vector<float> signal;
        for (int y = rows.begin(); y < rows.end(); ++y) {
          blurred_row(shaded, weights, y, signal);
          expose_row(signal, row_samples(unit.prnu_gain, y), row_samples(unit.dsnu_e, y), exposure,
                     rng.fork(static_cast<std::uint64_t>(y)), &codes.row(y).front().r);
        }
      });
  return codes;
}

Camera reported_camera(const PhoneConfig& config, const PhoneUnit& unit, const TrueView& view,
                       const Rng& rng) {
  return report_at_focus({unit.camera_at_infinity, unit.reported_at_infinity}, view.camera,
                         config.focal_m, config.report_focus_error, rng);
}

SensorFrame sense(const Image<Rgbf>& radiance, const PhoneConfig& config, const PhoneUnit& unit,
                  const TrueView& view, Rng rng) {
  const Image<LinearCode> codes = expose(radiance, config, unit, view, rng);
  const std::vector<std::uint8_t> srgb = srgb8_of_codes(config.bits);

  SensorFrame frame;
  frame.color = Image<Rgb8>(config.width_px, config.height_px);
  tbb::parallel_for(tbb::blocked_range<int>(0, config.height_px, 32),
                    [&](const tbb::blocked_range<int>& rows) {
                      for (int y = rows.begin(); y < rows.end(); ++y) {
                        const auto from = codes.row(y);
                        const auto to = frame.color.row(y);
                        for (std::size_t x = 0; x < to.size(); ++x)
                          to[x] = {srgb[from[x].r], srgb[from[x].g], srgb[from[x].b]};
                      }
                    });
  if (config.jpeg_quality > 0)
    frame.color = decode_jpeg(encode_jpeg(frame.color, config.jpeg_quality));

  frame.reported = reported_camera(config, unit, view, rng);
  return frame;
}

double sensor_variance(const PhoneConfig& config, double radiance,
                       double electrons_at_unit_radiance) {
  const double electrons =
      std::min(std::max(radiance, 0.0) * electrons_at_unit_radiance, config.full_well_e);
  const double e_per_code = config.full_well_e / ((1 << config.bits) - 1);
  const double variance_e2 =
      electrons + config.read_noise_e * config.read_noise_e + e_per_code * e_per_code / 12;
  return variance_e2 / (electrons_at_unit_radiance * electrons_at_unit_radiance);
}

double sensor_variance(const PhoneConfig& config, double radiance) {
  const double electrons = config.electrons_at_unit_radiance > 0
                               ? config.electrons_at_unit_radiance
                               : kAutoFullWellShare * config.full_well_e;
  return sensor_variance(config, radiance, electrons);
}

}  // namespace cousin
