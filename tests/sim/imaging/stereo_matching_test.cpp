#include "sim/imaging/stereo_matching.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <vector>

#include "sim/imaging/census.h"
#include "sim/types/rng.h"

namespace cousin {
namespace {

/// A random number for a node of a lattice, the same after 256 nodes.
double node(int i, int j) {
  static const std::vector<double> nodes = [] {
    Rng rng(7);
    std::vector<double> values(256 * 256);
    for (double& v : values) v = uniform(rng);
    return values;
  }();
  return nodes[static_cast<std::size_t>((i & 255) * 256 + (j & 255))];
}

/// A random texture over the plane: smooth bumps about 3 px wide, so that it can be sampled
/// anywhere.
double texture(double x, double y) {
  double sum = 0, weight = 0;
  const int cx = static_cast<int>(std::floor(x / 2)), cy = static_cast<int>(std::floor(y / 2));
  for (int j = cy - 2; j <= cy + 3; ++j) {
    for (int i = cx - 2; i <= cx + 3; ++i) {
      const double dx = x / 2 - i, dy = y / 2 - j;
      const double w = std::exp(-(dx * dx + dy * dy));
      sum += w * node(i, j);
      weight += w;
    }
  }
  return 600 * sum / weight;
}

struct Pair {
  Image<float> left, right;
};

/// A surface seen by both: `disparity` of the right image's pixels.
Pair make_pair(int width, int height, const std::function<double(int, int)>& right_disparity_px) {
  Pair pair{Image<float>(width, height), Image<float>(width, height)};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      pair.left(x, y) = static_cast<float>(texture(x, y));
      pair.right(x, y) = static_cast<float>(texture(x + right_disparity_px(x, y), y));
    }
  }
  return pair;
}

TEST(Census, IsBlindToBrightnessAndContrast) {
  const Pair pair = make_pair(40, 30, [](int, int) { return 0.0; });
  Image<float> other = pair.left;
  for (float& v : other) v = 3 * v + 100;
  EXPECT_EQ(census_transform(pair.left, 7, 7), census_transform(other, 7, 7));
}

TEST(Census, ComparesOppositePixels) {
  Image<std::uint16_t> image(3, 1);
  image(0, 0) = 5;
  image(2, 0) = 3;
  // One pair, left and right of the centre; the border repeats.
  const Image<std::uint64_t> codes = census_transform(image, 3, 1);
  EXPECT_EQ(codes(0, 0), 1U);  // 5 against 0
  EXPECT_EQ(codes(1, 0), 1U);  // 5 against 3
  EXPECT_EQ(codes(2, 0), 2U);  // 0 against 3
  // A margin of 2 leaves what differs by more.
  const Image<std::uint64_t> coarse = census_transform(image, 3, 1, 2);
  EXPECT_EQ(coarse(0, 0), 1U);
  EXPECT_EQ(coarse(1, 0), 0U);
  EXPECT_EQ(coarse(2, 0), 2U);
}

TEST(Census, RejectsWindowsThatDoNotFit) {
  EXPECT_THROW(census_transform(Image<float>(9, 9), 6, 7), std::invalid_argument);
  EXPECT_THROW(census_transform(Image<float>(9, 9), 9, 9), std::invalid_argument);
  EXPECT_THROW(census_transform(Image<float>(9, 9), 7, 7, -1), std::invalid_argument);
  EXPECT_EQ(census_pairs(9, 7), 31);
}

/// What is left of matches minus truth inside a rectangle.
struct Errors {
  double bias_px = 0, rms_px = 0, fill = 0;
};
Errors errors_of(const Image<float>& found, const std::function<double(int, int)>& truth_px, int x0,
                 int y0, int x1, int y1) {
  double sum = 0, squares = 0;
  int n = 0;
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) {
      const double e = found(x, y) - truth_px(x, y);
      if (std::isnan(e)) continue;
      sum += e;
      squares += e * e;
      ++n;
    }
  }
  return {sum / n, std::sqrt(squares / n), n / static_cast<double>((x1 - x0) * (y1 - y0))};
}

