#include "sim/dataset/seam_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/seam_json.h"
#include "sim/geometry/mesh_io.h"
#include "sim/imaging/image_io.h"
#include "sim/types/memory_limit.h"
#include "tests/sim/dataset/sample_capture.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

TEST(SeamIo, CornersComeBackBitByBit) {
  const TemporaryFolder folder;
  Corners corners(5);
  for (int i = 0; i < 5; ++i) {
    corners[static_cast<std::size_t>(i)] = {.frame = 3 * i, .status = static_cast<BoardStatus>(i)};
  }
  corners[0].corners = {{2, 3, {1 / 3.0, 1e-17}, isotropic_px2(0.1 / 7)},
                        {0, 13, {-0.0, 1e300}, isotropic_px2(1e-7)}};
  corners[0].corners[0].covariance_px2(0, 1) = corners[0].corners[0].covariance_px2(1, 0) =
      -1e-5 / 3;
  write_corners(folder.path(), corners);
  const Corners read = read_corners(folder.path());
  ASSERT_EQ(read.size(), 5U);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(read[i].frame, corners[i].frame);
    EXPECT_EQ(read[i].status, corners[i].status);
    ASSERT_EQ(read[i].corners.size(), corners[i].corners.size());
    for (std::size_t k = 0; k < read[i].corners.size(); ++k) {
      EXPECT_EQ(read[i].corners[k].column, corners[i].corners[k].column);
      EXPECT_EQ(read[i].corners[k].row, corners[i].corners[k].row);
      EXPECT_TRUE(same_bits(read[i].corners[k].pixel_px, corners[i].corners[k].pixel_px));
      EXPECT_TRUE(read[i].corners[k].covariance_px2 == corners[i].corners[k].covariance_px2);
    }
  }
}

TEST(SeamIo, PosesComeBackBitByBit) {
  const TemporaryFolder folder;
  Rng rng(3);
  Poses poses(2);
  poses[0] = {.frame = 4,
              .status = PoseStatus::ok,
              .camera_from_world = odd_pose(rng),
              .camera = odd_camera(640, 480, 1900)};
  for (int i = 0; i < 36; ++i) poses[0].covariance(i / 6, i % 6) = normal(rng) * normal(rng) * 1e-9;
  for (int i = 0; i < 6; ++i) poses[0].covariance(i, i) = uniform(rng) * 1e-9;
  poses[0].rms_px = 0.1 / 3;
  poses[0].corner_count = 160;
  poses[1] = {.frame = 5, .status = PoseStatus::not_converged};
  write_poses(folder.path(), poses);
  const Poses read = read_poses(folder.path());
  ASSERT_EQ(read.size(), 2U);
  EXPECT_EQ(read[0].status, PoseStatus::ok);
  EXPECT_EQ(read[0].frame, 4);
  EXPECT_TRUE(same_pose(read[0].camera_from_world, poses[0].camera_from_world));
  EXPECT_EQ(read[0].camera, poses[0].camera);
  EXPECT_EQ(read[0].covariance, poses[0].covariance);
  EXPECT_EQ(read[0].rms_px, poses[0].rms_px);
  EXPECT_EQ(read[0].corner_count, 160);
  EXPECT_EQ(read[1].status, PoseStatus::not_converged);
  EXPECT_TRUE(std::isnan(read[1].rms_px));
  EXPECT_EQ(read[1].camera, Camera{});
}

