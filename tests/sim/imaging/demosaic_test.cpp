#include "sim/imaging/demosaic.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <array>
#include <cmath>
#include <functional>
#include <stdexcept>

namespace cousin {
namespace {

constexpr std::array kPatterns = {Mosaic::rggb, Mosaic::bggr, Mosaic::grbg, Mosaic::gbrg};
constexpr std::array kMethods = {Demosaic::bilinear, Demosaic::malvar_he_cutler};

using Colour = std::function<Rgbf(int, int)>;

Image<float> mosaic_of(int width, int height, Mosaic mosaic, const Colour& colour) {
  Image<float> samples(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Rgbf c = colour(x, y);
      const float channels[] = {c.r, c.g, c.b};
      samples(x, y) = channels[bayer_channel(mosaic, x, y)];
    }
  }
  return samples;
}

/// Largest difference of any channel, `margin` pixels from the border on.
float largest_error(const Image<Rgbf>& image, const Colour& colour, int margin) {
  float largest = 0;
  for (int y = margin; y + margin < image.height(); ++y) {
    for (int x = margin; x + margin < image.width(); ++x) {
      const Rgbf a = image(x, y), b = colour(x, y);
      largest = std::max({largest, std::abs(a.r - b.r), std::abs(a.g - b.g), std::abs(a.b - b.b)});
    }
  }
  return largest;
}

TEST(Demosaic, AnEvenColourComesBackToTheBorder) {
  const Colour even = [](int, int) { return Rgbf{0.75F, 0.5F, 0.25F}; };
  for (const Mosaic mosaic : kPatterns) {
    for (const Demosaic method : kMethods) {
      const Image<Rgbf> image = demosaic(mosaic_of(9, 7, mosaic, even), mosaic, method);
      EXPECT_EQ(largest_error(image, even, 0), 0) << to_string(mosaic) << to_string(method);
    }
  }
}

TEST(Demosaic, SamplesStayWhereTheyAre) {
  const Colour wild = [](int x, int y) {
    return Rgbf{static_cast<float>(x * y % 7), static_cast<float>((x + 3 * y) % 5),
                static_cast<float>((5 * x + y) % 11)};
  };
  for (const Mosaic mosaic : kPatterns) {
    for (const Demosaic method : kMethods) {
      const Image<Rgbf> image = demosaic(mosaic_of(12, 10, mosaic, wild), mosaic, method);
      EXPECT_EQ(mosaic_of(12, 10, mosaic, [&](int x, int y) { return image(x, y); }),
                mosaic_of(12, 10, mosaic, wild));
    }
  }
}

TEST(Demosaic, ARampOfBrightnessIsExactInside) {
  // All filters are exact for planes; the colours differ by constants, as Malvar's correction
  // wants.
  const Colour ramp = [](int x, int y) {
    const float v = 0.5F * static_cast<float>(x) + 0.25F * static_cast<float>(y);
    return Rgbf{v + 2, v, v + 1};
  };
  for (const Mosaic mosaic : kPatterns) {
    for (const Demosaic method : kMethods) {
      const Image<Rgbf> image = demosaic(mosaic_of(16, 12, mosaic, ramp), mosaic, method);
      EXPECT_LT(largest_error(image, ramp, 2), 1e-5F) << to_string(mosaic) << to_string(method);
    }
  }
}

TEST(Demosaic, HasTheFiltersOfTheSourcesFigure) {
  // The response to one sample of 8 at a red photosite, by hand from figure 2 of Malvar et al.
  Image<float> impulse(11, 11);
  impulse(4, 4) = 8;
  const Image<Rgbf> image = demosaic(impulse, Mosaic::rggb, Demosaic::malvar_he_cutler);
  EXPECT_EQ(image(4, 4), (Rgbf{8, 4, 6}));
  EXPECT_EQ(image(5, 4), (Rgbf{4, 0, 0}));  // green photosite beside: of its red 4, of its blue
  EXPECT_EQ(image(4, 5), (Rgbf{4, 0, 0}));
  EXPECT_EQ(image(5, 5), (Rgbf{2, 0, 0}));       // blue photosite: red from the diagonals
  EXPECT_EQ(image(6, 4), (Rgbf{0, -1, -1.5F}));  // next red: green and blue two pixels on
  EXPECT_EQ(image(4, 6), (Rgbf{0, -1, -1.5F}));
  impulse(4, 4) = 0;
  impulse(5, 4) = 8;  // green in a red row
  const Image<Rgbf> green = demosaic(impulse, Mosaic::rggb, Demosaic::malvar_he_cutler);
  EXPECT_EQ(green(5, 4), (Rgbf{5, 8, 5}));
  EXPECT_EQ(green(4, 4), (Rgbf{0, 2, 0}));
  EXPECT_EQ(green(5, 5), (Rgbf{0, 2, 0}));
  EXPECT_EQ(green(7, 4), (Rgbf{-1, 0, 0.5F}));
  EXPECT_EQ(green(5, 6), (Rgbf{0.5F, 0, -1}));
  EXPECT_EQ(green(6, 5), (Rgbf{-1, 0, -1}));
}

TEST(Demosaic, TheCorrectionBeatsBilinearOnFineDetail) {
  // Grey waves of 5 px: the source reports about 5 dB over photographs.
  const Colour waves = [](int x, int y) {
    const auto v = static_cast<float>(0.5 + 0.3 * std::sin(1.25 * x) * std::cos(0.4 * y));
    return Rgbf{v, v, v};
  };
  const auto mean_square = [&](Demosaic method) {
    const Image<Rgbf> image =
        demosaic(mosaic_of(64, 64, Mosaic::grbg, waves), Mosaic::grbg, method);
    double sum = 0;
    for (int y = 4; y < 60; ++y) {
      for (int x = 4; x < 60; ++x) {
        const Rgbf a = image(x, y), b = waves(x, y);
        sum += std::pow(a.r - b.r, 2) + std::pow(a.g - b.g, 2) + std::pow(a.b - b.b, 2);
      }
    }
    return sum;
  };
  EXPECT_GT(
      10 * std::log10(mean_square(Demosaic::bilinear) / mean_square(Demosaic::malvar_he_cutler)),
      5);
}

TEST(Demosaic, GreyIsSpread) {
  Image<float> samples(4, 3, 0.5F);
  samples(1, 2) = 0.25F;
  const Image<Rgbf> image = demosaic(samples, Mosaic::grey, Demosaic::bilinear);
  EXPECT_EQ(image(1, 2), (Rgbf{0.25F, 0.25F, 0.25F}));
  EXPECT_EQ(image(0, 0), (Rgbf{0.5F, 0.5F, 0.5F}));
}

TEST(Demosaic, GivesTheSameBytesOnAnyNumberOfThreads) {
  const Colour wild = [](int x, int y) {
    return Rgbf{0.1F * static_cast<float>(x * y % 7), 0.3F * static_cast<float>((x + 3 * y) % 5),
                0.7F};
  };
  const Image<float> samples = mosaic_of(129, 97, Mosaic::bggr, wild);
  const auto run = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return demosaic(samples, Mosaic::bggr, Demosaic::malvar_he_cutler);
  };
  EXPECT_EQ(run(1), run(2));
  EXPECT_EQ(run(1), run(7));
}

TEST(Demosaic, RefusesAnImageWithoutANeighbourhood) {
  EXPECT_THROW(demosaic(Image<float>(2, 3), Mosaic::rggb, Demosaic::bilinear),
               std::invalid_argument);
  EXPECT_NO_THROW(demosaic(Image<float>(3, 3), Mosaic::rggb, Demosaic::bilinear));
  EXPECT_THROW(demosaic_from_string("vng"), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
