#include "benchmarks/report/drawn_number.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace cousin {
namespace {

/// Digits of 3 by 5 dots, a bit each, rows from above.
constexpr std::array<std::array<int, 5>, 10> kDigits = {{{7, 5, 5, 5, 7},
                                                         {2, 6, 2, 2, 7},
                                                         {7, 1, 7, 4, 7},
                                                         {7, 1, 7, 1, 7},
                                                         {5, 5, 7, 1, 1},
                                                         {7, 4, 7, 1, 7},
                                                         {7, 4, 7, 5, 7},
                                                         {7, 1, 1, 2, 2},
                                                         {7, 5, 7, 5, 7},
                                                         {7, 5, 7, 1, 7}}};

}  // namespace

void write_number(Image<Rgb8>& image, int number, const Eigen::Vector2d& at_px, int dot_px) {
  const std::string text = std::to_string(std::max(0, number));
  const int width = dot_px * (4 * static_cast<int>(text.size()) + 1), height = dot_px * 7;
  const int x0 = static_cast<int>(std::lround(at_px.x())) - width / 2,
            y0 = static_cast<int>(std::lround(at_px.y())) - height / 2;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (!image.contains(x0 + x, y0 + y)) continue;
      const int column = x / dot_px - 1, row = y / dot_px - 1;
      const bool is_inside = column >= 0 && column % 4 < 3 && row >= 0 && row < 5;
      const auto digit =
          static_cast<std::size_t>(text[static_cast<std::size_t>(std::max(0, column) / 4)] - '0');
      const bool is_dot =
          is_inside && (kDigits[digit][static_cast<std::size_t>(row)] >> (2 - column % 4) & 1) != 0;
      image(x0 + x, y0 + y) = is_dot ? Rgb8{255, 255, 255} : Rgb8{0, 0, 0};
    }
  }
}

}  // namespace cousin
