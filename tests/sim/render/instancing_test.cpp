#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sim/render/ray_query.h"
#include "sim/render/ray_scene_impl.h"
#include "sim/render/truth_pass.h"
#include "sim/types/rng.h"
#include "tests/sim/render/test_scenes.h"

namespace cousin::test {
namespace {

constexpr int kLeaves = 60;

Pose random_pose(Rng& rng, double spread_m) {
  Pose pose;
  const Eigen::Vector3d axis(uniform(rng, -1, 1), uniform(rng, -1, 1), uniform(rng, -1, 1));
  pose.rotation = Eigen::AngleAxisd(uniform(rng, 0, 3), axis.normalized());
  pose.translation_m =
      spread_m * Eigen::Vector3d(uniform(rng, -1, 1), uniform(rng, -1, 1), uniform(rng, -1, 1));
  return pose;
}

/// Balls and open sheets at random, either sharing two models or each with its own copy.
Scene crowd(bool shared, const Eigen::Vector3d& shift_m = Eigen::Vector3d::Zero()) {
  Scene scene;
  scene.name = "crowd";
  scene.materials.push_back(matt(0.5F));
  ObjectModel ball = ellipsoid({0.1, 0.06, 0.04}, 8);
  ball.triangle_part.assign(ball.mesh.triangles.size(), 1);
  ball.part_names = {"a", "b"};
  for (auto& v : ball.mesh.vertices_m) v += Eigen::Vector3d(3, 0, 0);  // far from its own origin
  const ObjectModel sheet = square(0.08);
  Rng rng(3);
  if (shared) scene.models = {ball, sheet};
  for (int i = 0; i < kLeaves; ++i) {
    Instance instance;
    instance.id = 2 * i + 1;
    instance.name = "leaf " + std::to_string(i);
    instance.is_specimen = i % 5 == 0;
    instance.model = shared ? i % 2 : i;
    if (!shared) scene.models.push_back(i % 2 == 0 ? ball : sheet);
    instance.world_from_object = random_pose(rng, 0.5);
    if (i % 2 == 0)
      instance.world_from_object.translation_m -=
          instance.world_from_object.rotation * Eigen::Vector3d(3, 0, 0);
    instance.world_from_object.translation_m += shift_m;
    scene.instances.push_back(instance);
  }
  return scene;
}

TrueView crowd_view(const Eigen::Vector3d& shift_m = Eigen::Vector3d::Zero()) {
  return view_from(strong_lens(LensModel::opencv5, 240, 180, 250),
                   shift_m + Eigen::Vector3d(0.3, -1.6, 0.5), shift_m);
}

constexpr TruthNeeds kAll = {.depth = true,
                             .normal = true,
                             .position = true,
                             .instance = true,
                             .part = true,
                             .coverage = true,
                             .visibility = true,
                             .shares = true};

TEST(Instancing, ASharedModelLooksAsItsCopies) {
  for (const double offset_m : {0.0, 1e5}) {
    const Eigen::Vector3d shift_m = offset_m * Eigen::Vector3d(1, -0.7, 0.3);
    const Scene shared = crowd(true, shift_m), copied = crowd(false, shift_m);
    const RayScene shared_rays(shared), copied_rays(copied);
    ASSERT_EQ(shared_rays.impl().meshes.size(), 2U);
    ASSERT_EQ(copied_rays.impl().meshes.size(), static_cast<std::size_t>(kLeaves));
    const TrueView view = crowd_view(shift_m);
    const TruthImages a = render_truth(shared_rays, shared, view, kAll);
    const TruthImages b = render_truth(copied_rays, copied, view, kAll);
    int seen = 0, differ = 0;
    for (int y = 0; y < 180; ++y) {
      for (int x = 0; x < 240; ++x) {
        if (a.instance(x, y) != b.instance(x, y)) {
          ++differ;
          continue;
        }
        if (b.instance(x, y) < 0) continue;
        ++seen;
        EXPECT_EQ(a.part(x, y), b.part(x, y));
        if ((a.normal(x, y) - b.normal(x, y)).norm() > 1e-4F) {
          ++differ;  // the neighbouring facet
          continue;
        }
        // Double planes; float output rounds at 6e-8. At 1e5 m doubles of the world end at 1e-11
        // m, which at grazing incidence (cosine 1e-3) is 1e-8.
        EXPECT_NEAR(a.depth_m(x, y) / b.depth_m(x, y), 1, 2e-7F) << x << "," << y;
      }
    }
    EXPECT_GT(seen, 3000);
    EXPECT_LE(differ, 10);  // rays within float rounding of an edge, of some 8000 edge pixels
    ASSERT_EQ(a.visibility.size(), b.visibility.size());
    for (std::size_t i = 0; i < a.visibility.size(); ++i) {
      EXPECT_EQ(a.visibility[i].instance, b.visibility[i].instance);
      EXPECT_NEAR(static_cast<double>(a.visibility[i].pixels_full),
                  static_cast<double>(b.visibility[i].pixels_full), 2);
      EXPECT_NEAR(static_cast<double>(a.visibility[i].pixels_visible),
                  static_cast<double>(b.visibility[i].pixels_visible), 2);
      EXPECT_NEAR(a.shares[i].area_px, b.shares[i].area_px, 1);
    }
  }
}

TEST(Instancing, SameBytesOnAnyNumberOfThreads) {
  const Scene scene = crowd(true);
  std::vector<TruthImages> truths;
  for (const std::size_t threads : {1U, 2U, 7U}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const RayScene rays(scene);
    truths.push_back(render_truth(rays, scene, crowd_view(), kAll));
  }
  for (std::size_t i = 1; i < truths.size(); ++i) {
    EXPECT_EQ(truths[0].instance, truths[i].instance);
    EXPECT_EQ(truths[0].normal, truths[i].normal);
    EXPECT_EQ(truths[0].masks_full, truths[i].masks_full);
    for (std::size_t k = 0; k < truths[0].shares.size(); ++k)
      EXPECT_EQ(truths[0].shares[k].pixels, truths[i].shares[k].pixels);
  }
}

/// A spinning, flying ball among still ones.
Scene moving_scene() {
  Scene scene = crowd(true);
  Instance& ball = scene.instances[0];
  Rng rng(8);
  for (int k = 0; k < 4; ++k) {
    TimedPose step;
    step.time_s = 0.25 * k;
    // The ball lies 3 m from its model's origin: it turns about its own middle.
    const Eigen::Vector3d middle(3, 0, 0);
    step.world_from_object.rotation =
        Eigen::AngleAxisd(0.5 * k, Eigen::Vector3d(0.6, 0, 0.8)) * ball.world_from_object.rotation;
    step.world_from_object.translation_m = ball.world_from_object * middle -
                                           step.world_from_object.rotation * middle +
                                           Eigen::Vector3d(0.1 * k, -0.05 * k * k, 0.05);
    ball.motion.push_back(step);
  }
  return scene;
}

TEST(Instancing, ARayOfASpanSeesWhatAnInstantSees) {
  const Scene scene = moving_scene();
  const RayScene span(scene, TimeSpan{0.25, 0.75});
  EXPECT_GT(span.impl().geometries[0].steps.size(), 2U);
  EXPECT_EQ(span.impl().geometries[1].steps.size(), 1U);
  TrueView view = crowd_view();
  for (const double time_s : {0.25, 0.3, 0.333, 0.5, 0.65}) {
    const RayScene instant(scene, time_s);
    view.time_s = time_s;
    const TruthNeeds needs{.depth = true, .instance = true, .visibility = true};
    const TruthImages a = render_truth(span, scene, view, needs);
    const TruthImages b = render_truth(instant, scene, view, needs);
    int differ = 0, seen = 0, coarse = 0;
    for (int y = 0; y < 180; ++y) {
      for (int x = 0; x < 240; ++x) {
        if (a.instance(x, y) != b.instance(x, y)) {
          ++differ;
        } else if (b.instance(x, y) >= 0) {
          seen += b.instance(x, y) == scene.instances[0].id ? 1 : 0;
          // Steps are within 1e-6 of size (3 m from the model's origin) and path; of grazing
          // pixels, where that is multiplied or falls on the next facet, there are few.
          coarse += std::abs(a.depth_m(x, y) - b.depth_m(x, y)) > 2e-5F ? 1 : 0;
        }
      }
    }
    EXPECT_LE(differ, 10) << time_s;
    EXPECT_LE(coarse, 20) << time_s;
    EXPECT_GT(seen, 20) << time_s;
    EXPECT_NEAR(static_cast<double>(a.visibility[0].pixels_full),
                static_cast<double>(b.visibility[0].pixels_full), 3);
  }
}

TEST(Instancing, EachRowOfARollingShutterSeesItsOwnTime) {
  // A plate flies along x at 1 m/s past a still camera: its edge is skewed by the readout.
  Scene scene;
  add(scene, box({-0.5, -5, -0.01}, {0.5, 5, 0}), matt(0.5F));
  Pose end;
  end.translation_m.x() = 0.2;
  scene.instances[0].motion = {{0, {}}, {0.2, end}};
  const RayScene rays(scene, TimeSpan{0, 0.2});
  Camera camera = strong_lens(LensModel::pinhole, 160, 121, 100);
  camera.cx_px = 80;
  camera.cy_px = 60;
  TrueView view = view_from(camera, {0, 0, 2}, {0, 0, 0}, Eigen::Vector3d::UnitY());
  view.readout_s = 0.2;
  const TruthImages truth = render_truth(rays, scene, view, {.instance = true});
  for (int y = 0; y < 121; y += 10) {
    int left = 0;
    while (truth.instance(left, y) < 0) ++left;
    EXPECT_NEAR(left, 80 + 50 * (-0.5 + 0.2 * y / 120.0) + 0.5, 0.51) << y;
  }
}

TEST(Instancing, ASurfacePointLiesWhereTheRayMeetsIt) {
  const Scene scene = moving_scene();
  const RayScene rays(scene, TimeSpan{0.0, 0.75});
  const RayScene::Impl& impl = rays.impl();
  Rng rng(5);
  int hits = 0;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d from(uniform(rng, -2, 2), -2, uniform(rng, -2, 2));
    const Eigen::Vector3d to(uniform(rng, -0.6, 0.6), uniform(rng, -0.6, 0.6),
                             uniform(rng, -0.6, 0.6));
    const Eigen::Vector3d d = (to - from).normalized();
    const RayAnswer answer = cast_ray(rays, from, d, 0.75 * uniform(rng));
    if (!answer.hit) continue;
    ++hits;
    const bool is_instanced = impl.geometries[answer.geometry].is_instanced;
    const SurfacePoint point =
        surface_point(impl, is_instanced ? answer.geometry : RTC_INVALID_GEOMETRY_ID,
                      is_instanced ? 0 : answer.geometry, answer.triangle, answer.u, answer.v,
                      d.cast<float>(), answer.time);
    const Eigen::Vector3d expected = from + answer.distance_m * d - impl.centre_m;
    // Float hits: some ulps of coordinates of at most 6 m over the cosine.
    const double cosine = -d.dot(answer.normal);
    EXPECT_LT((point.position_m.cast<double>() - expected).norm(), 1e-5 / cosine);
    EXPECT_LT((point.face_normal.cast<double>() - answer.normal).norm(), 1e-6);
    EXPECT_EQ(scene.instances[point.geometry].id, answer.instance);
    EXPECT_GT(point.offset_m, 0);
    EXPECT_EQ(point.part, point.geometry % 2 == 0 ? 1 : 0);
  }
  EXPECT_GT(hits, 500);
}

TEST(Instancing, LeavingASharedConvexBodyNeverMeetsItAtAnyScaleOrPlace) {
  for (const double scale_m : {1e-4, 1.0, 1e4}) {
    for (const double offset_m : {0.0, 1e5}) {
      Scene scene;
      add(scene,
          box(-scale_m * Eigen::Vector3d(1, 0.6, 0.01), scale_m * Eigen::Vector3d(1, 0.6, 0.01)),
          matt(0.5F));
      Instance second = scene.instances[0];
      scene.instances[0].world_from_object.translation_m.setConstant(offset_m);
      second.id = 2;
      second.world_from_object.translation_m =
          Eigen::Vector3d::Constant(offset_m) + Eigen::Vector3d(5 * scale_m, 0, 0);
      second.world_from_object.rotation = Eigen::AngleAxisd(1, Eigen::Vector3d(0.6, 0, 0.8));
      scene.instances.push_back(second);
      const RayScene rays(scene);
      Rng rng(11);
      int met = 0;
      for (int i = 0; i < 2000; ++i) {
        const Eigen::Vector3d aim(uniform(rng, -1, 1), uniform(rng, -1, 1), uniform(rng, -1, 1));
        const Eigen::Vector3d from(0.4, 1.2, 3);
        const Eigen::Vector3d d = (0.4 * aim - from).normalized();
        const RayAnswer on =
            cast_ray(rays, second.world_from_object.translation_m + scale_m * from, d);
        if (!on.hit || on.instance != 2) continue;
        ++met;
        Eigen::Vector3d out(uniform(rng, -1, 1), uniform(rng, -1, 1), uniform(rng, -1, 1));
        out.normalize();
        if (out.dot(on.normal) < 0) out = -out;
        const RayAnswer next = cast_from(rays, on, out);
        EXPECT_FALSE(next.hit && next.instance == 2) << scale_m << " at " << offset_m;
        const RayAnswer inside = cast_from(rays, on, -out);
        EXPECT_TRUE(inside.hit && inside.is_back) << scale_m << " at " << offset_m;
      }
      EXPECT_GT(met, 1000);
    }
  }
}

TEST(Instancing, ManyTrianglesHaveTheSamePlanesMadeAtNeed) {
  // A wavy open sheet of 2 * 730 * 730 > 2^20 triangles against its own corner in a small scene.
  const auto sheet = [](int cells, int shown) {
    ObjectModel model;
    model.name = "sheet";
    const auto n = static_cast<std::uint32_t>(cells + 1);
    for (int j = 0; j <= cells; ++j) {
      for (int i = 0; i <= cells; ++i) {
        const double x = 0.01 * i, y = 0.01 * j;
        model.mesh.vertices_m.emplace_back(x, y, 0.02 * std::sin(9 * x) * std::cos(7 * y));
      }
    }
    for (std::uint32_t j = 0; j < static_cast<std::uint32_t>(shown); ++j) {
      for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(shown); ++i) {
        const std::uint32_t a = j * n + i;
        model.mesh.triangles.push_back({a, a + 1, a + n});
        model.mesh.triangles.push_back({a + 1, a + n + 1, a + n});
      }
    }
    return model;
  };
  constexpr int kCells = 730;
  Scene large, small;
  add(large, sheet(kCells, kCells), matt(0.5F));
  add(small, sheet(kCells, 60), matt(0.5F));
  const RayScene large_rays(large), small_rays(small);
  EXPECT_TRUE(large_rays.impl().meshes[0].planes.empty());
  EXPECT_FALSE(small_rays.impl().meshes[0].planes.empty());
  const TrueView view = view_from(strong_lens(LensModel::pinhole, 96, 72, 100), {0.25, 0.2, 0.4},
                                  {0.3, 0.3, 0}, Eigen::Vector3d::UnitY());
  const TruthImages a = render_truth(large_rays, large, view, {.depth = true, .normal = true});
  const TruthImages b = render_truth(small_rays, small, view, {.depth = true, .normal = true});
  int same = 0;
  for (int y = 0; y < 72; ++y) {
    for (int x = 0; x < 96; ++x) {
      if (std::isnan(b.depth_m(x, y))) continue;
      same += a.depth_m(x, y) == b.depth_m(x, y) && a.normal(x, y) == b.normal(x, y) ? 1 : 0;
      EXPECT_NEAR(a.depth_m(x, y) / b.depth_m(x, y), 1, 1e-6F);  // another facet at an edge
    }
  }
  EXPECT_GT(same, 96 * 72 * 9 / 10);
}

