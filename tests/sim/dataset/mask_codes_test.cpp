#include "sim/dataset/mask_codes.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "sim/types/rng.h"

namespace cousin {
namespace {

/// pycocotools' rleFrString and rleDecode, written from the format: an image of 0 and 255.
Image<std::uint8_t> decoded(const std::string& text, int width, int height) {
  std::vector<long> runs;
  std::size_t at = 0;
  while (at < text.size()) {
    long value = 0;
    int shift = 0;
    bool more = true;
    while (more) {
      const long bits = text.at(at++) - 48;
      value |= (bits & 0x1f) << shift;
      more = (bits & 0x20) != 0;
      shift += 5;
      if (!more && (bits & 0x10) != 0) value |= -1L << shift;
    }
    if (runs.size() > 2) value += runs[runs.size() - 2];
    runs.push_back(value);
  }
  Image<std::uint8_t> image(width, height);
  long pixel = 0;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    for (long k = 0; k < runs[i]; ++k, ++pixel) {
      if (i % 2 == 1)
        image(static_cast<int>(pixel / height), static_cast<int>(pixel % height)) = 255;
    }
  }
  EXPECT_EQ(pixel, static_cast<long>(width) * height);
  return image;
}

/// Pixels whose centres an odd number of edges lies left of.
Image<std::uint8_t> filled(const std::vector<PixelOutline>& outlines, int width, int height) {
  Image<std::uint8_t> image(width, height);
  for (const PixelOutline& line : outlines) {
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        bool inside = false;
        for (std::size_t i = 0; i < line.size(); ++i) {
          const Eigen::Vector2d a = line[i].cast<double>();
          const Eigen::Vector2d b = line[(i + 1) % line.size()].cast<double>();
          if ((a.y() > y + 0.5) == (b.y() > y + 0.5)) continue;
          const double cut = a.x() + (y + 0.5 - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
          if (cut < x + 0.5) inside = !inside;
        }
        if (inside) image(x, y) = image(x, y) == 0 ? 255 : 1;  // 1: two parts share a pixel
      }
    }
  }
  return image;
}

Image<std::uint8_t> placed(const Image<std::uint8_t>& mask, int x, int y, int width, int height) {
  Image<std::uint8_t> image(width, height);
  for (int v = 0; v < mask.height(); ++v) {
    for (int u = 0; u < mask.width(); ++u) image(x + u, y + v) = mask(u, v);
  }
  return image;
}

/// Random pixels: parts that touch by corners, holes in holes, borders of the image.
Image<std::uint8_t> random_mask(int width, int height, double share, Rng rng) {
  Image<std::uint8_t> mask(width, height);
  for (std::uint8_t& pixel : mask) pixel = uniform(rng, 0, 1) < share ? 255 : 0;
  return mask;
}

TEST(MaskCodes, RunLengthsAndOutlinesGiveBackTheVeryPixels) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const Rng rng(seed);
    const double share = 0.1 + 0.8 * static_cast<double>(seed % 10) / 9;
    const Image<std::uint8_t> mask = random_mask(13, 9, share, rng);
    // In the middle, at corners, and as large as the image.
    struct Place {
      int x, y, width, height;
    };
    for (const Place& p : {Place{4, 3, 20, 16}, Place{0, 0, 20, 16}, Place{7, 7, 20, 16},
                           Place{0, 0, 13, 9}, Place{2, 0, 15, 9}}) {
      const Image<std::uint8_t> whole = placed(mask, p.x, p.y, p.width, p.height);
      EXPECT_EQ(decoded(coco_run_lengths(mask, p.x, p.y, p.width, p.height), p.width, p.height),
                whole);
      const std::vector<PixelOutline> outlines = outlines_of(mask, p.x, p.y);
      EXPECT_EQ(filled(outlines, p.width, p.height), whole);
      EXPECT_EQ(filled({joined(outlines)}, p.width, p.height), whole);
    }
  }
}

TEST(MaskCodes, RunLengthsAreReadBackToTheVeryPixels) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const Image<std::uint8_t> whole = random_mask(17, 11, 0.5, Rng(seed));
    const PlacedMask read =
        mask_of_runs(runs_of_coco(coco_run_lengths(whole, 0, 0, 17, 11)), 17, 11);
    EXPECT_EQ(placed(read.mask, read.x, read.y, 17, 11), whole);
  }
}

