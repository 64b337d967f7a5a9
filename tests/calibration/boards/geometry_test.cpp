#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "calibration/boards/board_template.h"
#include "calibration/boards/homography.h"
#include "calibration/boards/lens_jacobian.h"
#include "calibration/boards/planar_pose.h"
#include "sim/types/rng.h"
#include "tests/calibration/boards/synthetic_board.h"

namespace cousin {
namespace {

const std::vector<LensModel> kLenses = {LensModel::pinhole, LensModel::opencv5, LensModel::opencv8,
                                        LensModel::opencv12, LensModel::kannala_brandt4};

TEST(LensJacobian, MatchesDifferences) {
  const Eigen::Vector3d point(0.11, -0.07, 0.4);
  for (const LensModel model : kLenses) {
    const Camera camera = synthetic::phone_camera(1280, model);
    const auto jacobian = d_pixel_d_distortion(camera, point);
    ASSERT_EQ(jacobian.cols(), distortion_count(model));
    for (int i = 0; i < jacobian.cols(); ++i) {
      constexpr double kStep = 1e-5;
      Camera more = camera, less = camera;
      more.distortion[static_cast<std::size_t>(i)] += kStep;
      less.distortion[static_cast<std::size_t>(i)] -= kStep;
      const Eigen::Vector2d difference =
          (*project(more, point) - *project(less, point)) / (2 * kStep);
      // Central differences: rounding 1e-13 * 1000 px / 1e-5, and the cubic term far below it.
      EXPECT_LT((jacobian.col(i) - difference).norm(), 1e-4) << to_string(model) << " " << i;
    }
  }
}

TEST(Homography, IsRecoveredFromExactPointsAndKeepsAnOutlierOut) {
  Eigen::Matrix3d truth;
  truth << 1.2, 0.1, 0.3, -0.2, 0.9, -0.1, 0.4, -0.3, 2.0;
  std::vector<PlanePoint> points;
  for (int i = 0; i < 5; ++i) {
    for (int j = 0; j < 5; ++j) {
      const Eigen::Vector2d p(0.1 * i, 0.1 * j);
      points.push_back({p, transfer(truth, p), 1e-3});
    }
  }
  HomographyFit fit = fit_homography(points);
  ASSERT_TRUE(fit.ok);
  for (const PlanePoint& p : points) {
    EXPECT_LT((transfer(fit.normalized_from_plane, p.in_plane) - p.normalized).norm(), 1e-12);
  }
  points[7].normalized.x() += 0.05;
  fit = fit_homography(points);
  ASSERT_TRUE(fit.ok);
  EXPECT_GT(fit.residual[7], 20);  // 50 sigma off; the fit moves by a fraction of it
}

TEST(Homography, PointsOnALineAreRefused) {
  std::vector<PlanePoint> points;
  for (int i = 0; i < 10; ++i)
    points.push_back({Eigen::Vector2d(0.1 * i, 0), Eigen::Vector2d(0.2 * i, 0.1 * i), 1});
  EXPECT_FALSE(fit_homography(points).ok);
}

TEST(BoardPattern, AgreesWithTheBoardsOwnAnswer) {
  for (const bool markers : {true, false}) {
    SeedBoard board;
    board.has_markers = markers;
    const BoardPattern pattern(board);
    for (int i = 0; i < 400; ++i) {
      for (int j = 0; j < 400; ++j) {
        // Off the edges of squares and modules, where float and double may differ.
        const double x = -0.0499 + 0.0998 * (i + 0.37) / 400,
                     y = -0.0499 + 0.0998 * (j + 0.61) / 400;
        const Eigen::Vector3d s = pattern.squares_from_board() * Eigen::Vector3d(x, y, 1);
        ASSERT_EQ(pattern.is_white(static_cast<float>(s.x()), static_cast<float>(s.y())),
                  !is_black(board, x, y))
            << x << " " << y;
      }
    }
  }
}

TEST(Whitening, MakesTheCovarianceUnit) {
  Eigen::Matrix2d covariance;
  covariance << 4, -1.9, -1.9, 1;
  const Eigen::Matrix2d white = whitening(covariance);
  EXPECT_LT((white * covariance * white.transpose() - Eigen::Matrix2d::Identity()).norm(), 1e-12);
}

TEST(PlanarPose, IsExactForEveryLensAndTilt) {
  const SeedBoard board;
  for (const LensModel model : kLenses) {
    const Camera camera = synthetic::phone_camera(1280, model);
    for (const double elevation : {0.2, 0.7, 1.2, 1.5}) {
      const Pose truth = synthetic::orbit(0.5, elevation, 1.0, 2.0);
      std::vector<BoardPoint> points;
      for (int row = 0; row < 14; row += 3) {
        for (int column = 0; column < 14; column += 3) {
          const Eigen::Vector3d p = corner_in_world_m(board, column, row);
          points.push_back({p, project(camera, truth * p).value()});
        }
      }
      const PlanarPose pose = estimate_planar_pose(camera, points);
      ASSERT_TRUE(pose.ok);
      // Unprojection agrees to 1e-9 of the focal length; at 11 degrees it is amplified a few
      // hundred times.
      EXPECT_LT((centre_in_world_m(pose.camera_from_board) - centre_in_world_m(truth)).norm(),
                1e-6);
    }
  }
}

/// A 20 mm board: near and tilted, or far and nearly frontal.
std::vector<BoardPoint> small_board(const Camera& camera, const Pose& truth, double sigma_px,
                                    std::uint64_t seed) {
  Rng rng(seed);
  std::vector<BoardPoint> points;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      const Eigen::Vector3d p(0.006 * column - 0.009, 0.006 * row - 0.009, 0);
      const double dx = sigma_px * normal(rng), dy = sigma_px * normal(rng);
      points.push_back({p, project(camera, truth * p).value() + Eigen::Vector2d(dx, dy),
                        sigma_px * sigma_px * Eigen::Matrix2d::Identity()});
    }
  }
  return points;
}

