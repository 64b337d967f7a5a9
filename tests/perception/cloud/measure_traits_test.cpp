#include "perception/cloud/measure_traits.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/geometry/measure.h"
#include "sim/types/rng.h"

namespace cousin {
namespace {

/// Points of a block, evenly spaced through its inside and surface, turned and moved.
std::vector<Eigen::Vector3d> block_points(const Eigen::Vector3d& size_m, int steps) {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()));
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i <= steps; ++i) {
    for (int j = 0; j <= steps; ++j) {
      for (int k = 0; k <= steps; ++k) {
        const Eigen::Vector3d share =
            Eigen::Vector3d(i, j, k) / steps - Eigen::Vector3d::Constant(0.5);
        points.push_back(turn * share.cwiseProduct(size_m) + Eigen::Vector3d(0.01, 0.02, 0.03));
      }
    }
  }
  return points;
}

Surface block_surface(const Eigen::Vector3d& size_m) {
  Surface surface;
  surface.instance = 3;
  surface.status = SurfaceStatus::ok;
  surface.mesh = convex_hull(block_points(size_m, 1));
  return surface;
}

double value_of(const SpecimenTraits& traits, const std::string& name) {
  for (const Trait& t : traits.traits) {
    if (t.name == name) return t.value;
  }
  return kNaN;
}
double sigma_of(const SpecimenTraits& traits, const std::string& name) {
  for (const Trait& t : traits.traits) {
    if (t.name == name) return t.sigma;
  }
  return kNaN;
}

const Eigen::Vector3d kSize{0.010, 0.006, 0.004};

TEST(PaperTraits, OfABlockOfPointsAreItsSizes) {
  Surface surface;
  surface.status = SurfaceStatus::ok;
  surface.points_m = block_points(kSize, 10);
  const SpecimenTraits traits = traits_as_paper({surface}).front();
  ASSERT_EQ(traits.status, TraitStatus::ok) << traits.reason;
  EXPECT_NEAR(value_of(traits, "length"), 0.010, 1e-9);
  EXPECT_NEAR(value_of(traits, "width"), 0.006, 1e-9);
  EXPECT_NEAR(value_of(traits, "height"), 0.004, 1e-9);
  // A grid is cospherical everywhere: Qhull's joggle or flat tetrahedra cost a little.
  EXPECT_NEAR(value_of(traits, "volume"), 2.4e-7, 0.02 * 2.4e-7);
  EXPECT_NEAR(value_of(traits, "area"), 2.48e-4, 0.05 * 2.48e-4);
  EXPECT_TRUE(std::isnan(sigma_of(traits, "length")));
  EXPECT_LT((traits.centroid_in_world_m - Eigen::Vector3d(0.01, 0.02, 0.03)).norm(), 1e-9);
}

// What stereo and Gaussians deliver: points on what cameras saw, none inside, none underneath. Its
// volume is the ball's, less the cap that no view sees, for a grain and for the paper's sphere of
// 22 mm alike.
TEST(PaperTraits, OfAnOpenShellAreThoseOfTheSolid) {
  for (const double radius_m : {0.002, 0.011}) {
    Surface surface;
    surface.status = SurfaceStatus::ok;
    Rng rng(11);
    while (surface.points_m.size() < 3000) {
      const Eigen::Vector3d p = Eigen::Vector3d(normal(rng), normal(rng), normal(rng)).normalized();
      if (p.z() > -0.6) surface.points_m.push_back(radius_m * (1 + 0.003 * normal(rng)) * p);
    }
    const SpecimenTraits traits = traits_as_paper({surface}).front();
    ASSERT_EQ(traits.status, TraitStatus::ok) << traits.reason;
    // The hull of points that scatter by 0.3 % of the radius lies outwards by up to two of it,
    // which is 1.2 % of the area and 1.8 % of the volume; chords of 3000 points take some of it
    // back.
    const double cap = 0.4, radius3 = std::pow(radius_m, 3);  // its height in radii
    const double pi = std::numbers::pi;
    const double volume_m3 = pi * radius3 * (4.0 / 3 - cap * cap * (3 - cap) / 3);
    EXPECT_NEAR(value_of(traits, "volume") / volume_m3, 1, 0.015) << radius_m;
    const double area_m2 = pi * radius_m * radius_m * (4 - 2 * cap + (2 * cap - cap * cap));
    EXPECT_NEAR(value_of(traits, "area") / area_m2, 1, 0.015) << radius_m;
  }
}