// Windows of 11 x 11 pixels: about 50 independent ones, each within some 0.07 px on this texture
// (the census quantises), so the mean has 0.01; 0.01 more is the fit's own pull to whole pixels.
TEST(StereoMatching, FindsTheDisparityOfAFlatWall) {
  for (const double d : {10.0, 10.25, 10.5, 23.8}) {
    const auto wall = [d](int, int) { return d; };
    const Pair pair = make_pair(160, 60, wall);
    const Errors e = errors_of(match_stereo(pair.left, pair.right, {.range_px = 40}).disparity_px,
                               wall, 40, 6, 150, 54);
    EXPECT_GT(e.fill, 0.99) << d;
    EXPECT_NEAR(e.bias_px, 0, 0.03) << d;
    EXPECT_LT(e.rms_px, 0.1) << d;
  }
}

// The fit of parabolas to costs that grow linearly pulls towards whole pixels: by 0.085 px at a
// quarter for V-shaped costs, (1 - 2 t) / (2 (1 - t)) - (0.5 - t) at t = 1/4 and the like.
TEST(StereoMatching, AParabolaPullsToWholePixelsAndEquiangularLinesDoNot) {
  const auto wall = [](int, int) { return 12.25; };
  const Pair pair = make_pair(200, 90, wall);
  const auto bias = [&](SubPixelFit fit) {
    const auto found = match_stereo(pair.left, pair.right, {.range_px = 30, .fit = fit});
    return errors_of(found.disparity_px, wall, 50, 6, 190, 84).bias_px;
  };
  // A V of slope 1 with its tip at t = 0.25: costs 1.25, 0.25, 0.75, so the parabola's tip is at
  // 0.5 * 0.5 / 1.5 = 1/6: 0.083 short. Averaged over windows that are not quite a V.
  EXPECT_NEAR(bias(SubPixelFit::parabola), 1.0 / 6 - 0.25, 0.02);
  EXPECT_NEAR(bias(SubPixelFit::equiangular), 0, 0.03);
}

TEST(StereoMatching, FollowsATiltedPlane) {
  // d_left(x) = 20 + 0.05 x + 0.1 y; the right image's pixel x - d_left carries that disparity.
  const auto left = [](int x, int y) { return 20 + 0.05 * x + 0.1 * y; };
  const Pair pair =
      make_pair(200, 80, [](int x, int y) { return (20 + 0.05 * x + 0.1 * y) / 0.95; });
  const StereoMatches found = match_stereo(pair.left, pair.right, {.range_px = 60});
  const Errors e = errors_of(found.disparity_px, left, 50, 8, 190, 72);
  EXPECT_GT(e.fill, 0.97);
  EXPECT_NEAR(e.bias_px, 0, 0.03);
  EXPECT_LT(e.rms_px, 0.13);  // the windows span half a pixel of slope
}

/// A box of disparity 30 before a wall of 12, columns 60 to 120 of the left image.
Pair step_pair() {
  Pair pair{Image<float>(200, 60), Image<float>(200, 60)};
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < 200; ++x) {
      const bool near_left = x >= 60 && x < 120, near_right = x + 30 >= 60 && x + 30 < 120;
      pair.left(x, y) = static_cast<float>(near_left ? texture(x + 900, y) : texture(x, y));
      pair.right(x, y) =
          static_cast<float>(near_right ? texture(x + 30 + 900, y) : texture(x + 12, y));
    }
  }
  return pair;
}

TEST(StereoMatching, AStepLeavesAnOcclusionAsWideAsItsDisparity) {
  const Pair pair = step_pair();
  const StereoMatches found = match_stereo(pair.left, pair.right, {.range_px = 50});
  double width = 0;
  for (int y = 15; y < 45; ++y) {
    int none = 0;
    for (int x = 30; x < 62; ++x) none += std::isnan(found.disparity_px(x, y)) ? 1 : 0;
    width += none / 30.0;
  }
  // Columns 42 to 60 are seen by the left image only: 30 - 12 = 18. The window of 11 columns
  // fattens the box by up to 5.5 into it.
  EXPECT_GT(width, 18 - 6.0);
  EXPECT_LT(width, 18 + 2.0);
  EXPECT_NEAR(found.disparity_px(90, 30), 30, 0.5);
  EXPECT_NEAR(found.disparity_px(160, 30), 12, 0.5);
}