TEST(SeamIo, NormalsOfDepthsComeBackAndAreOfUnitLengthOrNone) {
  const TemporaryFolder folder;
  Depths depths(2);
  depths[0] = {.frame = 0,
               .depth_m = Image<float>(3, 2, 0.5F),
               .sigma_m = {},
               .normal = Image<Eigen::Vector3f>(3, 2, Eigen::Vector3f(0, 0.6F, -0.8F))};
  depths[0].normal(1, 1).setZero();
  depths[1] = {.frame = 1, .depth_m = Image<float>(3, 2, 0.5F), .sigma_m = {}};
  write_depths(folder.path(), depths);
  const Depths read = read_depths(folder.path());
  ASSERT_EQ(read[0].normal.size(), 6U);
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_EQ(read[0].normal.data()[i], depths[0].normal.data()[i]);
  EXPECT_TRUE(read[1].normal.empty());

  const auto error_with = [&](const Image<Eigen::Vector3f>& normal) {
    depths[1].normal = normal;
    write_depths(folder.path(), depths);
    return error_of([&] { read_depths(folder.path()); });
  };
  EXPECT_THAT(error_with(Image<Eigen::Vector3f>(2, 2, Eigen::Vector3f::Zero())),
              AllOf(HasSubstr("depth_normal"), HasSubstr("000001.exr"), HasSubstr("2 x 2")));
  Image<Eigen::Vector3f> long_one(3, 2, Eigen::Vector3f::Zero());
  long_one(2, 1) = {0, 0, -2};
  EXPECT_THAT(error_with(long_one), AllOf(HasSubstr("000001.exr"), HasSubstr("(2, 1)")));
  long_one(2, 1) = {0, kNaN, -1};
  EXPECT_THAT(error_with(long_one), HasSubstr("(2, 1)"));

  // Nothing of an earlier run in the same folder is taken for this one's.
  for (FrameDepth& depth : depths) depth.normal = {};
  depths[1].depth_m = {};
  write_depths(folder.path(), depths);
  EXPECT_TRUE(read_depths(folder.path())[0].normal.empty());
  EXPECT_TRUE(read_depths(folder.path())[1].depth_m.empty());
}

TEST(SeamIo, DepthsComeBackWithUnusedFrames) {
  const TemporaryFolder folder;
  Depths depths(3);
  depths[0] = {
      .frame = 2, .depth_m = Image<float>(5, 4, 0.25F), .sigma_m = Image<float>(5, 4, 1e-4F)};
  depths[0].depth_m(1, 1) = std::numeric_limits<float>::quiet_NaN();
  depths[0].depth_m(2, 1) = 0.1F;
  depths[1] = {.frame = 3};
  depths[2] = {.frame = 7, .depth_m = Image<float>(3, 2, 0.5F)};
  write_depths(folder.path(), depths);
  const auto expect_frames = [&](const std::vector<std::size_t>& which) {
    const Depths read = read_depths(folder.path());
    ASSERT_EQ(read.size(), which.size());
    for (std::size_t i = 0; i < which.size(); ++i) {
      EXPECT_EQ(read[i].frame, depths[which[i]].frame);
      EXPECT_TRUE(same_bits(read[i].depth_m, depths[which[i]].depth_m));
      EXPECT_TRUE(same_bits(read[i].sigma_m, depths[which[i]].sigma_m));
    }
  };
  expect_frames({0, 1, 2});
  fs::remove(folder.path() / "depth/frames.json");  // another program need not write it
  expect_frames({0, 2});
  write_exr(folder.path() / "depth_sigma/000007.exr", Image<float>(2, 2, 1.0F));
  EXPECT_THAT(error_of([&] { read_depths(folder.path()); }),
              AllOf(HasSubstr("000007.exr"), HasSubstr("2 x 2")));
  write_file(folder.path() / "depth/7.exr", "");
  EXPECT_THAT(error_of([&] { read_depths(folder.path()); }), HasSubstr("six digits"));
}

Cloud sample_cloud() {
  Rng rng(11);
  Cloud cloud(100);
  for (CloudPoint& point : cloud) {
    point.position_m = Eigen::Vector3d(normal(rng), normal(rng), normal(rng)).cast<float>();
    point.normal = point.position_m.normalized();
    point.color = {static_cast<std::uint8_t>(rng()), 7, 255};
    point.sigma_m = static_cast<float>(uniform(rng) * 1e-4);
  }
  return cloud;
}

void expect_same(const Cloud& a, const Cloud& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].position_m, b[i].position_m);
    EXPECT_EQ(a[i].normal, b[i].normal);
    EXPECT_EQ(a[i].color, b[i].color);
    EXPECT_EQ(a[i].sigma_m, b[i].sigma_m);
  }
}

TEST(SeamIo, CloudsAndClustersComeBackBitByBit) {
  const TemporaryFolder folder;
  const Cloud cloud = sample_cloud();
  write_cloud(folder.path() / "new", cloud);
  expect_same(read_cloud(folder.path() / "new"), cloud);
  Clusters clusters{cloud, std::vector<int>(100, -1), 3};
  for (std::size_t i = 0; i < 90; ++i) clusters.instance[i] = static_cast<int>(i % 3);
  write_clusters(folder.path(), clusters);
  const Clusters read = read_clusters(folder.path());
  expect_same(read.cloud, cloud);
  EXPECT_EQ(read.instance, clusters.instance);
  EXPECT_EQ(read.count, 3);
}

