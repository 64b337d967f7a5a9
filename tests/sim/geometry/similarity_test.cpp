#include "sim/geometry/similarity.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "sim/types/rng.h"

namespace cousin {
namespace {

using Eigen::Vector3d;

const WorldSimilarity kA_from_b{
    2.5, Eigen::Quaterniond(0.2, 0.5, -0.7, 0.4).normalized(), {10, -3, 4}};

std::vector<Vector3d> random_points(int count, std::uint64_t seed) {
  Rng rng(seed);
  std::vector<Vector3d> points;
  for (int i = 0; i < count; ++i)
    points.emplace_back(uniform(rng, -1, 1), uniform(rng, -1, 1), uniform(rng, -1, 1));
  return points;
}

TEST(Similarity, IsFoundFromItsPoints) {
  const std::vector<Vector3d> in_b = random_points(5, 1);
  std::vector<Vector3d> in_a;
  for (const Vector3d& point : in_b) in_a.push_back(kA_from_b * point);
  const SimilarityFit fit = fit_similarity(in_a, in_b);
  ASSERT_TRUE(fit.ok);
  EXPECT_NEAR(fit.a_from_b.scale, 2.5, 1e-12);
  EXPECT_NEAR(angle_rad(fit.a_from_b.rotation * kA_from_b.rotation.conjugate()), 0, 1e-7);
  EXPECT_NEAR((fit.a_from_b.shift_m - kA_from_b.shift_m).norm(), 0, 1e-12);
  EXPECT_NEAR(fit.rms_m, 0, 1e-12);
  const SimilarityFit rigid = fit_similarity(in_a, in_b, ScaleFreedom::fixed);
  EXPECT_EQ(rigid.a_from_b.scale, 1);
  EXPECT_GT(rigid.rms_m, 0.5);
}

TEST(Similarity, AMovedCameraSeesAMovedWorldAsBefore) {
  const Pose camera_from_b{Eigen::Quaterniond(1, 0.2, -0.3, 0.1).normalized(), {0.1, 0.2, 3}};
  const Vector3d point(0.3, -0.2, 0.5);
  const Vector3d before = camera_from_b * point;
  const Vector3d after = moved(camera_from_b, kA_from_b) * (kA_from_b * point);
  EXPECT_NEAR((after - 2.5 * before).norm(), 0, 1e-12);
  EXPECT_NEAR((centre_in_world_m(moved(camera_from_b, kA_from_b)) -
               kA_from_b * centre_in_world_m(camera_from_b))
                  .norm(),
              0, 1e-12);
}

TEST(Similarity, ThePredictedDeviationOfTheScaleIsItsSpread) {
  const std::vector<Vector3d> in_b = random_points(20, 2);
  Rng rng = Rng(3);
  double squares = 0, predicted = 0;
  constexpr int kRuns = 1000;
  for (int run = 0; run < kRuns; ++run) {
    std::vector<Vector3d> in_a;
    for (const Vector3d& point : in_b)
      in_a.push_back(kA_from_b * point + 0.02 * Vector3d(normal(rng), normal(rng), normal(rng)));
    const SimilarityFit fit = fit_similarity(in_a, in_b);
    squares += std::pow(fit.a_from_b.scale / 2.5 - 1, 2) / kRuns;
    predicted += fit.scale_sigma_share * fit.scale_sigma_share / kRuns;
  }
  // A variance of 1000 draws has a relative standard error of sqrt(2 / 1000) = 4.5 %; allow five.
  EXPECT_NEAR(squares / predicted, 1, 5 * 0.045);
}

TEST(Similarity, PointsOnALineOrTooFewGiveNone) {
  std::vector<Vector3d> line;
  for (int i = 0; i < 5; ++i) line.emplace_back(i, 2 * i, -i);
  EXPECT_FALSE(fit_similarity(line, line).ok);
  EXPECT_FALSE(fit_similarity({line[0], line[1]}, {line[0], line[1]}).ok);
  EXPECT_THROW(fit_similarity(line, {}), std::invalid_argument);
}

}  // namespace
}  // namespace cousin