TEST(PlanarPose, TwoPosesThatExplainThePointsAreSaid) {
  const Camera camera = synthetic::phone_camera(1280);
  const Pose far = synthetic::orbit(1.0, 1.3, 1.0, 1.0),
             near = synthetic::orbit(0.15, 0.6, 1.0, 1.0);
  int far_wrong_unsaid = 0, far_ambiguous = 0;
  constexpr int kRuns = 40;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    const PlanarPose a = estimate_planar_pose(camera, small_board(camera, far, 0.1, seed));
    ASSERT_TRUE(a.ok);
    far_ambiguous += a.is_ambiguous ? 1 : 0;
    const bool is_mirrored = a.camera_from_board.rotation.angularDistance(far.rotation) > 0.26;
    far_wrong_unsaid += is_mirrored && !a.is_ambiguous ? 1 : 0;
    const PlanarPose b = estimate_planar_pose(camera, small_board(camera, near, 0.1, seed));
    EXPECT_TRUE(b.ok && !b.is_ambiguous);
  }
  EXPECT_GT(far_ambiguous, kRuns / 2);
  EXPECT_EQ(far_wrong_unsaid, 0);
}

TEST(PlanarPose, FewOrCollinearPointsAreRefused) {
  const Camera camera = synthetic::phone_camera(1280);
  const Pose truth = synthetic::orbit(0.5, 0.7, 1.0);
  std::vector<BoardPoint> points;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d p(0.01 * i - 0.04, 0.01, 0);
    points.push_back({p, project(camera, truth * p).value()});
  }
  EXPECT_FALSE(estimate_planar_pose(camera, points).ok);
  points.resize(3);
  EXPECT_FALSE(estimate_planar_pose(camera, points).ok);
}

}  // namespace
}  // namespace cousin