TEST(SeamIo, SilhouettesComeBackBitByBit) {
  const TemporaryFolder folder;
  Rng rng(5);
  Silhouettes silhouettes(3);
  for (int s = 0; s < 2; ++s) {
    Silhouette& silhouette = silhouettes[static_cast<std::size_t>(s)];
    silhouette.frame = 12;
    silhouette.instance = s;
    for (int i = 0; i < 50; ++i) {
      OutlinePoint point;
      point.pixel_px = {static_cast<float>(1000 * uniform(rng)),
                        static_cast<float>(1000 * uniform(rng))};
      point.normal = Eigen::Vector2d(normal(rng), normal(rng)).normalized().cast<float>();
      point.sigma_px = static_cast<float>(uniform(rng));
      point.on_object = i % 3 != 0;
      silhouette.outline.push_back(point);
    }
  }
  silhouettes[1].outline[4].pixel_px.x() = 1e-20F;  // 0.5 added and taken away would lose it
  silhouettes[2].frame = 13;                        // an empty outline
  write_silhouettes(folder.path(), silhouettes, 42);
  const Silhouettes read = read_silhouettes(folder.path());
  ASSERT_EQ(read.size(), 3U);
  for (std::size_t s = 0; s < 3; ++s) {
    EXPECT_EQ(read[s].frame, silhouettes[s].frame);
    EXPECT_EQ(read[s].instance, silhouettes[s].instance);
    ASSERT_EQ(read[s].outline.size(), silhouettes[s].outline.size());
    for (std::size_t i = 0; i < read[s].outline.size(); ++i) {
      EXPECT_EQ(read[s].outline[i].pixel_px, silhouettes[s].outline[i].pixel_px);
      EXPECT_EQ(read[s].outline[i].normal, silhouettes[s].outline[i].normal);
      EXPECT_EQ(read[s].outline[i].sigma_px, silhouettes[s].outline[i].sigma_px);
      EXPECT_EQ(read[s].outline[i].on_object, silhouettes[s].outline[i].on_object);
    }
  }
  EXPECT_THAT(read_file(folder.path() / "masks.json"), HasSubstr("\"image_id\": 42000012"));
}

TEST(SeamIo, AnotherProgramsMaskGetsOutwardNormals) {
  for (const char* polygon :
       {"[10, 10, 20, 10, 20, 20, 10, 20]", "[10, 20, 20, 20, 20, 10, 10, 10]"}) {
    const Silhouettes read = silhouettes_from_json(
        R"([{"image_id": 3, "category_id": 1, "score": 0.9,
             "instance_id": 5, "bbox": [10, 10, 10, 10],
             "segmentation": [)" +
            std::string(polygon) + "]}]",
        "masks.json");
    ASSERT_EQ(read.size(), 1U);
    EXPECT_EQ(read[0].frame, 3);
    for (const OutlinePoint& point : read[0].outline) {
      EXPECT_GT(point.normal.dot(point.pixel_px - Eigen::Vector2f(14.5F, 14.5F)),
                1);  // COCO's 15 is our 14.5
      EXPECT_TRUE(point.on_object);
    }
  }
}

