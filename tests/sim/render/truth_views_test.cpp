#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sim/render/keypoint_truth.h"
#include "sim/render/truth_pass.h"
#include "sim/render/view_match.h"
#include "tests/sim/render/test_scenes.h"

namespace cousin::test {
namespace {

constexpr TruthNeeds kDepthAndIds = {.depth = true, .instance = true};

/// A closed tube along z of `sides` sides, its axis from the origin to (0, 0, length).
ObjectModel tube(double radius_m, double length_m, int sides) {
  ObjectModel model;
  model.name = "tube";
  for (int k = 0; k < sides; ++k) {
    const double phi = 2 * std::numbers::pi * k / sides;
    const Eigen::Vector3d rim(radius_m * std::cos(phi), radius_m * std::sin(phi), 0);
    model.mesh.vertices_m.push_back(rim);
    model.mesh.vertices_m.push_back(rim + Eigen::Vector3d(0, 0, length_m));
  }
  const auto n = static_cast<std::uint32_t>(2 * sides);
  for (std::uint32_t k = 0; k < n; k += 2) {
    const std::uint32_t a = k, b = (k + 2) % n;
    model.mesh.triangles.push_back({a, b, a + 1});
    model.mesh.triangles.push_back({b, b + 1, a + 1});
    if (k >= 2 && b != 0) {
      model.mesh.triangles.push_back({0, b, a});
      model.mesh.triangles.push_back({1, a + 1, b + 1});
    }
  }
  return model;
}

Camera plain_camera(int width_px, int height_px, double focal_px) {
  Camera camera;
  camera.width_px = width_px;
  camera.height_px = height_px;
  camera.fx_px = camera.fy_px = focal_px;
  camera.cx_px = 0.5 * (width_px - 1);
  camera.cy_px = 0.5 * (height_px - 1);
  return camera;
}

TEST(KeypointTruth, AKeypointIsVisibleOccludedOrOutsideAsItsGeometrySays) {
  Scene scene;
  ObjectModel stem = tube(0.01, 1, 12);
  stem.keypoints = {{"root", {0, 0, 0.1}},  // on the axis, seen through its own skin
                    {"skin", {0, -0.01 * std::cos(std::numbers::pi / 12), 0.5}},
                    {"behind", {0, 0.01 * std::cos(std::numbers::pi / 12), 0.5}},
                    {"hidden", {0, 0, 0.7}},  // behind the plate
                    {"above", {0, 0, 30}}};   // outside the image
  Pose turned;
  turned.rotation = Eigen::AngleAxisd(std::numbers::pi / 12, Eigen::Vector3d::UnitZ());
  for (Keypoint& k : stem.keypoints)
    k.in_object_m = turned.rotation.conjugate() * k.in_object_m;  // on the middle of a side
  const int id = add(scene, stem, matt(0.5F), turned, true);
  Pose plate;
  plate.translation_m = {0, -0.5, 0.7};
  add(scene, box({-0.05, -0.001, -0.05}, {0.05, 0.001, 0.05}), matt(0.5F), plate);
  const RayScene rays(scene);
  const TrueView view = view_from(plain_camera(200, 200, 150), {0, -2, 0.5}, {0, 0, 0.5});
  const auto keypoints = view_keypoints(rays, scene, view);
  ASSERT_EQ(keypoints.size(), 5U);
  const PointState expected[] = {PointState::visible, PointState::visible, PointState::occluded,
                                 PointState::occluded, PointState::outside};
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(keypoints[i].state, expected[i]) << stem.keypoints[i].name;
    EXPECT_EQ(keypoints[i].instance, id);
    EXPECT_EQ(keypoints[i].keypoint, static_cast<int>(i));
  }
  // The root lies 2 m before the camera and 0.4 m below its axis: f * 0.4 / 2 under the middle.
  EXPECT_NEAR((keypoints[0].pixel_px - Eigen::Vector2d(99.5, 99.5 + 30)).norm(), 0, 1e-9);
  EXPECT_NEAR(keypoints[0].depth_m, 2, 1e-12);
}

TEST(KeypointTruth, SurfacePointsOfAConvexBodyAreSeenFromTheSideTheyFace) {
  Scene scene;
  ObjectModel ball = ellipsoid({0.003, 0.002, 0.001}, 12);
  for (const auto& t : ball.mesh.triangles) {
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const std::uint32_t v : t) middle += ball.mesh.vertices_m[v] / 3;
    ball.keypoints.push_back({"facet", middle});
  }
  const Mesh mesh = ball.mesh;
  for (int copies = 1; copies <= 2; ++copies) {  // laid out in the world, and instanced
    add(scene, ball, matt(0.5F), {}, copies == 1);
    scene.instances.back().model = 0;
    scene.instances.back().world_from_object.translation_m.x() = 0.1 * (copies - 1);
    const RayScene rays(scene);
    const Eigen::Vector3d eye(0.1, -0.2, 0.25);
    const TrueView view = view_from(plain_camera(64, 64, 400), eye, {0, 0, 0});
    const auto keypoints = view_keypoints(rays, scene, view);
    ASSERT_EQ(keypoints.size(), mesh.triangles.size());
    for (std::size_t i = 0; i < keypoints.size(); ++i) {
      const auto& t = mesh.triangles[i];
      const Eigen::Vector3d &a = mesh.vertices_m[t[0]], &b = mesh.vertices_m[t[1]],
                            &c = mesh.vertices_m[t[2]];
      const double facing = (b - a).cross(c - a).normalized().dot((eye - a).normalized());
      // At the silhouette a neighbour decides: its facet may stand a little proud.
      if (std::abs(facing) < 0.1) continue;
      EXPECT_EQ(keypoints[i].state, facing > 0 ? PointState::visible : PointState::occluded)
          << facing;
    }
  }
}

