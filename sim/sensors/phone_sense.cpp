#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include "sim/imaging/color.h"
#include "sim/imaging/image_io.h"
#include "sim/sensors/fast_normal.h"
#include "sim/sensors/phone.h"

namespace cousin {
namespace {

// Automatic exposure, free: as phones do, it lets the brightest half per cent go and leaves a fifth
// of the full well to what a picture does not show. No phone's metering is documented.
constexpr double kAutoQuantile = 0.995;
constexpr double kAutoFullWellShare = 0.8;
/// Above, a normal distribution corrected for skewness stands for Poisson's.
constexpr float kExactPoissonBelow_e = 30;

/// Pixels are handled as rows of 3 * width floats: red, green, blue of each pixel in turn.
static_assert(sizeof(Rgbf) == 3 * sizeof(float) && sizeof(LinearCode) == 3 * sizeof(std::uint16_t));

const float* samples(const Image<Rgbf>& image, int y) { return &image.row(y).front().r; }
float* samples(Image<Rgbf>& image, int y) { return &image.row(y).front().r; }

void require_size(int width, int height, const PhoneConfig& config, const char* what) {
  if (width == config.width_px && height == config.height_px) return;
  throw std::invalid_argument("phone: " + std::string(what) + " is " + std::to_string(width) +
                              " x " + std::to_string(height) + ", the preset " +
                              std::to_string(config.width_px) + " x " +
                              std::to_string(config.height_px));
}

/// Normalised Gaussian weights from -radius to radius, cut at four sigmas.
std::vector<float> gaussian_weights(double sigma_px) {
  const int radius = static_cast<int>(std::ceil(4 * sigma_px));
  std::vector<double> weights;
  double sum = 0;
  for (int i = -radius; i <= radius; ++i) {
    weights.push_back(radius == 0 ? 1.0 : std::exp(-0.5 * i * i / (sigma_px * sigma_px)));
    sum += weights.back();
  }
  std::vector<float> normalised;
  for (const double w : weights) normalised.push_back(static_cast<float>(w / sum));
  return normalised;
}

/// Row y of radiance times vignetting, blurred along the row; borders repeat.
void shade_and_blur_row(const Image<Rgbf>& radiance, const PhoneConfig& config,
                        const Camera& camera, std::span<const float> weights, int y,
                        std::vector<float>& padded, Image<Rgbf>& out) {
  const int width = radiance.width();
  const int radius = static_cast<int>(weights.size() / 2);
  padded.resize(static_cast<std::size_t>(3 * (width + 2 * radius)));
  const double half_diagonal2 =
      0.25 * (std::pow(config.width_px, 2) + std::pow(config.height_px, 2));
  const auto per_half_diagonal2 = static_cast<float>(1 / half_diagonal2);
  const auto a = static_cast<float>(config.vignetting_a);
  const auto b = static_cast<float>(config.vignetting_b);
  const auto c = static_cast<float>(config.vignetting_c);
  const auto cx = static_cast<float>(camera.cx_px);
  const auto dy = static_cast<float>(y - camera.cy_px);
  const float* in = samples(radiance, y);
  float* middle = padded.data() + 3 * radius;
  for (int x = 0; x < width; ++x) {
    const float dx = static_cast<float>(x) - cx;
    const float r2 = (dx * dx + dy * dy) * per_half_diagonal2;
    const float gain = 1 + r2 * (a + r2 * (b + r2 * c));
    for (int k = 0; k < 3; ++k) middle[3 * x + k] = in[3 * x + k] * gain;
  }
  for (int x = 0; x < radius; ++x) {
    for (int k = 0; k < 3; ++k) {
      padded[static_cast<std::size_t>(3 * x + k)] = middle[k];
      middle[3 * (width + x) + k] = middle[3 * (width - 1) + k];
    }
  }
  float* result = samples(out, y);
  std::fill(result, result + 3 * width, 0.0F);
  for (std::size_t t = 0; t < weights.size(); ++t) {
    const float weight = weights[t];
    const float* from = padded.data() + 3 * t;
    for (int i = 0; i < 3 * width; ++i) result[i] += weight * from[i];
  }
}

/// Sum of rows around y with the weights; borders repeat.
void blur_column(const Image<Rgbf>& image, std::span<const float> weights, int y,
                 std::vector<float>& out) {
  const int radius = static_cast<int>(weights.size() / 2);
  out.assign(static_cast<std::size_t>(3 * image.width()), 0.0F);
  for (int t = -radius; t <= radius; ++t) {
    const float* row = samples(image, std::clamp(y + t, 0, image.height() - 1));
    const float weight = weights[static_cast<std::size_t>(t + radius)];
    for (std::size_t i = 0; i < out.size(); ++i) out[i] += weight * row[i];
  }
}

/// From light to codes: what one row of photosites makes of its signal.
struct Exposure {
  float electrons;      ///< at unit signal
  float read_variance;  ///< e^2
  float full_well;      ///< e
  float codes_per_e;
};

/// Codes of a row of signals (radiance after the lens). Draws from `rng` in order of the samples.
void expose_row(std::span<const float> signal, const float* prnu, const float* dsnu,
                const Exposure& exposure, Rng rng, std::uint16_t* codes) {
  const NormalTable& table = normal_table();
  const float max_code = exposure.full_well * exposure.codes_per_e;
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < signal.size(); ++i) {
    bits = i % 2 == 0 ? rng() : bits >> 32;
    const float z = table(static_cast<std::uint32_t>(bits));
    float mean = std::max(0.0F, signal[i] * exposure.electrons * prnu[i]);
    float electrons;
    if (mean < kExactPoissonBelow_e) {
      mean = static_cast<float>(poisson(rng, mean));
      electrons = mean + std::sqrt(exposure.read_variance) * z;
    } else {
      // Cornish-Fisher: the skewness of the sum is the Poisson's alone. The term's own variance, 2
      // s^2, is taken from the normal part.
      const float variance = mean + exposure.read_variance;
      const float skew = mean / (6 * variance);
      electrons = mean + std::sqrt(variance - 2 * skew * skew) * z + skew * (z * z - 1);
    }
    const float code = (electrons + dsnu[i]) * exposure.codes_per_e;
    codes[i] = static_cast<std::uint16_t>(std::clamp(code, 0.0F, max_code) + 0.5F);
  }
}

void require_finite(const Image<Rgbf>& radiance, int y) {
  const float* row = samples(radiance, y);
  float sum = 0;
  for (int i = 0; i < 3 * radiance.width(); ++i)
    sum += row[i] * 0;  // 0 unless a sample is NaN or infinite
  if (sum == 0) return;
  throw std::invalid_argument("phone: radiance in row " + std::to_string(y) + " is not finite");
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
  if (brightest.empty()) throw std::invalid_argument("phone: the radiance image is empty");
  const auto rank =
      static_cast<std::ptrdiff_t>(kAutoQuantile * static_cast<double>(brightest.size() - 1));
  std::nth_element(brightest.begin(), brightest.begin() + rank, brightest.end());
  const double quantile = brightest[static_cast<std::size_t>(rank)];
  // A black image is exposed as if unit radiance were the brightest.
  return kAutoFullWellShare * config.full_well_e / (quantile > 1e-9 ? quantile : 1.0);
}

Image<LinearCode> expose(const Image<Rgbf>& radiance, const PhoneConfig& config,
                         const PhoneUnit& unit, const TrueView& view, Rng rng) {
  require_size(radiance.width(), radiance.height(), config, "radiance");
  require_size(unit.prnu_gain.width(), unit.prnu_gain.height(), config, "the unit's fixed pattern");
  require_size(unit.dsnu_e.width(), unit.dsnu_e.height(), config, "the unit's fixed pattern");
  const int width = config.width_px;
  const int height = config.height_px;
  const std::vector<float> weights = gaussian_weights(config.blur_sigma_px);

  Image<Rgbf> shaded(width, height);
  tbb::parallel_for(
      tbb::blocked_range<int>(0, height, 16), [&](const tbb::blocked_range<int>& rows) {
        std::vector<float> padded;
        for (int y = rows.begin(); y < rows.end(); ++y) {
          require_finite(radiance, y);
          shade_and_blur_row(radiance, config, view.camera, weights, y, padded, shaded);
        }
      });

  Exposure exposure{};
  exposure.electrons = static_cast<float>(electrons_per_radiance(config, radiance));
  exposure.read_variance = static_cast<float>(config.read_noise_e * config.read_noise_e);
  exposure.full_well = static_cast<float>(config.full_well_e);
  exposure.codes_per_e = static_cast<float>(((1 << config.bits) - 1) / config.full_well_e);

  Image<LinearCode> codes(width, height);
  tbb::parallel_for(
      tbb::blocked_range<int>(0, height, 16), [&](const tbb::blocked_range<int>& rows) {
        std::vector<float> signal;
        for (int y = rows.begin(); y < rows.end(); ++y) {
          blur_column(shaded, weights, y, signal);
          expose_row(signal, samples(unit.prnu_gain, y), samples(unit.dsnu_e, y), exposure,
                     rng.fork(static_cast<std::uint64_t>(y)), &codes.row(y).front().r);
        }
      });
  return codes;
}

Camera reported_camera(const PhoneConfig& config, const PhoneUnit& unit, const TrueView& view,
                       const Rng& rng) {
  // The device knows its focus through the lens position, with an error of its own.
  Camera reported = unit.reported_at_infinity;
  const double breathing = view.camera.fx_px / unit.camera_at_infinity.fx_px;
  if (breathing > 1) {
    Rng focus = rng.fork("reported_focus");
    const double distance_m = config.focal_m * (1 + 1 / (breathing - 1));
    const double reported_m =
        std::max(distance_m * (1 + truncated_normal(focus, 0, config.report_focus_error)),
                 3 * config.focal_m);
    const double reported_breathing = focus_breathing(config.focal_m, reported_m);
    reported.fx_px *= reported_breathing;
    reported.fy_px *= reported_breathing;
  }
  return reported;
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