TEST(StereoMatching, SaysWhyAPixelHasNoDisparity) {
  const auto wall = [](int, int) { return 20.0; };
  Pair pair = make_pair(160, 60, wall);
  for (auto* image : {&pair.left, &pair.right}) {
    for (int y = 0; y < 60; ++y) {
      for (int x = 90; x < 160; ++x) (*image)(x, y) = 300;  // even
    }
  }
  const StereoMatches even = match_stereo(pair.left, pair.right, {.range_px = 40});
  EXPECT_EQ(even.reason(130, 30), MatchReason::no_texture);
  EXPECT_TRUE(std::isnan(even.disparity_px(130, 30)));
  EXPECT_EQ(even.reason(60, 30), MatchReason::none);

  // The true disparity lies beyond the range: of the dozen windows here
  // chance makes a few alike to another, which every matcher believes.
  const StereoMatches beyond = match_stereo(pair.left, pair.right, {.range_px = 10});
  EXPECT_LT(errors_of(beyond.disparity_px, wall, 40, 8, 80, 52).fill, 0.4);
  // With the range shifted it is found, and the disparity counts from the image, not the range.
  const StereoMatches shifted =
      match_stereo(pair.left, pair.right, {.shift_px = 15, .range_px = 10});
  EXPECT_NEAR(shifted.disparity_px(60, 30), 20, 0.3);
  // Left of column 20 the match lies outside the right image.
  EXPECT_LT(errors_of(even.disparity_px, wall, 0, 8, 15, 52).fill, 0.2);
}

// A texture that repeats every 8 px matches at 4, 12, 20, ... alike: it must be said.
TEST(StereoMatching, ARepeatedTextureIsAmbiguous) {
  Pair pair{Image<float>(160, 60), Image<float>(160, 60)};
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < 160; ++x) {
      pair.left(x, y) = static_cast<float>(texture(x % 8, y));
      pair.right(x, y) = static_cast<float>(texture((x + 4) % 8, y));
    }
  }
  const StereoMatches found = match_stereo(pair.left, pair.right, {.range_px = 40});
  int said = 0, asked = 0;
  for (int y = 10; y < 50; ++y) {
    for (int x = 60; x < 150; ++x, ++asked)
      said += found.reason(x, y) == MatchReason::ambiguous ? 1 : 0;
  }
  EXPECT_GT(said, 0.9 * asked);
}

TEST(StereoMatching, GivesTheSameBytesForAnyNumberOfThreads) {
  const Pair pair = step_pair();
  const StereoMatches one = [&] {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, 1);
    return match_stereo(pair.left, pair.right, {.range_px = 50});
  }();
  for (const int threads : {2, 7}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism,
                                      static_cast<std::size_t>(threads));
    const StereoMatches more = match_stereo(pair.left, pair.right, {.range_px = 50});
    const std::size_t bytes = one.disparity_px.size() * sizeof(float);
    EXPECT_EQ(std::memcmp(one.disparity_px.data(), more.disparity_px.data(), bytes), 0) << threads;
    EXPECT_EQ(one.reason, more.reason) << threads;
  }
}

TEST(StereoMatching, WholeNumbersGiveWhatTheSameFloatsGive) {
  const Pair pair = step_pair();
  Image<std::uint16_t> left(200, 60), right(200, 60);
  Image<float> left_f(200, 60), right_f(200, 60);
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < 200; ++x) {
      left(x, y) = static_cast<std::uint16_t>(pair.left(x, y));
      right(x, y) = static_cast<std::uint16_t>(pair.right(x, y));
      left_f(x, y) = left(x, y);
      right_f(x, y) = right(x, y);
    }
  }
  const StereoMatchConfig config{.range_px = 50};
  const StereoMatches a = match_stereo(left, right, config);
  const StereoMatches b = match_stereo(left_f, right_f, config);
  EXPECT_EQ(a.reason, b.reason);
  EXPECT_EQ(a.confidence, b.confidence);
}

TEST(StereoMatching, RejectsWhatItCannotDo) {
  const Image<float> image(40, 30), other(41, 30);
  EXPECT_THROW(match_stereo(image, other), std::invalid_argument);
  EXPECT_THROW(match_stereo(Image<float>(), Image<float>()), std::invalid_argument);
  EXPECT_THROW(match_stereo(image, image, {.block_px = 4}), std::invalid_argument);
  EXPECT_THROW(match_stereo(image, image, {.range_px = 255}), std::invalid_argument);
  EXPECT_THROW(match_stereo(image, image, {.paths = 5}), std::invalid_argument);
  EXPECT_THROW(match_stereo(image, image, {.p1 = 2, .p2 = 1}), std::invalid_argument);
  // An image narrower than the range is matched as far as it goes.
  EXPECT_NO_THROW(match_stereo(image, image, {.range_px = 126}));
}

}  // namespace
}  // namespace cousin
