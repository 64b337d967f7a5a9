#include "sim/imaging/color.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cousin {
namespace {

std::array<float, 256> make_linear_table() {
  std::array<float, 256> table{};
  for (int code = 0; code < 256; ++code) {
    table[static_cast<std::size_t>(code)] = linear_from_srgb(static_cast<float>(code) / 255.0F);
  }
  return table;
}

const std::array<float, 256>& linear_table() {
  static const std::array<float, 256> table = make_linear_table();
  return table;
}

/// Codes by table instead of a power a pixel. Cell i of the table holds the code at its lower edge
/// and the linear value where the next code starts; cells are narrower than any code's interval, so
/// one comparison decides.
struct CodeTable {
  static constexpr int kCells =
      4096;  // the narrowest code interval is 1 / (255 * 12.92) = 1 / 3295
  std::array<std::uint8_t, kCells + 1> code{};
  std::array<float, kCells + 1> next_at{};

  static int exact(float linear) {
    return static_cast<int>(std::lround(srgb_from_linear(linear) * 255.0F));
  }

  /// Smallest linear value that rounds to `code` or above.
  static float threshold(int code) {
    if (code > 255) return 2.0F;
    float low = 0, high = 1;
    while (std::nextafter(low, high) < high) {
      const float middle = 0.5F * (low + high);
      (exact(middle) >= code ? high : low) = middle;
    }
    return high;
  }

  CodeTable() {
    std::array<float, 257> starts{};
    for (int c = 1; c <= 256; ++c) starts[static_cast<std::size_t>(c)] = threshold(c);
    for (std::size_t i = 0; i <= kCells; ++i) {
      code[i] = static_cast<std::uint8_t>(exact(static_cast<float>(i) / kCells));
      next_at[i] = starts[code[i] + std::size_t{1}];
    }
  }
};

}  // namespace

float srgb_from_linear(float linear) {
  if (!(linear > 0)) return 0;  // NaN too
  if (linear >= 1) return 1;
  return linear <= 0.0031308F ? 12.92F * linear : 1.055F * std::pow(linear, 1 / 2.4F) - 0.055F;
}

float linear_from_srgb(float srgb) {
  if (!(srgb > 0)) return 0;
  if (srgb >= 1) return 1;
  return srgb <= 0.04045F ? srgb / 12.92F : std::pow((srgb + 0.055F) / 1.055F, 2.4F);
}

std::uint8_t srgb8_from_linear(float linear) {
  static const CodeTable table;
  if (!(linear > 0)) return 0;
  if (linear >= 1) return 255;
  const auto cell = static_cast<std::size_t>(linear * CodeTable::kCells);
  return static_cast<std::uint8_t>(table.code[cell] + (linear >= table.next_at[cell] ? 1 : 0));
}

float linear_from_srgb8(std::uint8_t code) { return linear_table()[code]; }

Image<Rgbf> linear_from_srgb8(const Image<Rgb8>& image) {
  const std::array<float, 256>& table = linear_table();
  Image<Rgbf> out(image.width(), image.height());
  std::transform(image.begin(), image.end(), out.begin(), [&](const Rgb8& p) {
    return Rgbf{table[p.r], table[p.g], table[p.b]};
  });
  return out;
}

Image<float> luma(const Image<Rgb8>& image) {
  Image<float> out(image.width(), image.height());
  std::transform(image.begin(), image.end(), out.begin(), [](const Rgb8& p) {
    return 0.299F * static_cast<float>(p.r) + 0.587F * static_cast<float>(p.g) +
           0.114F * static_cast<float>(p.b);
  });
  return out;
}

}  // namespace cousin