TEST(SeamIo, SurfacesComeBackBitByBit) {
  const TemporaryFolder folder;
  Rng rng(9);
  const auto points = [&](int count) {
    std::vector<Eigen::Vector3d> result;
    for (int i = 0; i < count; ++i) result.emplace_back(normal(rng), normal(rng), normal(rng) / 3);
    return result;
  };
  Surfaces surfaces(3);
  surfaces[0] = {.instance = 2,
                 .status = SurfaceStatus::ok,
                 .mesh = {points(4), {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}}};
  surfaces[0].samples_m = {points(4), points(4)};
  surfaces[1] = {.instance = 0, .status = SurfaceStatus::touching, .points_m = points(7)};
  surfaces[2] = {.instance = 1, .status = SurfaceStatus::too_few_views};
  write_surfaces(folder.path(), surfaces);
  const Surfaces read = read_surfaces(folder.path());
  ASSERT_EQ(read.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(read[i].instance, surfaces[i].instance);
    EXPECT_EQ(read[i].status, surfaces[i].status);
    EXPECT_EQ(read[i].mesh.vertices_m, surfaces[i].mesh.vertices_m);
    EXPECT_EQ(read[i].mesh.triangles, surfaces[i].mesh.triangles);
    EXPECT_EQ(read[i].points_m, surfaces[i].points_m);
    EXPECT_EQ(read[i].samples_m, surfaces[i].samples_m);
  }
  write_file(folder.path() / "surfaces.json",
             R"({"surfaces": [{"instance": 0, "status": "ok", "mesh": "../../etc/passwd"}]})");
  EXPECT_THAT(error_of([&] { read_surfaces(folder.path()); }), HasSubstr("\"..\""));
}

TEST(SeamIo, ACountOfEmptySamplesIsRefused) {
  const TemporaryFolder folder;
  std::string text = R"({"surfaces": [)";
  for (int i = 0; i < 1000; ++i) {
    text += std::string(i > 0 ? "," : "") + R"({"instance": )" + std::to_string(i) +
            R"(, "status": "ok", "mesh": null, "sample_count": 1000000})";
  }
  write_file(folder.path() / "surfaces.json", text + "]}");
  EXPECT_THAT(error_of([&] { read_surfaces(folder.path()); }),
              AllOf(HasSubstr("surfaces.json: /surfaces/0"), HasSubstr("0 sample vertices")));
}

