#include "sim/render/ray_query.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "sim/types/rng.h"
#include "tests/sim/render/test_scenes.h"

namespace cousin::test {
namespace {

TEST(RayQuery, LeavingAConvexBodyNeverMeetsItAtAnyScaleOrPlace) {
  for (const double scale_m : {1e-4, 1.0, 1e4}) {
    for (const double offset_m : {0.0, 1e5}) {
      Scene scene;
      Pose pose;
      pose.translation_m = Eigen::Vector3d(offset_m, -offset_m, offset_m);
      pose.rotation = Eigen::Quaterniond(0.9, 0.3, -0.2, 0.4).normalized();
      const Eigen::Vector3d half = scale_m * Eigen::Vector3d(1, 0.6, 0.01);
      add(scene, box(-half, half), matt(0.5F), pose);
      const RayScene rays(scene);
      Rng rng(7);
      for (int i = 0; i < 2000; ++i) {
        const Eigen::Vector3d from(normal(rng), normal(rng), normal(rng));
        const Eigen::Vector3d aim =
            0.3 * scale_m * Eigen::Vector3d(normal(rng), normal(rng), normal(rng));
        const Eigen::Vector3d eye = 5 * scale_m * from.normalized();
        const RayAnswer hit = cast_ray(rays, pose.translation_m + eye, (aim - eye).normalized());
        if (!hit.hit) continue;
        Eigen::Vector3d out = Eigen::Vector3d(normal(rng), normal(rng), normal(rng)).normalized();
        if (out.dot(hit.normal) < 0) out = -out;
        EXPECT_FALSE(cast_from(rays, hit, out).hit) << scale_m << " " << offset_m;
        const RayAnswer inside = cast_from(rays, hit, -out);
        EXPECT_TRUE(inside.hit && inside.is_back) << scale_m << " " << offset_m;
      }
    }
  }
}

TEST(RayQuery, PacketsCountEveryRayThatMeetsAWall) {
  Scene scene;
  add(scene, square(10), matt(0.5F));
  const RayScene rays(scene);
  const TrueView view =
      view_from(strong_lens(LensModel::opencv5, 37, 21, 60), {0.1, 0.2, 1}, {0, 0, 0});
  EXPECT_EQ(cast_packets(rays, prepare_rays(rays, view)), 37 * 21);
}

}  // namespace
}  // namespace cousin::test
