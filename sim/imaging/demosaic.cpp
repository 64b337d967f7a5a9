#include "sim/imaging/demosaic.h"

#include <tbb/parallel_for.h>

#include <array>
#include <stdexcept>
#include <string>
#include <utility>

namespace cousin {
namespace {

constexpr std::array<std::pair<Demosaic, std::string_view>, 2> kNames = {
    {{Demosaic::bilinear, "bilinear"}, {Demosaic::malvar_he_cutler, "malvar_he_cutler"}}};

/// Place of a sample up to two pixels outside, mirrored about the border pixel: parity is kept.
int mirrored(int i, int size) { return i < 0 ? -i : i >= size ? 2 * (size - 1) - i : i; }

/// The 5 x 5 neighbourhood of a pixel.
struct Around {
  std::array<const float*, 5> row;
  std::array<int, 5> column;
  float operator()(int dx, int dy) const {
    return row[static_cast<std::size_t>(dy + 2)][column[static_cast<std::size_t>(dx + 2)]];
  }
};

float beside(const Around& p) { return p(-1, 0) + p(1, 0); }
float above(const Around& p) { return p(0, -1) + p(0, 1); }
float diagonal(const Around& p) { return p(-1, -1) + p(1, -1) + p(-1, 1) + p(1, 1); }
float far_beside(const Around& p) { return p(-2, 0) + p(2, 0); }
float far_above(const Around& p) { return p(0, -2) + p(0, 2); }

// The four filters of Malvar, He & Cutler, figure 2.
float green_at_other(const Around& p) {
  return (4 * p(0, 0) + 2 * (beside(p) + above(p)) - far_beside(p) - far_above(p)) / 8;
}
float other_beside_green(const Around& p) {
  return (5 * p(0, 0) + 4 * beside(p) - diagonal(p) - far_beside(p) + 0.5F * far_above(p)) / 8;
}
float other_above_green(const Around& p) {
  return (5 * p(0, 0) + 4 * above(p) - diagonal(p) - far_above(p) + 0.5F * far_beside(p)) / 8;
}
float red_at_blue(const Around& p) {
  return (6 * p(0, 0) + 2 * diagonal(p) - 1.5F * (far_beside(p) + far_above(p))) / 8;
}

Rgbf malvar(const Around& p, int channel, int beside_channel) {
  const float own = p(0, 0);
  if (channel == 0) return {own, green_at_other(p), red_at_blue(p)};
  if (channel == 2) return {red_at_blue(p), green_at_other(p), own};
  if (beside_channel == 0) return {other_beside_green(p), own, other_above_green(p)};
  return {other_above_green(p), own, other_beside_green(p)};
}

Rgbf bilinear(const Around& p, int channel, int beside_channel) {
  const float own = p(0, 0);
  const float cross = (beside(p) + above(p)) / 4;
  if (channel == 0) return {own, cross, diagonal(p) / 4};
  if (channel == 2) return {diagonal(p) / 4, cross, own};
  if (beside_channel == 0) return {beside(p) / 2, own, above(p) / 2};
  return {above(p) / 2, own, beside(p) / 2};
}

}  // namespace

std::string_view to_string(Demosaic method) {
  return kNames.at(static_cast<std::size_t>(method)).second;
}

Demosaic demosaic_from_string(std::string_view text) {
  std::string names;
  for (const auto& [method, name] : kNames) {
    if (name == text) return method;
    names += (names.empty() ? "" : ", ") + std::string(name);
  }
  throw std::invalid_argument("demosaic \"" + std::string(text) + "\" is not one of " + names);
}

Image<Rgbf> demosaic(const Image<float>& samples, Mosaic mosaic, Demosaic method) {
  const int width = samples.width(), height = samples.height();
  if (width < 3 || height < 3) {
    throw std::invalid_argument("demosaic: the image is " + std::to_string(width) + " x " +
                                std::to_string(height) + " px; it must be at least 3 x 3");
  }
  Image<Rgbf> result(width, height);
  tbb::parallel_for(0, height, [&](int y) {
    const auto out = result.row(y);
    if (mosaic == Mosaic::grey) {
      const auto in = samples.row(y);
      for (std::size_t x = 0; x < out.size(); ++x) out[x] = {in[x], in[x], in[x]};
      return;
    }
    Around around{};
    for (int k = 0; k < 5; ++k) {
      around.row[static_cast<std::size_t>(k)] = samples.row(mirrored(y + k - 2, height)).data();
    }
    for (int x = 0; x < width; ++x) {
      for (int k = 0; k < 5; ++k) {
        around.column[static_cast<std::size_t>(k)] = mirrored(x + k - 2, width);
      }
      const int channel = bayer_channel(mosaic, x, y);
      const int next = bayer_channel(mosaic, x + 1, y);
      out[static_cast<std::size_t>(x)] = method == Demosaic::malvar_he_cutler
                                             ? malvar(around, channel, next)
                                             : bilinear(around, channel, next);
    }
  });
  return result;
}

}  // namespace cousin