// Creases and dents are what a small alpha shows, if points fill the inside.
TEST(PaperTraits, AlphaIsAShareOfTheLength) {
  Surface surface;
  surface.points_m = block_points(kSize, 20);  // 0.5, 0.3 and 0.2 mm apart: spheres of 0.31 mm
  PaperTraitConfig config;
  config.alpha_of_length = 0.03;
  EXPECT_EQ(traits_as_paper({surface}, config).front().status, TraitStatus::not_solved);
  config.alpha_of_length = 0.033;
  const SpecimenTraits traits = traits_as_paper({surface}, config).front();
  ASSERT_EQ(traits.status, TraitStatus::ok) << traits.reason;
  EXPECT_NEAR(value_of(traits, "volume"), 2.4e-7, 1e-9);
}

TEST(PaperTraits, DegenerateClustersAreNotSolvedAndSayWhy) {
  Surfaces surfaces(4);
  for (int i = 0; i < 4; ++i) surfaces[static_cast<std::size_t>(i)].instance = i;
  surfaces[1].points_m.assign(3, Eigen::Vector3d::Zero());
  for (int i = 0; i < 100; ++i)
    surfaces[2].points_m.emplace_back(0.001 * (i % 10), 0.001 * (i / 10), 0);  // a plane
  surfaces[3].points_m.assign(10, Eigen::Vector3d(0, 0, kNaN));
  for (const SpecimenTraits& t : traits_as_paper(surfaces)) {
    EXPECT_EQ(t.status, TraitStatus::not_solved);
    EXPECT_FALSE(t.reason.empty());
    EXPECT_TRUE(t.traits.empty());
  }
}

constexpr double kPixel_m = 1e-3;

TEST(MeshTraits, OfABlockAreExact) {
  const SpecimenTraits traits = traits_of_meshes({block_surface(kSize)}, kPixel_m).front();
  ASSERT_EQ(traits.status, TraitStatus::ok) << traits.reason;
  EXPECT_EQ(traits.instance, 3);
  EXPECT_NEAR(value_of(traits, "length"), 0.010, 1e-9);
  EXPECT_NEAR(value_of(traits, "width"), 0.006, 1e-9);
  EXPECT_NEAR(value_of(traits, "height"), 0.004, 1e-9);
  EXPECT_NEAR(value_of(traits, "area"), 2.48e-4, 1e-12);
  EXPECT_NEAR(value_of(traits, "volume"), 2.4e-7, 1e-15);
  EXPECT_TRUE(std::isnan(sigma_of(traits, "length")));
}

TEST(MeshTraits, SigmaIsTheSpreadOfTheSamples) {
  Surface surface = block_surface(kSize);
  const Eigen::Vector3d middle(0.01, 0.02, 0.03);
  Rng rng(4);
  constexpr int kSamples = 200;
  constexpr double kScaleSigma = 0.01;
  for (int i = 0; i < kSamples; ++i) {
    std::vector<Eigen::Vector3d> sample = surface.mesh.vertices_m;
    const double scale = 1 + kScaleSigma * normal(rng);
    for (Eigen::Vector3d& p : sample) p = middle + scale * (p - middle);
    surface.samples_m.push_back(std::move(sample));
  }
  const SpecimenTraits traits = traits_of_meshes({surface}, kPixel_m, {0, 0, 0, 0, 0}).front();
  // The relative standard error of a sigma of 200 samples is 5 %; allow four.
  EXPECT_NEAR(sigma_of(traits, "length") / 0.010, kScaleSigma, 0.2 * kScaleSigma);
  EXPECT_NEAR(sigma_of(traits, "height") / 0.004, kScaleSigma, 0.2 * kScaleSigma);
  EXPECT_NEAR(sigma_of(traits, "area") / 2.48e-4, 2 * kScaleSigma, 0.4 * kScaleSigma);
  EXPECT_NEAR(sigma_of(traits, "volume") / 2.4e-7, 3 * kScaleSigma, 0.6 * kScaleSigma);

  const MeshTraitConfig beyond{0.1, 0.2, 0.3, 0.03, 0.04};
  const SpecimenTraits wider = traits_of_meshes({surface}, kPixel_m, beyond).front();
  const auto expect_quadrature = [&](const char* trait, double added) {
    EXPECT_NEAR(sigma_of(wider, trait), std::hypot(sigma_of(traits, trait), added), 1e-6 * added)
        << trait;
  };
  expect_quadrature("length", 1e-4);
  expect_quadrature("width", 2e-4);
  expect_quadrature("height", 3e-4);
  expect_quadrature("area", 0.03 * 2.48e-4);
  expect_quadrature("volume", 0.04 * 2.4e-7);
  EXPECT_THROW(traits_of_meshes({surface}, kPixel_m, {-1, 0, 0, 0, 0}), std::invalid_argument);
  EXPECT_THROW(traits_of_meshes({surface}, -kPixel_m, beyond), std::invalid_argument);
  // A pixel of unknown span leaves the lengths without a sigma, not with one that is too small.
  const SpecimenTraits unposed = traits_of_meshes({surface}, kNaN, beyond).front();
  EXPECT_TRUE(std::isnan(sigma_of(unposed, "length")));
  EXPECT_FALSE(std::isnan(sigma_of(unposed, "area")));
}

