#include "sim/imaging/undistort.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

namespace cousin {
namespace {

using Interpolation = UndistortConfig::Interpolation;

/// Strong but one-to-one distortion of each model, centre and focal lengths off the middle.
std::vector<Camera> lenses() {
  Camera camera{LensModel::opencv5, 200, 150, 170, 168, 104.3, 71.8, {}, {}};
  std::vector<Camera> all;
  camera.distortion = {-0.22, 0.06, 0.003, -0.002, -0.008};
  all.push_back(camera);
  camera.model = LensModel::opencv8;
  camera.distortion = {0.35, 0.12, -0.002, 0.001, 0.02, 0.55, 0.18, 0.03};
  all.push_back(camera);
  camera.model = LensModel::opencv12;
  camera.distortion = {0.30, 0.10, 0.001, 0.002,  0.02,  0.45,
                       0.15, 0.02, 0.004, -0.003, 0.005, 0.002};
  all.push_back(camera);
  camera.model = LensModel::kannala_brandt4;
  camera.distortion = {0.05, -0.02, 0.006, -0.001};
  all.push_back(camera);
  camera.model = LensModel::splined_stereographic;
  camera.distortion = {};
  camera.spline = {.order = 3, .columns = 10, .rows = 9, .fov_x_rad = 1.7, .delta_u = {}};
  for (int i = 0; i < 180; ++i) camera.spline.delta_u.push_back(0.02 * std::sin(0.7 * i));
  all.push_back(camera);
  return all;
}

Eigen::Vector3d ray_of(const Camera& pinhole, int x, int y) {
  return {(x - pinhole.cx_px) / pinhole.fx_px, (y - pinhole.cy_px) / pinhole.fy_px, 1};
}

TEST(Undistort, EachPixelComesFromWhereTheLensPutsItsRay) {
  for (const Camera& lens : lenses()) {
    // A ramp is interpolated exactly, so the value is the place sampled: 0 stands for
    // the first pixel's centre. Half a pixel off would be 0.5 here.
    Image<float> columns(lens.width_px, lens.height_px), rows = columns;
    for (int y = 0; y < lens.height_px; ++y) {
      for (int x = 0; x < lens.width_px; ++x) {
        columns(x, y) = static_cast<float>(x);
        rows(x, y) = static_cast<float>(y);
      }
    }
    for (const Interpolation interpolation : {Interpolation::bilinear, Interpolation::cubic}) {
      const UndistortConfig config{.focal_px = 150, .interpolation = interpolation};
      const Undistorted<float> u = undistort(columns, lens, config, -1);
      const Undistorted<float> v = undistort(rows, lens, config, -1);
      EXPECT_EQ(u.camera.model, LensModel::pinhole);
      int valid = 0;
      for (int y = 0; y < u.camera.height_px; ++y) {
        for (int x = 0; x < u.camera.width_px; ++x) {
          const auto expected = project(lens, ray_of(u.camera, x, y));
          const bool inside = expected && expected->x() >= 0 && expected->y() >= 0 &&
                              expected->x() <= lens.width_px - 1 &&
                              expected->y() <= lens.height_px - 1;
          ASSERT_EQ(u.valid(x, y), inside ? 255 : 0)
              << to_string(lens.model) << " " << x << " " << y;
          if (!inside) {
            EXPECT_EQ(u.image(x, y), -1);
            continue;
          }
          ++valid;
          // Next to the border the cubic repeats the last sample, which bends the ramp.
          const bool near_border = expected->x() < 1 || expected->x() > lens.width_px - 2 ||
                                   expected->y() < 1 || expected->y() > lens.height_px - 2;
          if (near_border && interpolation == Interpolation::cubic) continue;
          EXPECT_NEAR(u.image(x, y), expected->x(), 2e-5) << to_string(lens.model);  // of a float
          EXPECT_NEAR(v.image(x, y), expected->y(), 2e-5) << to_string(lens.model);
        }
      }
      EXPECT_GT(valid, u.camera.width_px * u.camera.height_px / 2) << to_string(lens.model);
    }
  }
}

TEST(Undistort, APatternDrawnThroughTheLensIsThePatternItself) {
  // A wave over the plane z = 1. Bilinear interpolation between samples h = 1 px apart errs by at
  // most h^2 / 8 times the sum of the second derivatives along x and y.
  constexpr double kWaves = 14;  // radians per unit of tangent
  const auto pattern = [](double x, double y) { return std::sin(kWaves * x + 5 * y); };
  for (const Camera& lens : lenses()) {
    Image<float> drawn(lens.width_px, lens.height_px);
    for (int y = 0; y < lens.height_px; ++y) {
      for (int x = 0; x < lens.width_px; ++x) {
        const auto ray = unproject(lens, {x, y});
        ASSERT_TRUE(ray);
        drawn(x, y) = static_cast<float>(pattern(ray->x() / ray->z(), ray->y() / ray->z()));
      }
    }
    const auto worst = [&](Interpolation interpolation) {
      const Undistorted<float> flat = undistort(drawn, lens, {.interpolation = interpolation});
      double most = 0;
      for (int y = 0; y < flat.camera.height_px; ++y) {
        for (int x = 0; x < flat.camera.width_px; ++x) {
          if (flat.valid(x, y) == 0) continue;
          const Eigen::Vector3d ray = ray_of(flat.camera, x, y);
          most = std::max(most, std::abs(flat.image(x, y) - pattern(ray.x(), ray.y())));
        }
      }
      return most;
    };
    // Second derivatives are (kWaves^2 + 5^2) / f^2 where the lens keeps the scale; half as much
    // again in tangent per pixel for the corner of these lenses squares to 2.25.
    const double bound = 2.25 * (kWaves * kWaves + 25) / (8 * 168.0 * 168.0);
    EXPECT_LT(worst(Interpolation::bilinear), bound) << to_string(lens.model);
    EXPECT_LT(worst(Interpolation::cubic), bound) << to_string(lens.model);
  }
}

TEST(Undistort, BlobsLieWhereThePinholeProjectsThem) {
  for (const Camera& lens : lenses()) {
    for (const Eigen::Vector2d& tangent :
         {Eigen::Vector2d(0, 0), Eigen::Vector2d(0.3, -0.2), Eigen::Vector2d(-0.35, 0.25)}) {
      // A round spot about a direction, and where its weight lies in the undistorted image.
      const auto spot = [&](double x, double y) {
        return std::exp(-(Eigen::Vector2d(x, y) - tangent).squaredNorm() / (2 * 0.02 * 0.02));
      };
      Image<float> drawn(lens.width_px, lens.height_px);
      const Eigen::Vector2d middle = *project(lens, tangent.homogeneous());
      for (int y = 0; y < lens.height_px; ++y) {
        for (int x = 0; x < lens.width_px; ++x) {
          if ((Eigen::Vector2d(x, y) - middle).norm() > 30) continue;  // exp(-30) and less
          const Eigen::Vector3d ray = *unproject(lens, {x, y});
          drawn(x, y) = static_cast<float>(spot(ray.x() / ray.z(), ray.y() / ray.z()));
        }
      }
      const Undistorted<float> flat = undistort(drawn, lens, {.width_px = 300, .height_px = 210});
      Eigen::Vector2d sum(0, 0);
      double weight = 0;
      for (int y = 0; y < 210; ++y) {
        for (int x = 0; x < 300; ++x) {
          sum += flat.image(x, y) * Eigen::Vector2d(x, y);
          weight += flat.image(x, y);
        }
      }
      const auto expected = project(flat.camera, tangent.homogeneous());
      ASSERT_TRUE(expected);
      // Interpolation blurs evenly; its uneven part and the float's rounding stay below this.
      EXPECT_LT((sum / weight - *expected).norm(), 0.01) << to_string(lens.model);
    }
  }
}

TEST(Undistort, APinholeImageIsItself) {
  const Camera pinhole{LensModel::pinhole, 40, 30, 50, 51, 19, 14.5, {}, {}};
  Image<Rgb8> image(40, 30);
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x)
      image(x, y) = {static_cast<std::uint8_t>(6 * x), static_cast<std::uint8_t>(8 * y), 200};
  }
  const Undistorted<Rgb8> same = undistort(image, pinhole);
  EXPECT_EQ(same.camera, pinhole);
  // (x - c) / f * f + c may round outside by one bit, so the outermost row may go; no more.
  for (int y = 1; y < 29; ++y) {
    for (int x = 1; x < 39; ++x) {
      EXPECT_EQ(same.valid(x, y), 255);
      EXPECT_EQ(same.image(x, y), image(x, y));
    }
  }
  // A longer focal length shows less, a shorter one a border.
  const Undistorted<Rgb8> wide = undistort(image, pinhole, {.focal_px = 25}, {1, 2, 3});
  EXPECT_EQ(wide.valid(0, 0), 0);
  EXPECT_EQ(wide.image(0, 0), (Rgb8{1, 2, 3}));
  EXPECT_EQ(wide.valid(19, 14), 255);
}

