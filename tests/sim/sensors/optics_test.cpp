#include "sim/sensors/optics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace cousin {
namespace {

Camera centred(int width, int height) {
  Camera camera{LensModel::pinhole, width, height, 200, 200, 0, 0, {}, {}};
  camera.cx_px = 0.5 * (width - 1);
  camera.cy_px = 0.5 * (height - 1);
  return camera;
}

Image<Rgbf> spot(int width, int height, double x, double y) {
  Image<Rgbf> image(width, height);
  for (int j = 0; j < height; ++j) {
    for (int i = 0; i < width; ++i) {
      const auto v =
          static_cast<float>(std::exp(-0.5 * (std::pow(i - x, 2) + std::pow(j - y, 2)) / 6));
      image(i, j) = {v, v, v};
    }
  }
  return image;
}

Eigen::Vector2d centroid(const Image<Rgbf>& image, float Rgbf::*channel) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double weight = 0;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const auto v = static_cast<double>(image(x, y).*channel);
      sum += v * Eigen::Vector2d(x, y);
      weight += v;
    }
  }
  return sum / weight;
}

TEST(Optics, NothingConfiguredChangesNothing) {
  const Image<Rgbf> image = spot(60, 40, 21.3, 17.8);
  EXPECT_EQ(shade_and_blur_rows(image, {}, centred(60, 40), gaussian_weights(0), "test"), image);
}

TEST(Optics, EachColourLandsWhereItsMapSays) {
  const Camera camera = centred(301, 201);
  Optics optics;
  optics.red = {1.004, 0.003};
  optics.blue = {0.996, -0.002};
  const double x = 270, y = 40;
  const Image<Rgbf> seen =
      shade_and_blur_rows(spot(301, 201, x, y), optics, camera, gaussian_weights(0), "test");
  const Eigen::Vector2d centre(camera.cx_px, camera.cy_px);
  const Eigen::Vector2d from = Eigen::Vector2d(x, y) - centre;
  const double r2 = from.squaredNorm() / (0.25 * (301 * 301 + 201 * 201));
  // Catmull-Rom keeps the first moment; the spot is cut at 12 sigmas, the map bends over it by less
  // than 1e-3 px.
  EXPECT_LT((centroid(seen, &Rgbf::g) - Eigen::Vector2d(x, y)).norm(), 1e-4);
  EXPECT_LT((centroid(seen, &Rgbf::r) - (centre + from * (1.004 + 0.003 * r2))).norm(), 2e-3);
  EXPECT_LT((centroid(seen, &Rgbf::b) - (centre + from * (0.996 - 0.002 * r2))).norm(), 2e-3);
}

TEST(Optics, ResamplingKeepsAnEvenImageEven) {
  Optics optics;
  optics.red = {1.05, 0.01};
  optics.blue = {0.95, -0.01};
  const Image<Rgbf> image(40, 30, {0.5F, 0.25F, 0.75F});
  for (const Rgbf& pixel :
       shade_and_blur_rows(image, optics, centred(40, 30), gaussian_weights(0), "test")) {
    ASSERT_NEAR(pixel.r, 0.5F, 1e-6F);
    ASSERT_NEAR(pixel.b, 0.75F, 1e-6F);
  }
}

TEST(Optics, RadianceThatIsNotFiniteNamesSensorAndRow) {
  Image<Rgbf> image(20, 10);
  image(3, 7).b = std::numeric_limits<float>::infinity();
  try {
    shade_and_blur_rows(image, {}, centred(20, 10), gaussian_weights(0), "left eye");
    FAIL() << "no error";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("left eye: radiance in row 7 is not finite"));
  }
}

}  // namespace
}  // namespace cousin