TEST(SeamIo, OneMeshThatIsListedOftenIsBoundedByTheMemoryLimit) {
  const TemporaryFolder folder;
  Mesh mesh;
  mesh.vertices_m.assign(10'000, Eigen::Vector3d(1, 2, 3));
  write_ply(folder.path() / "meshes/000000.ply", mesh);
  std::string text = R"({"surfaces": [)";
  for (int i = 0; i < 100; ++i) {
    text += std::string(i > 0 ? "," : "") + R"({"instance": )" + std::to_string(i) +
            R"(, "status": "ok", "mesh": "meshes/000000.ply"})";
  }
  write_file(folder.path() / "surfaces.json", text + "]}");
  EXPECT_EQ(read_surfaces(folder.path()).size(), 100U);
  set_memory_limit(10'000'000);
  EXPECT_THAT(
      error_of([&] { read_surfaces(folder.path()); }),
      AllOf(HasSubstr("surfaces.json"), HasSubstr("bytes"), HasSubstr("the limit is 10000000")));
  set_memory_limit(0);
}

TEST(SeamIo, DepthImagesAreBoundedByTheMemoryLimitBeforeTheyAreRead) {
  const TemporaryFolder folder;
  Depths depths(3);
  for (int i = 0; i < 3; ++i)
    depths[static_cast<std::size_t>(i)] = {.frame = i, .depth_m = Image<float>(1000, 1000, 1.0F)};
  write_depths(folder.path(), depths);
  set_memory_limit(9'000'000);
  EXPECT_THAT(error_of([&] { read_depths(folder.path()); }),
              AllOf(HasSubstr("000002.exr"), HasSubstr("12000000 bytes")));
  set_memory_limit(0);
  EXPECT_EQ(read_depths(folder.path()).size(), 3U);
}

TEST(SeamIo, AnotherUnitInAPlyAndClustersWithoutInstancesAreRefused) {
  const TemporaryFolder folder;
  const auto ply = [](const std::string& comment, const std::string& property) {
    return "ply\nformat ascii 1.0\n" + comment +
           "element vertex 1\nproperty float x\nproperty float y\nproperty float z\n" + property +
           "end_header\n1 2 3" + (property.empty() ? "" : " 0") + "\n";
  };
  const std::string instance = "property int instance\n";
  write_file(folder.path() / "cloud.ply", ply("comment units: mm\n", ""));
  write_file(folder.path() / "clusters.ply", ply("comment made by mine\n", instance));
  EXPECT_THAT(error_of([&] { read_cloud(folder.path()); }),
              AllOf(HasSubstr("cloud.ply"), HasSubstr("units: mm"), HasSubstr("metres")));
  EXPECT_EQ(read_clusters(folder.path()).count, 1);
  write_file(folder.path() / "cloud.ply", ply("comment unit m\n", ""));
  write_file(folder.path() / "clusters.ply", ply("", "property int label\n"));
  EXPECT_EQ(read_cloud(folder.path()).size(), 1U);
  EXPECT_THAT(error_of([&] { read_clusters(folder.path()); }),
              AllOf(HasSubstr("clusters.ply"), HasSubstr("no property \"instance\"")));
}

TEST(SeamIo, TraitsAndTimingsComeBackBitByBit) {
  const TemporaryFolder folder;
  Traits traits(2);
  traits[0] = {
      .instance = 1, .status = TraitStatus::ok, .centroid_in_world_m = {1 / 3.0, 2 / 7.0, -0.0}};
  traits[0].traits = {{"volume", "m3", 1e-8 / 3, 1e-10 / 7}, {"length", "m", 0.01 / 3, kNaN}};
  traits[1] = {.instance = 0, .status = TraitStatus::not_solved, .reason = "too few \"views\"\n"};
  write_traits(folder.path(), traits);
  const Traits read = read_traits(folder.path());
  ASSERT_EQ(read.size(), 2U);
  EXPECT_TRUE(same_bits(read[0].centroid_in_world_m, traits[0].centroid_in_world_m));
  EXPECT_TRUE(same_bits(read[0].traits[0].value, traits[0].traits[0].value));
  EXPECT_TRUE(same_bits(read[0].traits[0].sigma, traits[0].traits[0].sigma));
  EXPECT_TRUE(std::isnan(read[0].traits[1].sigma));
  EXPECT_EQ(read[0].traits[1].unit, "m");
  EXPECT_EQ(read[1].reason, traits[1].reason);
  EXPECT_EQ(read[1].status, TraitStatus::not_solved);
  EXPECT_TRUE(read[1].centroid_in_world_m.array().isNaN().all());

  write_timings(folder.path(),
                {{"poses", 1 / 3.0, 2 / 3.0, 100.1, 100 / 7.0}, {"depth", 1, 2, 100.1}});
  const std::vector<StageTiming> timings = read_timings(folder.path());
  ASSERT_EQ(timings.size(), 2U);
  EXPECT_EQ(timings[0].stage, "poses");
  EXPECT_EQ(timings[0].cpu_s, 2 / 3.0);
  EXPECT_EQ(timings[0].peak_above_start_mb, 100 / 7.0);
  EXPECT_TRUE(std::isnan(timings[1].peak_above_start_mb));
  // Another program may not know it.
  write_file(folder.path() / "timings.json",
             R"({"stages": [{"stage": "x", "wall_s": 1, "cpu_s": 1, "peak_rss_mb": 9}]})");
  EXPECT_TRUE(std::isnan(read_timings(folder.path()).at(0).peak_above_start_mb));
}

TEST(SeamIo, AMissingSeamIsNamed) {
  const TemporaryFolder folder;
  EXPECT_THAT(error_of([&] { read_corners(folder.path()); }),
              HasSubstr("corners.json: cannot read"));
  EXPECT_THAT(error_of([&] { read_poses(folder.path()); }), HasSubstr("poses.json: cannot read"));
  EXPECT_THAT(error_of([&] { read_depths(folder.path()); }),
              HasSubstr("depth: the folder is missing"));
  EXPECT_THAT(error_of([&] { read_silhouettes(folder.path()); }),
              HasSubstr("masks.json: cannot read"));
  EXPECT_THAT(error_of([&] { read_surfaces(folder.path()); }),
              HasSubstr("surfaces.json: cannot read"));
  EXPECT_THAT(error_of([&] { read_traits(folder.path()); }), HasSubstr("traits.json: cannot read"));
  EXPECT_NE(error_of([&] { read_cloud(folder.path()); }), "");
}

TEST(SeamIo, NumbersThatAreNotFiniteAreNotWritten) {
  const TemporaryFolder folder;
  Corners corners(1);
  corners[0].corners = {{0, 0, {kNaN, 0}}};
  EXPECT_THROW(write_corners(folder.path(), corners), std::invalid_argument);
  EXPECT_FALSE(fs::exists(folder.path() / "corners.json"));
}

}  // namespace
}  // namespace cousin
