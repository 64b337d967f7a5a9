#include "perception/silhouette/surface_fit.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>

#include "tests/perception/silhouette/convex_bodies.h"

namespace cousin {
namespace {

/// Fewer harmonics and samples than a real run: the bodies are smooth, and the tests quick.
const SurfaceFitConfig kConfig{.degree = 10, .subdivisions = 4, .samples = 16};

Surface fit(const Mesh& body, int views, double sigma_px, const SurfaceFitConfig& config, Rng rng) {
  const Poses poses = make_poses(views);
  return fit_surfaces(poses, make_cloud(body, 7e-5, rng.fork("cloud")),
                      make_outlines(body, poses, sigma_px, rng.fork("outlines")), config,
                      rng.fork("fit"))
      .at(0);
}

TEST(SurfaceFit, ExactOutlinesGiveTheBody) {
  // What a polygon of this mesh cuts off an ellipsoid is 0.1 %; 5 um is a tenth of a pixel in one
  // view.
  const Mesh body = make_ellipsoid({0.0033, 0.0017, 0.0015});
  const Surface surface = fit(body, 30, 0.003, kConfig, Rng(1));
  ASSERT_EQ(surface.status, SurfaceStatus::ok);
  EXPECT_NEAR(volume_m3(surface.mesh) / volume_m3(body), 1, 0.005);
  EXPECT_NEAR(area_m2(surface.mesh) / area_m2(body), 1, 0.003);
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d direction = Eigen::Vector3d::Unit(axis);
    EXPECT_NEAR(width_m(surface.mesh, direction), width_m(body, direction), 1e-5);
  }
}

TEST(SurfaceFit, SphereOf22MillimetresWithoutASpherePrior) {
  const Mesh body = make_ellipsoid(Eigen::Vector3d::Constant(0.011));
  const Surface surface = fit(body, 30, 0.1, kConfig, Rng(2));
  ASSERT_EQ(surface.status, SurfaceStatus::ok);
  EXPECT_NEAR(volume_m3(surface.mesh) / volume_m3(body), 1, 0.01);  // the project's own targets
  EXPECT_NEAR(area_m2(surface.mesh) / area_m2(body), 1, 0.01);
}

TEST(SurfaceFit, WedgeWithFlatFacesKeepsItsVolume) {
  const Mesh body = make_wedge({0.0055, 0.004, 0.0025}, 3, 0.25, 0.05);
  const Surface surface = fit(body, 30, 0.05, kConfig, Rng(3));
  ASSERT_EQ(surface.status, SurfaceStatus::ok);
  EXPECT_NEAR(volume_m3(surface.mesh) / volume_m3(body), 1, 0.02);
  EXPECT_NEAR(area_m2(surface.mesh) / area_m2(body), 1, 0.015);
}

TEST(SurfaceFit, PredictedSpreadCoversTheError) {
  // Volumes of twelve noisy fits: mean square of error over sigma. Chi-squared with 12 degrees of
  // freedom is within [0.25, 2.4] times 12 with 99.8 %; sigma also holds a bias of the outlines
  // that is absent here, so only the top counts.
  const Mesh body = make_ellipsoid({0.0033, 0.0017, 0.0015});
  double sum = 0;
  for (std::uint64_t trial = 0; trial < 12; ++trial) {
    const Surface surface = fit(body, 18, 0.1, kConfig, Rng(10).fork(trial));
    ASSERT_EQ(surface.status, SurfaceStatus::ok);
    const double measured = volume_m3(surface.mesh);
    double square = 0;
    for (const auto& sample : surface.samples_m) {
      const double change = volume_m3({sample, surface.mesh.triangles}) - measured;
      square += change * change / static_cast<double>(surface.samples_m.size());
    }
    EXPECT_LT(std::sqrt(square), 0.05 * measured);
    sum += std::pow(measured - volume_m3(body), 2) / square;
  }
  EXPECT_LT(sum / 12, 2.4);
}

TEST(SurfaceFit, MeshIsClosedOutwardAndOnTheBoard) {
  const Surface surface =
      fit(make_wedge({0.0055, 0.004, 0.0025}, 3, 0.2, 0.1), 18, 0.1, kConfig, Rng(5));
  ASSERT_EQ(surface.status, SurfaceStatus::ok);
  EXPECT_EQ(surface.mesh.vertices_m.size(), 2562U);
  EXPECT_EQ(surface.mesh.triangles.size(), 5120U);
  EXPECT_GT(volume_m3(surface.mesh), 0);
  double lowest_m = 1;
  for (const Eigen::Vector3d& vertex : surface.mesh.vertices_m)
    lowest_m = std::min(lowest_m, vertex.z());
  EXPECT_NEAR(lowest_m, 0, 3e-5);  // three times plane_sigma_m
}

TEST(SurfaceFit, SaysWhatItCannotSolve) {
  const Mesh body = make_ellipsoid({0.0033, 0.0017, 0.0015});
  EXPECT_EQ(fit(body, 2, 0.1, kConfig, Rng(6)).status, SurfaceStatus::too_few_views);
  Clusters nothing;
  nothing.count = 1;
  const Surfaces surfaces = fit_surfaces(make_poses(6), nothing, {}, kConfig, Rng(6));
  ASSERT_EQ(surfaces.size(), 1U);
  EXPECT_EQ(surfaces[0].status, SurfaceStatus::empty);
  EXPECT_TRUE(fit_surfaces({}, {}, {}, kConfig, Rng(6)).empty());

  SurfaceFitConfig no_data = kConfig;
  no_data.use_cloud = no_data.use_outlines = false;
  EXPECT_THROW(fit_surfaces({}, {}, {}, no_data, Rng(6)), std::invalid_argument);
}

TEST(SurfaceFit, EmptyMasksAreTooFewViews) {
  const Mesh body = make_ellipsoid({0.0033, 0.0017, 0.0015});
  const Poses poses = make_poses(18);
  Silhouettes silhouettes = make_outlines(body, poses, 0.1, Rng(12));
  for (std::size_t i = 2; i < silhouettes.size(); ++i) silhouettes[i].outline.clear();
  const Clusters cloud = make_cloud(body, 7e-5, Rng(13));
  const Surfaces surfaces = fit_surfaces(poses, cloud, silhouettes, kConfig, Rng(14));
  EXPECT_EQ(surfaces.at(0).status, SurfaceStatus::too_few_views);
}

bool is_inside(const Eigen::Vector2f& point, const std::vector<OutlinePoint>& outline) {
  bool inside = false;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2f a = outline[i].pixel_px - point;
    const Eigen::Vector2f b = outline[(i + 1) % outline.size()].pixel_px - point;
    if ((a.y() > 0) == (b.y() > 0)) continue;
    if (a.x() + (b.x() - a.x()) * a.y() / (a.y() - b.y()) > 0) inside = !inside;
  }
  return inside;
}

