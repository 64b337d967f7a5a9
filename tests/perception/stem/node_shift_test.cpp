#include "perception/stem/node_shift.h"

#include <gtest/gtest.h>

#include "tests/perception/stem/made_stem.h"

namespace cousin {
namespace {

/// Green speckle of cells of 3 px, `shift_px` to the left in the second eye, between pixels too.
Image<Rgb8> speckle(double shift_px) {
  Image<Rgb8> image(400, 300);
  const auto cell = [](int x, int y) {
    Rng rng = Rng(3).fork(static_cast<std::uint64_t>(x + 1000)).fork(static_cast<std::uint64_t>(y));
    return 60 + 120 * uniform(rng);
  };
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const double u = (x + shift_px) / 3, v = y / 3.0;
      const int i = static_cast<int>(std::floor(u)), j = static_cast<int>(std::floor(v));
      const double s = u - i, t = v - j;
      const double value = (1 - s) * (1 - t) * cell(i, j) + s * (1 - t) * cell(i + 1, j) +
                           (1 - s) * t * cell(i, j + 1) + s * t * cell(i + 1, j + 1);
      image(x, y) = {static_cast<std::uint8_t>(0.6 * value), static_cast<std::uint8_t>(value),
                     static_cast<std::uint8_t>(0.4 * value)};
    }
  }
  return image;
}

EyePair small_eyes() {
  const Camera camera{LensModel::pinhole, 400, 300, 300, 300, 199.5, 149.5, {}, {}};
  Pose right_from_left;
  right_from_left.translation_m = {-0.12, 0, 0};
  return {camera, camera, right_from_left};
}

TEST(FindShift, IsSharpToAFractionOfAPixelFromAPoorStart) {
  const EyePicture left = eye_picture(speckle(0)), right = eye_picture(speckle(40.3));
  const NodeShift shift =
      find_shift(small_eyes(), left, right, {{200, 150}, 1}, {{156.5, 151.2}, 1}, 0);
  ASSERT_TRUE(shift.why_none.empty()) << shift.why_none;
  EXPECT_NEAR(shift.right_px.x(), 200 - 40.3, 0.05);
  EXPECT_NEAR(shift.right_px.y(), 150, 0.1);
  EXPECT_GT(shift.likeness, 0.95);
}

TEST(FindShift, SaysWhyThereIsNone) {
  const EyePicture left = eye_picture(speckle(0)), right = eye_picture(speckle(40));
  EXPECT_FALSE(
      find_shift(small_eyes(), left, right, {{3, 150}, 1}, {{0, 150}, 1}, 0).why_none.empty());
  // The right eye's point is of another place, farther than what is searched.
  EXPECT_FALSE(
      find_shift(small_eyes(), left, right, {{200, 150}, 1}, {{100, 150}, 1}, 0).why_none.empty());
}

}  // namespace
}  // namespace cousin