TEST(ViewMatch, DisparityOfAPlaneIsFocalLengthTimesBaselineOverDepth) {
  Scene scene;
  add(scene, square(5), matt(0.5F));
  Pose tilt;
  tilt.rotation = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitY());
  scene.instances[0].world_from_object = tilt;
  const RayScene rays(scene);
  const Camera camera = plain_camera(120, 90, 100);
  const TrueView left = view_from(camera, {0, 0, 2}, {0, 0, 0}, Eigen::Vector3d::UnitY());
  TrueView right = left;
  Pose baseline;
  baseline.translation_m.x() = -0.12;
  right.camera_from_world = right.camera_from_world_end = baseline * left.camera_from_world;
  const TruthImages truth = render_truth(rays, scene, left, kDepthAndIds);
  const ViewMatch match =
      match_views(scene, {rays, left}, truth.depth_m, truth.instance, {rays, right});
  for (int y = 0; y < 90; ++y) {
    for (int x = 0; x < 120; ++x) {
      const double disparity = 100 * 0.12 / static_cast<double>(truth.depth_m(x, y));
      // The flow is a float of some 6 px, from a float depth: 6 * 1.2e-7.
      EXPECT_NEAR(-match.flow_px(x, y).x(), disparity, 1e-6);
      EXPECT_NEAR(match.flow_px(x, y).y(), 0, 1e-6);
      EXPECT_EQ(match.state(x, y),
                x - disparity >= -0.5 ? PointState::visible : PointState::outside);
    }
  }
}

TEST(ViewMatch, FlowAndOcclusionAgreeWithTheOtherViewsOwnTruth) {
  const Scene scene = table_top(5, 8);
  const RayScene rays(scene);
  const TrueView here =
      view_from(strong_lens(LensModel::opencv8, 200, 150, 220), {0.07, -0.1, 0.05}, {0, 0, 0});
  const TrueView there = view_from(strong_lens(LensModel::kannala_brandt4, 200, 150, 200),
                                   {-0.06, -0.1, 0.06}, {0, 0, 0});
  const TruthNeeds needs{.depth = true, .position = true, .instance = true};
  const TruthImages a = render_truth(rays, scene, here, needs);
  const TruthImages b = render_truth(rays, scene, there, needs);
  const ViewMatch match = match_views(scene, {rays, here}, a.depth_m, a.instance, {rays, there});
  int visible = 0, occluded = 0;
  for (int y = 0; y < 150; ++y) {
    for (int x = 0; x < 200; ++x) {
      const PointState state = match.state(x, y);
      if (std::isnan(a.depth_m(x, y))) {
        EXPECT_EQ(state, PointState::none);
        EXPECT_TRUE(std::isnan(match.flow_px(x, y).x()));
        continue;
      }
      const auto pixel =
          project(there.camera, there.camera_from_world * a.position_m(x, y).cast<double>());
      if (!pixel) continue;
      // Position and flow are floats: 200 px * 1.2e-7 and 0.1 m * 1.2e-7 at 200 px / 0.1 m.
      EXPECT_LT((match.flow_px(x, y).cast<double>() + Eigen::Vector2d(x, y) - *pixel).norm(), 2e-4);
      const int u = static_cast<int>(std::lround(pixel->x())),
                v = static_cast<int>(std::lround(pixel->y()));
      if (!b.depth_m.contains(u, v) || std::isnan(b.depth_m(u, v))) continue;
      // Well before the point lies something else, or nothing does: by the nearest pixel's centre.
      const Eigen::Vector3d eye = centre_in_world_m(there.camera_from_world);
      const double to_point = (a.position_m(x, y).cast<double>() - eye).norm();
      const double to_first = (b.position_m(u, v).cast<double>() - eye).norm();
      if (a.instance(x, y) == b.instance(u, v) && std::abs(to_point - to_first) < 2e-4) {
        ++visible;
        EXPECT_NE(state, PointState::outside);
      }
      if (a.instance(x, y) != b.instance(u, v) && to_first < to_point - 4e-3 &&
          state != PointState::occluded) {
        // Only beside an edge of what hides it.
        bool at_edge = false;
        for (int j = -1; j <= 1; ++j) {
          for (int i = -1; i <= 1; ++i)
            at_edge |=
                b.instance.contains(u + i, v + j) && b.instance(u + i, v + j) != b.instance(u, v);
        }
        EXPECT_TRUE(at_edge) << x << "," << y;
      }
      occluded += state == PointState::occluded ? 1 : 0;
    }
  }
  EXPECT_GT(visible, 5000);
  EXPECT_GT(occluded, 50);
}

