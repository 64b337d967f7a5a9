#include "sim/types/mosaic.h"

#include <array>
#include <stdexcept>
#include <string>

namespace cousin {
namespace {

struct Pattern {
  Mosaic mosaic;
  std::string_view name;
  std::array<int, 4> channel;  ///< of pixels (0, 0) (1, 0) (0, 1) (1, 1)
};
constexpr std::array<Pattern, 5> kPatterns = {{{Mosaic::grey, "grey", {1, 1, 1, 1}},
                                               {Mosaic::rggb, "rggb", {0, 1, 1, 2}},
                                               {Mosaic::bggr, "bggr", {2, 1, 1, 0}},
                                               {Mosaic::grbg, "grbg", {1, 0, 2, 1}},
                                               {Mosaic::gbrg, "gbrg", {1, 2, 0, 1}}}};

const Pattern& entry(Mosaic mosaic) { return kPatterns.at(static_cast<std::size_t>(mosaic)); }

}  // namespace

std::string_view to_string(Mosaic mosaic) { return entry(mosaic).name; }

Mosaic mosaic_from_string(std::string_view text) {
  std::string names;
  for (const Pattern& pattern : kPatterns) {
    if (pattern.name == text) return pattern.mosaic;
    names += (names.empty() ? "" : ", ") + std::string(pattern.name);
  }
  throw std::invalid_argument("mosaic \"" + std::string(text) + "\" is not one of " + names);
}

int bayer_channel(Mosaic mosaic, int x, int y) {
  return entry(mosaic).channel[static_cast<std::size_t>(x % 2 + 2 * (y % 2))];
}

void validate(const RawFormat& format) {
  if (format.bits < 1 || format.bits > 16) {
    throw std::invalid_argument("raw format: bits = " + std::to_string(format.bits) +
                                " is outside 1..16");
  }
  const int largest = (1 << format.bits) - 1;
  if (format.black_level < 0 || format.black_level >= largest) {
    throw std::invalid_argument("raw format: black_level = " + std::to_string(format.black_level) +
                                " is outside 0.." + std::to_string(largest - 1));
  }
}

}  // namespace cousin