/// A plate of 2 mm whose outline is flush with a rectangle of 10 x 8 mm and with one of
/// 9.4 x 8.52 mm turned by 45 degrees: boxes of nearly the same volume.
Surface eight_sided_plate() {
  Surface surface;
  surface.status = SurfaceStatus::ok;
  std::vector<Eigen::Vector3d> points;
  const double plus = 4.7e-3 * std::numbers::sqrt2, minus = 4.26e-3 * std::numbers::sqrt2;
  for (const double sign : {-1.0, 1.0}) {
    for (const double z : {0.0, 0.002}) {
      points.emplace_back(sign * 0.005, sign * (plus - 0.005), z);
      points.emplace_back(sign * (plus - 0.004), sign * 0.004, z);
      points.emplace_back(sign * 0.005, sign * (0.005 - minus), z);
      points.emplace_back(sign * (minus - 0.004), -sign * 0.004, z);
    }
  }
  surface.mesh = convex_hull(points);
  surface.samples_m.assign(2, surface.mesh.vertices_m);
  return surface;
}

TEST(MeshTraits, BoxesThatAreNearlyTheLeastShareInSizeAndSigma) {
  // Lengths known far better than the boxes differ: the least box alone.
  const MeshTraitConfig exact{1e-4, 1e-4, 1e-4, 0, 0};
  const SpecimenTraits sure = traits_of_meshes({eight_sided_plate()}, kPixel_m, exact).front();
  EXPECT_NEAR(value_of(sure, "length"), 0.010, 1e-9);
  EXPECT_NEAR(value_of(sure, "width"), 0.008, 1e-9);
  EXPECT_LT(sigma_of(sure, "length"), 1e-6);
  // Known to a few hundredths of a millimetre, either may be the least of the object itself.
  const SpecimenTraits unsure = traits_of_meshes({eight_sided_plate()}, kPixel_m).front();
  EXPECT_NEAR(value_of(unsure, "length"), 0.0097, 0.00005);
  EXPECT_NEAR(value_of(unsure, "width"), 0.00826, 0.00005);
  EXPECT_NEAR(value_of(unsure, "height"), 0.002, 1e-9);
  EXPECT_NEAR(sigma_of(unsure, "length"), 0.0003, 0.00005);
  EXPECT_LT(sigma_of(unsure, "height"), 0.0002);
}

TEST(MeshTraits, WhatIsNotASurfaceIsNotSolved) {
  Surface touching = block_surface(kSize);
  touching.status = SurfaceStatus::touching;
  Surface bare;
  bare.status = SurfaceStatus::ok;
  Surface inside_out = block_surface(kSize);
  for (auto& t : inside_out.mesh.triangles) std::swap(t[0], t[1]);
  for (const SpecimenTraits& t : traits_of_meshes({touching, bare, inside_out}, kPixel_m)) {
    EXPECT_EQ(t.status, TraitStatus::not_solved);
    EXPECT_FALSE(t.reason.empty());
  }
  EXPECT_TRUE(traits_of_meshes({}, kPixel_m).empty());
}

}  // namespace
}  // namespace cousin
