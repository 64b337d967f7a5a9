#include "benchmarks/report/pictures.h"

#include <gtest/gtest.h>

#include <limits>

namespace cousin {
namespace {

TEST(Pictures, NearDepthIsRedFarIsBlueAndNoneIsGrey) {
  Image<float> depth_m(3, 100, 2);
  for (int y = 0; y < 100; ++y) {
    depth_m(0, y) = 1;
    depth_m(2, y) = std::numeric_limits<float>::quiet_NaN();
  }
  const Image<Rgb8> picture = depth_in_color(depth_m);
  EXPECT_GT(picture(0, 50).r, 2 * picture(0, 50).b);
  EXPECT_GT(picture(1, 50).b, picture(1, 50).r);
  EXPECT_EQ(picture(2, 50), (Rgb8{48, 48, 48}));
  EXPECT_EQ(depth_in_color(Image<float>(2, 2, depth_m(2, 0)))(1, 1), (Rgb8{48, 48, 48}));
}

TEST(Pictures, ShrunkKeepsAspectAndNeverEnlarges) {
  const Image<Rgb8> image(40, 20, {10, 20, 30});
  const Image<Rgb8> small = shrunk(image, 10);
  EXPECT_EQ(small.width(), 10);
  EXPECT_EQ(small.height(), 5);
  EXPECT_EQ(small(9, 4), (Rgb8{10, 20, 30}));
  EXPECT_EQ(shrunk(image, 100), image);
}

TEST(Pictures, ACropEndsAtTheImage) {
  Image<Rgb8> image(5, 4);
  image(4, 3) = {1, 2, 3};
  const Image<Rgb8> part = cropped(image, 3, 2, 10, 10);
  EXPECT_EQ(part.width(), 2);
  EXPECT_EQ(part.height(), 2);
  EXPECT_EQ(part(1, 1), (Rgb8{1, 2, 3}));
  EXPECT_EQ(cropped(image, -2, -2, 4, 3).width(), 2);
  EXPECT_TRUE(cropped(image, 9, 9, 4, 4).empty());
}

TEST(Pictures, SideBySideKeepsEachOnWhite) {
  const Image<Rgb8> row = side_by_side({Image<Rgb8>(2, 3, {9, 9, 9}), Image<Rgb8>(4, 1)}, 5);
  EXPECT_EQ(row.width(), 11);
  EXPECT_EQ(row.height(), 3);
  EXPECT_EQ(row(1, 2), (Rgb8{9, 9, 9}));
  EXPECT_EQ(row(3, 0), (Rgb8{255, 255, 255}));
  EXPECT_EQ(row(8, 0), (Rgb8{}));
  EXPECT_EQ(row(8, 2), (Rgb8{255, 255, 255}));
}

}  // namespace
}  // namespace cousin
