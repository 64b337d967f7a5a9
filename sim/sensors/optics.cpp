#include "sim/sensors/optics.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace cousin {
namespace {

/// Pixels are handled as rows of 3 * width floats: red, green, blue of each pixel in turn.
static_assert(sizeof(Rgbf) == 3 * sizeof(float));

const float* samples(const Image<Rgbf>& image, int y) { return &image.row(y).front().r; }
float* samples(Image<Rgbf>& image, int y) { return &image.row(y).front().r; }

double half_diagonal2(const Camera& camera) {
  return 0.25 * (std::pow(camera.width_px, 2) + std::pow(camera.height_px, 2));
}

void require_finite(const Image<Rgbf>& radiance, int y, const std::string& name) {
  const float* row = samples(radiance, y);
  float sum = 0;
  for (int i = 0; i < 3 * radiance.width(); ++i)
    sum += row[i] * 0;  // 0 unless a sample is NaN or infinite
  if (sum == 0) return;
  throw std::invalid_argument(name + ": radiance in row " + std::to_string(y) + " is not finite");
}

/// The radius over the half diagonal, as a share of `r`, that a colour images at `r`: the inverse
/// of r (scale + cubic r^2) by Newton's method, which for maps this close to 1 needs two steps.
double inverse_share(const RadialColour& map, double r2) {
  if (map.cubic == 0) return 1 / map.scale;
  double share = 1 / (map.scale + map.cubic * r2);
  for (int i = 0; i < 3; ++i) {
    const double s2 = share * share;
    share -=
        (share * (map.scale + map.cubic * r2 * s2) - 1) / (map.scale + 3 * map.cubic * r2 * s2);
  }
  return share;
}

struct Taps {
  std::array<int, 4> at{};
  std::array<float, 4> weight{};
};

/// Catmull-Rom; a sample outside repeats the border's.
Taps taps(double x, int size) {
  const double inside = std::clamp(x, -1.0, static_cast<double>(size));
  const double base = std::floor(inside);
  const auto t = static_cast<float>(inside - base);
  Taps result;
  for (int k = 0; k < 4; ++k) {
    result.at[static_cast<std::size_t>(k)] =
        std::clamp(static_cast<int>(base) + k - 1, 0, size - 1);
  }
  result.weight = {((-0.5F * t + 1) * t - 0.5F) * t, (1.5F * t - 2.5F) * t * t + 1,
                   ((-1.5F * t + 2) * t + 0.5F) * t, (0.5F * t - 0.5F) * t * t};
  return result;
}

/// One channel (0 red, 2 blue) of row y as its radial map has it, into every third sample of `out`.
void resample_channel(const Image<Rgbf>& image, const RadialColour& map, const Camera& camera,
                      int y, int channel, float* out) {
  const double per_half_diagonal2 = 1 / half_diagonal2(camera);
  const double dy = y - camera.cy_px;
  for (int x = 0; x < image.width(); ++x) {
    const double dx = x - camera.cx_px;
    const double share = inverse_share(map, (dx * dx + dy * dy) * per_half_diagonal2);
    const Taps h = taps(camera.cx_px + share * dx, image.width());
    const Taps v = taps(camera.cy_px + share * dy, image.height());
    float sum = 0;
    for (std::size_t j = 0; j < 4; ++j) {
      const float* row = samples(image, v.at[j]) + channel;
      float line = 0;
      for (std::size_t i = 0; i < 4; ++i) line += h.weight[i] * row[3 * h.at[i]];
      sum += v.weight[j] * line;
    }
    out[3 * x + channel] = std::max(0.0F, sum);
  }
}

/// Row y times vignetting, blurred along the row; borders repeat.
void shade_and_blur_row(const float* in, const Optics& optics, const Camera& camera,
                        std::span<const float> weights, int y, std::vector<float>& padded,
                        Image<Rgbf>& out) {
  const int width = out.width();
  const int radius = static_cast<int>(weights.size() / 2);
  padded.resize(static_cast<std::size_t>(3 * (width + 2 * radius)));
  const auto per_half_diagonal2 = static_cast<float>(1 / half_diagonal2(camera));
  const auto a = static_cast<float>(optics.vignetting_a);
  const auto b = static_cast<float>(optics.vignetting_b);
  const auto c = static_cast<float>(optics.vignetting_c);
  const auto cx = static_cast<float>(camera.cx_px);
  const auto dy = static_cast<float>(y - camera.cy_px);
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

}  // namespace

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

Image<Rgbf> shade_and_blur_rows(const Image<Rgbf>& radiance, const Optics& optics,
                                const Camera& camera, std::span<const float> weights,
                                const std::string& name) {
  Image<Rgbf> shaded(radiance.width(), radiance.height());
  const bool moves_red = optics.red != RadialColour{};
  const bool moves_blue = optics.blue != RadialColour{};
  tbb::parallel_for(tbb::blocked_range<int>(0, radiance.height(), 16),
                    [&](const tbb::blocked_range<int>& rows) {
                      std::vector<float> padded, coloured;
                      for (int y = rows.begin(); y < rows.end(); ++y) {
                        require_finite(radiance, y, name);
                        const float* in = samples(radiance, y);
                        if (moves_red || moves_blue) {
                          coloured.assign(in, in + 3 * radiance.width());
                          if (moves_red)
                            resample_channel(radiance, optics.red, camera, y, 0, coloured.data());
                          if (moves_blue)
                            resample_channel(radiance, optics.blue, camera, y, 2, coloured.data());
                          in = coloured.data();
                        }
                        shade_and_blur_row(in, optics, camera, weights, y, padded, shaded);
                      }
                    });
  return shaded;
}

void blurred_row(const Image<Rgbf>& image, std::span<const float> weights, int y,
                 std::vector<float>& out) {
  const int radius = static_cast<int>(weights.size() / 2);
  out.assign(static_cast<std::size_t>(3 * image.width()), 0.0F);
  for (int t = -radius; t <= radius; ++t) {
    const float* row = samples(image, std::clamp(y + t, 0, image.height() - 1));
    const float weight = weights[static_cast<std::size_t>(t + radius)];
    for (std::size_t i = 0; i < out.size(); ++i) out[i] += weight * row[i];
  }
}

double vignetting_gain(const Optics& optics, const Camera& camera, double x_px, double y_px) {
  const double dx = x_px - camera.cx_px, dy = y_px - camera.cy_px;
  const double r2 = (dx * dx + dy * dy) / half_diagonal2(camera);
  return 1 + r2 * (optics.vignetting_a + r2 * (optics.vignetting_b + r2 * optics.vignetting_c));
}

}  // namespace cousin