TEST(Instancing, RefusesWhatIsNotASceneOrASpan) {
  const Scene good = moving_scene();
  EXPECT_THROW(RayScene(good, TimeSpan{1, 0}), std::invalid_argument);
  EXPECT_THROW(RayScene(good, TimeSpan{0, std::nan("")}), std::invalid_argument);
  const auto message = [&](const auto& spoil) {
    Scene scene = good;
    spoil(scene);
    try {
      const RayScene rays(scene);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const auto mentions = [](const std::string& text, const char* word) {
    return text.find(word) != std::string::npos;
  };
  EXPECT_TRUE(mentions(message([](Scene& s) { s.models[1].mesh.vertices_m[2].y() = std::nan(""); }),
                       "square"));
  EXPECT_TRUE(mentions(message([](Scene& s) { s.instances[0].motion[1].time_s = std::nan(""); }),
                       "leaf 0"));
  EXPECT_TRUE(mentions(message([](Scene& s) {
                         s.instances[0].motion[1].world_from_object.translation_m.x() =
                             std::nan("");
                       }),
                       "leaf 0"));
  EXPECT_TRUE(
      mentions(message([](Scene& s) { s.instances[3].world_from_object.rotation.coeffs() *= 2; }),
               "leaf 3"));
  EXPECT_TRUE(
      mentions(message([](Scene& s) { s.models[0].mesh.vertices_m[7].x() = 1e20; }), "1e12"));
}

}  // namespace
}  // namespace cousin::test
