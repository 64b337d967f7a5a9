#include "perception/segment/green.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/config/limits.h"

namespace cousin {
namespace {

/// Fixed-point reciprocals of OpenCV's 8-bit conversion [imgproc/src/color_hsv, RGB2HSV_b]: 12
/// fractional bits, rounded to nearest even.
constexpr int kShift = 12;
struct Reciprocals {
  std::array<int, 256> saturation{};  ///< 255 / value
  std::array<int, 256> hue{};         ///< 30 / chroma
  Reciprocals() {
    for (int i = 1; i < 256; ++i) {
      const auto index = static_cast<std::size_t>(i);
      saturation[index] = static_cast<int>(std::lrint((255 << kShift) / (1.0 * i)));
      hue[index] = static_cast<int>(std::lrint((180 << kShift) / (6.0 * i)));
    }
  }
};

const Reciprocals& reciprocals() {
  static const Reciprocals table;
  return table;
}

bool inside(const Hsv8& c, const GreenConfig& box) {
  return c.hue >= box.hue_low && c.hue <= box.hue_high && c.saturation >= box.saturation_low &&
         c.saturation <= box.saturation_high && c.value >= box.value_low &&
         c.value <= box.value_high;
}

}  // namespace

Fields fields(GreenConfig& c) {
  return {{"hue_low", &c.hue_low, "lowest hue of the screen, half degrees", 0, 180},
          {"saturation_low", &c.saturation_low, "lowest saturation of the screen", 0, 255},
          {"value_low", &c.value_low, "lowest value of the screen", 0, 255},
          {"hue_high", &c.hue_high, "highest hue of the screen, half degrees", 0, 180},
          {"saturation_high", &c.saturation_high, "highest saturation of the screen", 0, 255},
          {"value_high", &c.value_high, "highest value of the screen", 0, 255}};
}

void validate(const GreenConfig& config) {
  GreenConfig copy = config;
  check_limits(fields(copy), "green");
}

Hsv8 hsv8(Rgb8 color) {
  const Reciprocals& table = reciprocals();
  constexpr int kHalf = 1 << (kShift - 1);
  const int r = color.r, g = color.g, b = color.b;
  const int value = std::max({r, g, b});
  const int chroma = value - std::min({r, g, b});
  int hue = value == r ? g - b : value == g ? b - r + 2 * chroma : r - g + 4 * chroma;
  hue = (hue * table.hue[static_cast<std::size_t>(chroma)] + kHalf) >> kShift;
  if (hue < 0) hue += 180;
  const int saturation =
      (chroma * table.saturation[static_cast<std::size_t>(value)] + kHalf) >> kShift;
  return {static_cast<std::uint8_t>(hue), static_cast<std::uint8_t>(saturation),
          static_cast<std::uint8_t>(value)};
}

bool is_green(Rgb8 color, const GreenConfig& config) { return inside(hsv8(color), config); }

Image<std::uint8_t> remove_green(const Image<Rgb8>& image, const GreenConfig& config) {
  validate(config);
  Image<std::uint8_t> kept(image.width(), image.height());
  std::transform(image.begin(), image.end(), kept.begin(), [&](Rgb8 color) {
    return static_cast<std::uint8_t>(is_green(color, config) ? 0 : 255);
  });
  return kept;
}

Image<std::uint8_t> without_specks(const Image<std::uint8_t>& kept) {
  // An opening of what was removed: squares that are green, and what they cover.
  const auto each_near = [&](int x, int y, const auto& visit) {
    for (int v = std::max(0, y - 1); v <= std::min(kept.height() - 1, y + 1); ++v) {
      for (int u = std::max(0, x - 1); u <= std::min(kept.width() - 1, x + 1); ++u) visit(u, v);
    }
  };
  Image<std::uint8_t> filled(kept.width(), kept.height(), 255);
  for (int y = 0; y < kept.height(); ++y) {
    for (int x = 0; x < kept.width(); ++x) {
      if (kept(x, y) != 0) continue;
      bool is_square = true;
      each_near(x, y, [&](int u, int v) { is_square = is_square && kept(u, v) == 0; });
      if (is_square) each_near(x, y, [&](int u, int v) { filled(u, v) = 0; });
    }
  }
  return filled;
}

}  // namespace cousin
