#include "sim/imaging/rectification.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "sim/types/rng.h"

namespace cousin {
namespace {

/// Two lenses such as a ZED's: unequal centres and distortion, vergence, a little roll and tilt.
struct Rig {
  Camera left, right;
  Pose right_from_left;
};

Rig verging_rig() {
  Rig rig;
  rig.left.model = LensModel::opencv5;
  rig.left.width_px = 320;
  rig.left.height_px = 240;
  rig.left.fx_px = 260;
  rig.left.fy_px = 261;
  rig.left.cx_px = 162;
  rig.left.cy_px = 121;
  rig.left.distortion = {-0.17, 0.028, 1e-4, -2e-4};
  rig.right = rig.left;
  rig.right.cx_px = 154;
  rig.right.cy_px = 128;
  rig.right.distortion = {-0.16, 0.025, -1e-4, 1e-4};
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.00624 * 3, Eigen::Vector3d::UnitY()) *
                                Eigen::AngleAxisd(-0.0009 * 5, Eigen::Vector3d::UnitX()) *
                                Eigen::AngleAxisd(0.0008 * 5, Eigen::Vector3d::UnitZ()));
  rig.right_from_left = {turn, turn * Eigen::Vector3d(-0.12, -0.0005, 0.0003)};
  return rig;
}

/// A random number for a node of a lattice, the same after 256 nodes.
double node(int i, int j) {
  static const std::vector<double> nodes = [] {
    Rng rng(3);
    std::vector<double> values(256 * 256);
    for (double& v : values) v = uniform(rng);
    return values;
  }();
  return nodes[static_cast<std::size_t>((i & 255) * 256 + (j & 255))];
}

/// A texture over a plane, smooth bumps of `size_m`.
double texture(double x_m, double y_m, double size_m) {
  double sum = 0, weight = 0;
  const double u = x_m / size_m, v = y_m / size_m;
  const int cx = static_cast<int>(std::floor(u)), cy = static_cast<int>(std::floor(v));
  for (int j = cy - 2; j <= cy + 3; ++j) {
    for (int i = cx - 2; i <= cx + 3; ++i) {
      const double w = std::exp(-(u - i) * (u - i) - (v - j) * (v - j));
      sum += w * node(i, j);
      weight += w;
    }
  }
  return 255 * sum / weight;
}

/// The wall z = 1.5 m (of the left camera) as a lens sees it.
Image<Rgb8> see_wall(const Camera& lens, const Pose& lens_from_left) {
  const Pose left_from_lens = inverse(lens_from_left);
  Image<Rgb8> image(lens.width_px, lens.height_px);
  for (int y = 0; y < lens.height_px; ++y) {
    for (int x = 0; x < lens.width_px; ++x) {
      const auto ray = unproject(lens, {x, y});
      if (!ray) continue;
      const Eigen::Vector3d d = left_from_lens.rotation * *ray;
      const Eigen::Vector3d& o = left_from_lens.translation_m;
      const Eigen::Vector3d p = o + d * ((1.5 - o.z()) / d.z());
      const auto v = static_cast<std::uint8_t>(std::lround(texture(p.x(), p.y(), 0.012)));
      image(x, y) = {v, v, v};
    }
  }
  return image;
}

TEST(Rectification, PutsTheSamePointIntoTheSameRowOfBothImages) {
  const Rig rig = verging_rig();
  const Rectification r = rectify(rig.left, rig.right, rig.right_from_left);
  EXPECT_NEAR(r.baseline_m, std::sqrt(0.12 * 0.12 + 0.0005 * 0.0005 + 0.0003 * 0.0003), 1e-12);
  for (const Eigen::Vector3d& p : {Eigen::Vector3d(0.1, 0.2, 1), Eigen::Vector3d(-0.3, 0.1, 0.7),
                                   Eigen::Vector3d(0.5, -0.6, 3)}) {
    const auto left = project(r.camera, r.rectified_from_left * p);
    const auto right = project(r.camera, r.rectified_from_right * (rig.right_from_left * p));
    ASSERT_TRUE(left && right);
    EXPECT_NEAR(left->y(), right->y(), 1e-9);
    const double depth_m = (r.rectified_from_left * p).z();
    EXPECT_NEAR(left->x() - right->x(), r.camera.fx_px * r.baseline_m / depth_m, 1e-9);
  }
}

TEST(Rectification, MapsLeadToWhereTheLensSeesTheRay) {
  const Rig rig = verging_rig();
  const Rectification r = rectify(rig.left, rig.right, rig.right_from_left);
  const Eigen::Vector3d ray((200 - r.camera.cx_px) / r.camera.fx_px,
                            (50 - r.camera.cy_px) / r.camera.fy_px, 1);
  const auto pixel = project(rig.right, r.rectified_from_right.transpose() * ray);
  ASSERT_TRUE(pixel);
  EXPECT_NEAR((r.right_px(200, 50).cast<double>() - *pixel).norm(), 0, 1e-4);  // floats
}

TEST(Rectification, PassiveStereoMeasuresAWallThroughVergingLenses) {
  const Rig rig = verging_rig();
  const Rectification r = rectify(rig.left, rig.right, rig.right_from_left);
  const PassiveDepth found = passive_depth(
      see_wall(rig.left, {}), see_wall(rig.right, rig.right_from_left), r, {.range_px = 40});
  double n = 0, sum = 0, squares = 0;
  for (int y = 30; y < 210; ++y) {
    for (int x = 60; x < 290; ++x) {
      const auto z = static_cast<double>(found.depth_m(x, y));
      if (std::isnan(z)) continue;
      // The wall is square to the left camera, not to the rectified one.
      const Eigen::Vector3d ray = r.rectified_from_left.transpose() *
                                  Eigen::Vector3d((x - r.camera.cx_px) / r.camera.fx_px,
                                                  (y - r.camera.cy_px) / r.camera.fy_px, 1);
      const double error_px = r.camera.fx_px * r.baseline_m * (1 / z - ray.z() / 1.5);
      n += 1;
      sum += error_px;
      squares += error_px * error_px;
    }
  }
  EXPECT_GT(n, 0.95 * 180 * 230);
  // Unrectified, the vergence alone would shift disparities by 260 * 0.0187 = 4.9 px.
  EXPECT_NEAR(sum / n, 0, 0.05);
  EXPECT_LT(std::sqrt(squares / n), 0.2);  // the census of a texture resampled twice
}

TEST(Rectification, RejectsWhatHasNoCommonRows) {
  const Rig rig = verging_rig();
  Pose same;
  EXPECT_THROW(rectify(rig.left, rig.right, same), std::invalid_argument);
  Pose behind;
  behind.translation_m = {0, 0, 0.1};
  EXPECT_THROW(rectify(rig.left, rig.right, behind), std::invalid_argument);
  Pose swapped;
  swapped.translation_m = {0.1, 0, 0};  // the "right" camera is on the left
  EXPECT_THROW(rectify(rig.left, rig.right, swapped), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