TEST(ViewMatch, PointsMoveWithTheirInstance) {
  // A plate slides 0.1 m along x before a still wall: 50 px/m at 2 m through 100 px.
  Scene scene;
  add(scene, box({-0.3, -0.3, -0.01}, {0.3, 0.3, 0}), matt(0.5F));
  Pose end;
  end.translation_m.x() = 0.1;
  scene.instances[0].motion = {{0, {}}, {1, end}};
  Pose wall;
  wall.translation_m.z() = -2;
  add(scene, square(5), matt(0.5F), wall);
  TrueView here =
      view_from(plain_camera(120, 90, 100), {0, 0, 2}, {0, 0, 0}, Eigen::Vector3d::UnitY());
  TrueView there = here;
  there.time_s = 1;
  const RayScene rays_here(scene, 0.0), rays_there(scene, 1.0);
  const TruthImages truth = render_truth(rays_here, scene, here, kDepthAndIds);
  const ViewMatch match =
      match_views(scene, {rays_here, here}, truth.depth_m, truth.instance, {rays_there, there});
  int covered = 0;
  for (int y = 0; y < 90; ++y) {
    for (int x = 0; x < 120; ++x) {
      const bool on_plate = truth.instance(x, y) == scene.instances[0].id;
      EXPECT_NEAR(match.flow_px(x, y).x(), on_plate ? 5 : 0, 1e-5);
      // Where the plate comes to, it covers the wall.
      const double plate_x = (x - 59.5) / 50 - 0.1, plate_y = (y - 44.5) / 50;
      const bool under = !on_plate && std::abs(plate_x) < 0.3 && std::abs(plate_y) < 0.3;
      covered += under ? 1 : 0;
      EXPECT_EQ(match.state(x, y), under ? PointState::occluded : PointState::visible)
          << x << "," << y;
    }
  }
  EXPECT_EQ(covered, 5 * 30);
}

TEST(ViewMatch, ARollingShutterSeesAPointInTheRowThatReadsIt) {
  // The camera falls while rows are read: v' = v - speed * time(v'), solved in closed form.
  Scene scene;
  add(scene, square(5), matt(0.5F));
  const RayScene rays(scene);
  const Camera camera = plain_camera(60, 101, 100);
  const TrueView here = view_from(camera, {0, 0, 2}, {0, 0, 0}, Eigen::Vector3d::UnitY());
  TrueView there = here;
  there.camera_from_world_end =
      view_from(camera, {0, -0.4, 2}, {0, -0.4, 0}, Eigen::Vector3d::UnitY()).camera_from_world;
  const TruthImages truth = render_truth(rays, scene, here, kDepthAndIds);
  const ViewMatch match =
      match_views(scene, {rays, here}, truth.depth_m, truth.instance, {rays, there});
  for (int y = 30; y < 100; ++y) {
    // Moving down by 0.4 m shifts the image up by 20 px at the last row, linearly in the row.
    const double row = y / (1 + 20.0 / 100);
    EXPECT_NEAR(match.flow_px(30, y).y(), row - y, 2e-6) << y;
  }
}

TEST(ViewMatch, RefusesImagesOfAnotherSizeAndOtherScenes) {
  const Scene scene = table_top(1, 3), other = table_top(2, 3);
  const RayScene rays(scene), other_rays(other);
  const TrueView view = view_from(plain_camera(20, 20, 20), {0.1, -0.1, 0.1}, {0, 0, 0});
  const TruthImages truth = render_truth(rays, scene, view, kDepthAndIds);
  EXPECT_THROW(match_views(scene, {rays, view}, Image<float>(3, 3), truth.instance, {rays, view}),
               std::invalid_argument);
  EXPECT_THROW(match_views(scene, {rays, view}, truth.depth_m, truth.instance, {other_rays, view}),
               std::invalid_argument);
  EXPECT_THROW(view_keypoints(other_rays, scene, view), std::invalid_argument);
}