TEST(Undistort, SizeAndFocalLengthAreThoseAskedFor) {
  const Camera lens = lenses()[0];
  const Camera same = undistorted_camera(lens);
  EXPECT_EQ(same.width_px, lens.width_px);
  EXPECT_EQ(same.fx_px, lens.fx_px);
  EXPECT_EQ(same.cy_px, lens.cy_px);
  const Camera half = undistorted_camera(lens, {.width_px = 100, .height_px = 75, .focal_px = 60});
  EXPECT_EQ(half.width_px, 100);
  EXPECT_EQ(half.fx_px, 60);
  EXPECT_EQ(half.fy_px, 60);
  EXPECT_DOUBLE_EQ(half.cx_px, (lens.cx_px + 0.5) / 2 - 0.5);  // counted from the corner
}

TEST(Undistort, NanTouchesItsNeighboursOnly) {
  const Camera lens = lenses()[0];
  Image<float> depth_m(lens.width_px, lens.height_px, 2);
  depth_m(100, 70) = std::numeric_limits<float>::quiet_NaN();
  const Undistorted<float> flat = undistort(depth_m, lens);
  int lost = 0;
  for (std::size_t i = 0; i < flat.image.size(); ++i) {
    if (std::isnan(flat.image.data()[i])) ++lost;
  }
  EXPECT_GE(lost, 1);
  EXPECT_LE(lost, 9);
}