/// Outline of two overlapping bodies: the points of each that the other does not hide, around the
/// middle of those where the outlines cross.
Silhouette joined(const Silhouette& a, const Silhouette& b, const Eigen::Vector2f& middle_px) {
  Silhouette both = a;
  both.outline.clear();
  for (const auto& [own, other] : {std::pair{&a, &b}, std::pair{&b, &a}}) {
    for (const OutlinePoint& point : own->outline) {
      if (!is_inside(point.pixel_px, other->outline)) both.outline.push_back(point);
    }
  }
  const auto angle = [&](const OutlinePoint& point) {
    const Eigen::Vector2f ray = point.pixel_px - middle_px;
    return std::atan2(ray.y(), ray.x());
  };
  const bool turns = [&] {  // outlines keep their sense of turning
    double area = 0;
    for (std::size_t i = 0; i < a.outline.size(); ++i) {
      const auto& p = a.outline[i].pixel_px;
      const auto& q = a.outline[(i + 1) % a.outline.size()].pixel_px;
      area += p.x() * q.y() - p.y() * q.x();
    }
    return area > 0;
  }();
  std::sort(both.outline.begin(), both.outline.end(),
            [&](const OutlinePoint& p, const OutlinePoint& q) {
              return turns ? angle(p) < angle(q) : angle(p) > angle(q);
            });
  return both;
}

TEST(SurfaceFit, TwoSeedsThatTouchAreNotOne) {
  // Two ellipsoids tip to tip, 0.3 mm into each other, clustered as one object.
  const Poses poses = make_poses(18);
  std::vector<Mesh> seeds(2, make_ellipsoid({0.0033, 0.0017, 0.0015}));
  Clusters cloud;
  cloud.count = 1;
  std::vector<Silhouettes> outlines;
  for (std::size_t i = 0; i < 2; ++i) {
    for (Eigen::Vector3d& v : seeds[i].vertices_m) v.x() += i == 0 ? -0.00315 : 0.00315;
    const Clusters part = make_cloud(seeds[i], 7e-5, Rng(15).fork(i));
    cloud.cloud.insert(cloud.cloud.end(), part.cloud.begin(), part.cloud.end());
    cloud.instance.insert(cloud.instance.end(), part.instance.begin(), part.instance.end());
    outlines.push_back(make_outlines(seeds[i], poses, 0.1, Rng(16).fork(i)));
  }
  Silhouettes both;
  for (std::size_t i = 0; i < outlines[0].size(); ++i) {
    const FramePose& pose = poses[static_cast<std::size_t>(outlines[0][i].frame)];
    const auto middle =
        project(pose.camera, pose.camera_from_world * Eigen::Vector3d(0, 0, 0.0015));
    both.push_back(joined(outlines[0][i], outlines[1][i], middle->cast<float>()));
  }
  const Surface surface = fit_surfaces(poses, cloud, both, kConfig, Rng(17)).at(0);
  EXPECT_EQ(surface.status, SurfaceStatus::touching) << to_string(surface.status);
}

TEST(SurfaceFit, OutlinesOfAnotherBodyAreNotAccepted) {
  // Outlines 6 mm from the cloud: the fit must not answer ok with a surface that joins both.
  const Poses poses = make_poses(18);
  const Clusters clusters = make_cloud(make_ellipsoid({0.0033, 0.0017, 0.0015}), 7e-5, Rng(7));
  Mesh elsewhere = make_ellipsoid({0.0033, 0.0017, 0.0015});
  for (Eigen::Vector3d& vertex : elsewhere.vertices_m) vertex.x() += 0.012;
  const Silhouettes wrong = make_outlines(elsewhere, poses, 0.1, Rng(8));
  const Surface surface = fit_surfaces(poses, clusters, wrong, kConfig, Rng(9)).at(0);
  EXPECT_EQ(surface.status, SurfaceStatus::not_converged) << to_string(surface.status);
  EXPECT_TRUE(surface.mesh.triangles.empty());
}

TEST(SurfaceFit, SameOnAnyNumberOfThreads) {
  const Mesh body = make_ellipsoid({0.0033, 0.0017, 0.0015});
  std::vector<Surface> results;
  for (const std::size_t threads : {1, 2, 7}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    results.push_back(fit(body, 12, 0.1, kConfig, Rng(11)));
  }
  for (const Surface& result : results) {
    EXPECT_EQ(result.mesh.vertices_m, results[0].mesh.vertices_m);
    EXPECT_EQ(result.samples_m, results[0].samples_m);
  }
}

}  // namespace
}  // namespace cousin