TEST(Shares, AStemFarThinnerThanAPixelHasItsArea) {
  // A strip of 0.2 px across 80 rows between two columns of centres: no centre shows it.
  for (const double tilt_rad : {0.0, 0.3}) {
    Scene scene;
    constexpr double kWidth_m = 0.2 / 100, kLength_m = 0.8;  // at 1 m through 100 px
    Pose pose;
    pose.rotation = Eigen::AngleAxisd(tilt_rad, Eigen::Vector3d::UnitZ());
    pose.translation_m = {0.0031, 0, 0};
    const int id =
        add(scene, box({-kWidth_m / 2, -kLength_m / 2, -1e-4}, {kWidth_m / 2, kLength_m / 2, 0}),
            matt(0.5F), pose, true);
    const RayScene rays(scene);
    const TrueView view =
        view_from(plain_camera(100, 100, 100), {0, 0, 1}, {0, 0, 0}, Eigen::Vector3d::UnitY());
    const TruthImages truth =
        render_truth(rays, scene, view, {.instance = true, .visibility = true, .shares = true},
                     {.share_samples = 16});
    ASSERT_EQ(truth.shares.size(), 1U);
    EXPECT_EQ(truth.shares[0].instance, id);
    // 80 rows of 16 px, each share known to a deviation of at most sqrt(0.2 * 0.8 / 16) = 0.1 if
    // its samples were independent: 0.9 over 80 rows; three deviations.
    EXPECT_NEAR(truth.shares[0].area_px, 16, 2.7) << tilt_rad;
    if (tilt_rad == 0) {
      EXPECT_EQ(truth.visibility[0].pixels_visible, 0);
      std::vector<bool> has_row(100, false);
      for (const PixelShare& p : truth.shares[0].pixels)
        has_row[static_cast<std::size_t>(p.y)] = true;
      for (std::size_t y = 11; y < 89; ++y) EXPECT_TRUE(has_row[y]) << y;
    }
  }
}

TEST(Shares, MeanOverSubPixelPlacesIsTheAreaHoweverSmall) {
  // A speck of 0.02 px area at 400 places: its expected area is its area.
  double sum = 0;
  int n = 0;
  Scene scene;
  const double half_m = 0.5 * std::sqrt(0.02) / 100;
  add(scene, square(half_m), matt(0.5F), {}, true);
  for (int j = 0; j < 20; ++j) {
    for (int i = 0; i < 20; ++i) {
      scene.instances[0].world_from_object.translation_m = {0.01 * (i + i / 20.0),
                                                            0.01 * (j + j / 20.0), 0};
      const RayScene rays(scene);
      const TrueView view =
          view_from(plain_camera(64, 64, 100), {0, 0, 1}, {0, 0, 0}, Eigen::Vector3d::UnitY());
      const TruthImages truth = render_truth(rays, scene, view, {.shares = true});
      sum += truth.shares[0].area_px;
      ++n;
    }
  }
  // Each is 0 or 1/4 with mean 0.02: deviation 0.068, of 400 places 0.0034; three deviations.
  EXPECT_NEAR(sum / n, 0.02, 0.0102);
  EXPECT_GT(sum, 0);
}

TEST(TruthPass, TheVisibleBoxHoldsTheVisibleMaskAndNoMore) {
  const Scene scene = table_top(8, 8);
  const RayScene rays(scene);
  const TrueView view =
      view_from(strong_lens(LensModel::opencv5, 160, 120, 180), {0.09, -0.1, 0.02}, {0, 0, 0});
  const TruthImages truth = render_truth(rays, scene, view, {.instance = true, .visibility = true});
  int smaller = 0;
  for (const InstanceVisibility& v : truth.visibility) {
    int x0 = 1000, y0 = 1000, x1 = -1, y1 = -1;
    for (int y = 0; y < 120; ++y) {
      for (int x = 0; x < 160; ++x) {
        if (truth.instance(x, y) != v.instance) continue;
        x0 = std::min(x0, x);
        x1 = std::max(x1, x);
        y0 = std::min(y0, y);
        y1 = std::max(y1, y);
      }
    }
    if (x1 < 0) {
      EXPECT_EQ(v.seen_width, 0);
      continue;
    }
    EXPECT_EQ(v.seen_x, x0);
    EXPECT_EQ(v.seen_y, y0);
    EXPECT_EQ(v.seen_width, x1 - x0 + 1);
    EXPECT_EQ(v.seen_height, y1 - y0 + 1);
    smaller += v.seen_width < v.box_width || v.seen_height < v.box_height ? 1 : 0;
  }
  EXPECT_GT(smaller, 0);
}

}  // namespace
}  // namespace cousin::test