/// Pixels of a filled polygon as rows of text.
std::vector<std::string> drawn(const std::vector<std::vector<Eigen::Vector2d>>& polygons, int width,
                               int height) {
  const PlacedMask mask = mask_of_polygons(polygons, width, height);
  std::vector<std::string> rows(static_cast<std::size_t>(height),
                                std::string(static_cast<std::size_t>(width), '.'));
  for (int y = 0; y < mask.mask.height(); ++y) {
    for (int x = 0; x < mask.mask.width(); ++x) {
      if (mask.mask(x, y) != 0)
        rows[static_cast<std::size_t>(y + mask.y)][static_cast<std::size_t>(x + mask.x)] = '#';
    }
  }
  return rows;
}

TEST(MaskCodes, PolygonsAreFilledByTheEvenOddRuleAndTogether) {
  using Rows = std::vector<std::string>;
  // Whole pixels are covered to the very border.
  EXPECT_EQ(drawn({{{1, 1}, {4, 1}, {4, 3}, {1, 3}}}, 6, 4),
            (Rows{"......", ".###..", ".###..", "......"}));
  // A line that goes round twice leaves its middle empty; a second polygon fills it.
  const std::vector<Eigen::Vector2d> frame = {{0, 0}, {6, 0}, {6, 6}, {0, 6}, {0, 0},
                                              {2, 2}, {4, 2}, {4, 4}, {2, 4}, {2, 2}};
  EXPECT_EQ(drawn({frame}, 6, 6),
            (Rows{"######", "######", "##..##", "##..##", "######", "######"}));
  EXPECT_EQ(drawn({frame, {{2, 2}, {4, 2}, {4, 4}, {2, 4}}}, 6, 6), Rows(6, "######"));
  // What lies outside the image is cut off.
  EXPECT_EQ(drawn({{{-5, -5}, {2, -5}, {2, 9}, {-5, 9}}}, 4, 3), Rows(3, "##.."));
  EXPECT_EQ(drawn({{{8, 8}, {9, 8}, {9, 9}}}, 4, 3), Rows(3, "...."));
}

TEST(MaskCodes, TextThatIsNoRunLengthsIsRefused) {
  for (const char* text : {"p", "4 4", "o", "oooooooooooooo", "/"})
    EXPECT_THROW(runs_of_coco(text), std::invalid_argument) << text;
  EXPECT_THROW(mask_of_runs({1, 2}, 2, 2), std::invalid_argument);
  EXPECT_THROW(mask_of_runs({1, 4}, 2, 2), std::invalid_argument);
  EXPECT_THROW(mask_of_runs({4}, 0, 4), std::invalid_argument);
  EXPECT_THROW(mask_of_runs({0, std::int64_t{30000} * 30000}, 30000, 30000), std::invalid_argument);
  EXPECT_THROW(mask_of_polygons({{{0, 0}, {2e6, 0}, {0, 1}}}, 4, 4), std::invalid_argument);
}

TEST(MaskCodes, RunLengthsAreCocosOwnText) {
  // One pixel at (1, 1) of 3 x 3: 4 outside, 1 inside, 4 outside; the last is written as the
  // difference to the one two before only from the fourth run on [pycocotools, rleToString].
  Image<std::uint8_t> one(1, 1, 255);
  EXPECT_EQ(coco_run_lengths(one, 1, 1, 3, 3), "414");
  // 40 = 8 + 32: two characters, the first marked to go on.
  EXPECT_EQ(coco_run_lengths(Image<std::uint8_t>(1, 40, 255), 0, 0, 1, 40), "0X1");
}

TEST(MaskCodes, OutlinesAreOneForEachPartAndGoRoundHoles) {
  Image<std::uint8_t> ring(3, 3, 255);
  ring(1, 1) = 0;
  const std::vector<PixelOutline> outlines = outlines_of(ring, 10, 20);
  ASSERT_EQ(outlines.size(), 1U);
  EXPECT_EQ(outlines[0].size(), 10U);  // four corners of each and the cut's two, once more
  const std::vector<PixelOutline> square = outlines_of(Image<std::uint8_t>(2, 2, 255), 10, 20);
  ASSERT_EQ(square.size(), 1U);
  EXPECT_EQ(square[0], (PixelOutline{{10, 20}, {12, 20}, {12, 22}, {10, 22}}));
}

TEST(MaskCodes, AMaskOutsideItsImageIsRefused) {
  EXPECT_THROW(coco_run_lengths(Image<std::uint8_t>(3, 3, 255), 2, 0, 4, 4), std::invalid_argument);
  EXPECT_THROW(coco_run_lengths(Image<std::uint8_t>(3, 3, 255), 0, -1, 4, 4),
               std::invalid_argument);
}

}  // namespace
}  // namespace cousin
