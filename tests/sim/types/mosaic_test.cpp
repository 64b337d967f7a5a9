#include "sim/types/mosaic.h"

#include <gtest/gtest.h>

#include <array>
#include <stdexcept>
#include <string>

namespace cousin {
namespace {

constexpr Mosaic kAll[] = {Mosaic::grey, Mosaic::rggb, Mosaic::bggr, Mosaic::grbg, Mosaic::gbrg};

TEST(Mosaic, NamesRoundTrip) {
  for (const Mosaic mosaic : kAll) EXPECT_EQ(mosaic_from_string(to_string(mosaic)), mosaic);
  EXPECT_THROW(mosaic_from_string("rgbw"), std::invalid_argument);
}

TEST(Mosaic, ABayerPatternIsWhatItsNameSpells) {
  for (const Mosaic mosaic : {Mosaic::rggb, Mosaic::bggr, Mosaic::grbg, Mosaic::gbrg}) {
    std::string spelled;
    for (const auto& [x, y] : {std::array{0, 0}, {1, 0}, {0, 1}, {1, 1}}) {
      spelled += "rgb"[bayer_channel(mosaic, 4 + x, 6 + y)];
    }
    EXPECT_EQ(spelled, to_string(mosaic));
  }
}

TEST(RawFormat, RefusesNumbersThatCannotBe) {
  EXPECT_NO_THROW(validate(RawFormat{Mosaic::rggb, 14, 512}));
  EXPECT_THROW(validate(RawFormat{Mosaic::rggb, 17, 0}), std::invalid_argument);
  EXPECT_THROW(validate(RawFormat{Mosaic::rggb, 0, 0}), std::invalid_argument);
  EXPECT_THROW(validate(RawFormat{Mosaic::rggb, 8, 255}), std::invalid_argument);
  EXPECT_THROW(validate(RawFormat{Mosaic::rggb, 8, -1}), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