TEST(Undistort, TheSameBytesOnAnyNumberOfThreads) {
  const Camera lens = lenses()[3];
  Image<std::uint8_t> image(lens.width_px, lens.height_px);
  for (std::size_t i = 0; i < image.size(); ++i)
    image.data()[i] = static_cast<std::uint8_t>(i * 2654435761U >> 24);
  const Image<std::uint8_t> first = undistort(image, lens).image;
  for (const std::size_t threads : {1, 2, 7}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    EXPECT_EQ(undistort(image, lens).image, first);
  }
}

TEST(Undistort, MistakesAreRefused) {
  const Camera lens = lenses()[0];
  EXPECT_THROW(undistort(Image<float>(10, 10), lens), std::invalid_argument);
  const Image<float> image(lens.width_px, lens.height_px);
  EXPECT_THROW(undistort(image, lens, {.width_px = -1}), std::invalid_argument);
  EXPECT_THROW(undistort(image, lens, {.width_px = 65535, .height_px = 65535}),
               std::invalid_argument);
  EXPECT_THROW(undistort(image, lens, {.focal_px = std::nan("")}), std::invalid_argument);
  Camera folds = lens;
  folds.distortion = {-2};
  EXPECT_THROW(undistort(image, folds), std::invalid_argument);
}

TEST(Undistort, TheNearestPixelIsTakenWholeAndIdsNeverMix) {
  for (const Camera& lens : lenses()) {
    // Ids of one pixel each: any mixture would be an id of elsewhere.
    Image<std::uint16_t> ids(lens.width_px, lens.height_px);
    for (std::size_t i = 0; i < ids.size(); ++i) ids.data()[i] = static_cast<std::uint16_t>(i);
    const Undistorted<std::uint16_t> taken =
        undistort(ids, lens, {.focal_px = 150, .interpolation = Interpolation::nearest}, 65535);
    int seen = 0;
    for (int y = 0; y < taken.image.height(); ++y) {
      for (int x = 0; x < taken.image.width(); ++x) {
        if (taken.valid(x, y) == 0) {
          EXPECT_EQ(taken.image(x, y), 65535);
          continue;
        }
        ++seen;
        const int id = taken.image(x, y);
        const Eigen::Vector2d from(id % lens.width_px, id / lens.width_px);
        EXPECT_LE((*project(lens, ray_of(taken.camera, x, y)) - from).cwiseAbs().maxCoeff(),
                  0.5 + 1e-9);
      }
    }
    EXPECT_GT(seen, 10000);
  }
  EXPECT_THROW(undistort(Image<std::uint16_t>(200, 150), lenses()[0], {}), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
