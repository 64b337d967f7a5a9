#include "sim/dataset/truth_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/capture_io.h"
#include "sim/imaging/image_io.h"
#include "sim/imaging/npy.h"
#include "sim/types/memory_limit.h"
#include "tests/sim/dataset/sample_capture.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

constexpr int kWidth = 16, kHeight = 12;

Mesh tetrahedron(double size_m) {
  return {{{0, 0, 0}, {size_m, 0, 0}, {0, size_m / 3, 0}, {0, 0, size_m / 7}},
          {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
}

Scene sample_scene(Rng& rng) {
  Scene scene{.name = "seeds", .rig = "phone", .board = "markers"};
  scene.models = {{.name = "kernel", .mesh = tetrahedron(0.01)},
                  {.name = "plate", .mesh = tetrahedron(0.1)}};
  scene.models[0].triangle_part = {0, 1, 1, 0};
  scene.models[0].part_names = {"germ", "endosperm"};
  scene.models[0].keypoints = {{"tip", {0.01 / 3, 0, 0}}, {"crown", {0, 0.01 / 7, 0}}};
  scene.materials = {{.name = "seed", .albedo = {0.1F, 0.2F, 0.3F}, .ior = 1.4 / 3 + 1},
                     {.name = "paper", .print = SeedBoard{}},
                     {.name = "water", .kind = SurfaceKind::clear, .ior = 1.333},
                     {.name = "flesh", .mean_free_path_m = {1e-3F / 3, 5e-4F, 1e-4F}}};
  for (int i = 0; i < 3; ++i) {
    Instance instance{
        .id = 10 - 3 * i, .name = "i" + std::to_string(i), .category = i == 2 ? "board" : "maize"};
    instance.is_specimen = i != 2;
    instance.model = i == 2 ? 1 : 0;
    instance.material = instance.model;
    instance.world_from_object = odd_pose(rng);
    instance.mass_kg = 3e-4 / 7;
    if (instance.is_specimen)
      instance.traits = {{"volume", "m3", 1e-8 / 3}, {"length", "m", 0.01 / 7}};
    if (i == 0) instance.labels = {{"maturity", "very \"ripe\""}, {"variety", "zea"}};
    scene.instances.push_back(instance);
  }
  scene.instances[0].part_materials = {1, 0};
  scene.instances.push_back({.id = 20, .name = "organ", .category = "maize"});
  scene.instances.back().part_of = 10;
  scene.instances[0].keypoint_carriers.assign(scene.models[0].keypoints.size(), 20);
  scene.materials[0].infrared_noise = {{1 / 3.0F, 0.01 / 7, 3}};
  scene.instances[0].motion = {{0, odd_pose(rng)}, {1 / 3.0, odd_pose(rng)}};
  scene.lights = {Sun{Eigen::Vector3d(1, 2, 3).normalized(), 0.005, {1, 2, 3}},
                  Sky{{1, 1, 2}, {1, 1, 1}, {0.1F, 0.1F, 0.1F}},
                  Lamp{{0, 0, 1}, {0.1, 0, 0}, {0, 0.1, 0}, {10, 10, 9.9F}}};
  scene.views = {{0.5, odd_pose(rng), odd_pose(rng)}, {1 / 3.0, odd_pose(rng), odd_pose(rng)}};
  scene.views[1].focus_in_world_m = {1 / 3.0, -1 / 7.0, 2};
  return scene;
}

SceneTruth sample_truth() {
  Rng rng(21);
  SceneTruth truth{
      .seed = 0xfedcba9876543210U, .config_toml = "seed_count = 10\n", .scene = sample_scene(rng)};
  truth.shared_plants = {"tray", "a \"quoted\" plant"};
  for (int i = 0; i < 2; ++i) {
    TrueView view{.frame = 5 * i, .time_s = i / 3.0, .camera = odd_camera(kWidth, kHeight, i)};
    view.camera_from_world = odd_pose(rng);
    view.camera_from_world_end = odd_pose(rng);
    view.exposure_s = i / 7.0;
    view.readout_s = 0.01 / 3;
    view.aperture_radius_m = 1e-3 / 7;
    if (i == 1) view.focus_m = 1 / 3.0;
    truth.views.push_back(view);

    TruthImages images;
    images.depth_m = Image<float>(kWidth, kHeight, 0.3F);
    images.depth_m(1, 1) = std::numeric_limits<float>::quiet_NaN();
    images.normal = Image<Eigen::Vector3f>(kWidth, kHeight, Eigen::Vector3f(0.1F, 0.2F, -0.9F));
    images.position_m = Image<Eigen::Vector3f>(
        kWidth, kHeight, Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN()));
    images.position_m(3, 4) = {1 / 3.0F, 2, 3};
    images.instance = Image<std::int32_t>(kWidth, kHeight, -1);
    images.instance(3, 4) = 7;
    images.instance(4, 4) = 10;
    images.part = Image<std::uint16_t>(kWidth, kHeight, 65535);
    images.part(3, 4) = 1;
    images.specimen_coverage = Image<float>(kWidth, kHeight, 1 / 3.0F);
    images.visibility = {{7, 100, 50, 0.5, 1, 2, 3, 4}, {10, 3, 1, 1 / 3.0, -5, 0, 2, 2}};
    images.masks_full.assign(2, Image<std::uint8_t>(kWidth, kHeight));
    images.masks_full[0](2, 3) = images.masks_full[1](4, 4) = 255;
    images.visibility[0].seen_x = 2;
    images.visibility[0].seen_width = images.visibility[0].seen_height = 1;
    images.shares = {{7, kWidth, kHeight, {{2, 1, 0.25F}, {0, 2, 1 / 3.0F}}, 0},
                     {10, kWidth, kHeight, {}, 0}};
    for (const PixelShare& p : images.shares[0].pixels)
      images.shares[0].area_px += static_cast<double>(p.share);
    images.keypoints = {{7, 0, PointState::visible, {1.25, -0.5}, 0.3}};
    images.keypoints.push_back({});
    images.keypoints.back().instance = 7;
    images.keypoints.back().state = PointState::outside;
    for (ViewMatch* match : {&images.flow, &images.stereo}) {
      match->flow_px = Image<Eigen::Vector2f>(kWidth, kHeight, {1.5F, -1 / 3.0F});
      match->state = Image<PointState>(kWidth, kHeight, PointState::visible);
      match->state(2, 2) = PointState::occluded;
    }
    images.noise_free_depth_m = Image<float>(20, 10, 1 / 3.0F);
    images.noise_free_depth_m(2, 3) = std::numeric_limits<float>::quiet_NaN();
    images.invalid_reason = Image<std::uint8_t>(20, 10, static_cast<std::uint8_t>(i));
    images.invalid_reason(19, 9) = 7;
    truth.images.push_back(std::move(images));
  }
  // A depth sensor beside the first, with pixels of its own.
  truth.other_sensors = {{"depth", truth.views}};
  for (TrueView& view : truth.other_sensors[0].views) {
    view.camera = odd_camera(20, 10, 5);
    view.camera_from_world = view.camera_from_world_end = odd_pose(rng);
    view.time_s += 1e-4;
  }
  return truth;
}

void expect_equal(const Scene& a, const Scene& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.rig, b.rig);
  EXPECT_EQ(a.board, b.board);
  ASSERT_EQ(a.models.size(), b.models.size());
  for (std::size_t i = 0; i < a.models.size(); ++i) {
    EXPECT_EQ(a.models[i].name, b.models[i].name);
    EXPECT_EQ(a.models[i].mesh.vertices_m, b.models[i].mesh.vertices_m);
    EXPECT_EQ(a.models[i].mesh.triangles, b.models[i].mesh.triangles);
    EXPECT_EQ(a.models[i].triangle_part, b.models[i].triangle_part);
    EXPECT_EQ(a.models[i].part_names, b.models[i].part_names);
    ASSERT_EQ(a.models[i].keypoints.size(), b.models[i].keypoints.size());
    for (std::size_t k = 0; k < a.models[i].keypoints.size(); ++k) {
      EXPECT_EQ(a.models[i].keypoints[k].name, b.models[i].keypoints[k].name);
      EXPECT_EQ(a.models[i].keypoints[k].in_object_m, b.models[i].keypoints[k].in_object_m);
    }
  }
  ASSERT_EQ(a.materials.size(), b.materials.size());
  for (std::size_t i = 0; i < a.materials.size(); ++i) {
    EXPECT_EQ(a.materials[i].albedo, b.materials[i].albedo);
    EXPECT_EQ(a.materials[i].ior, b.materials[i].ior);
    EXPECT_EQ(a.materials[i].kind, b.materials[i].kind);
    EXPECT_EQ(a.materials[i].mean_free_path_m, b.materials[i].mean_free_path_m);
    EXPECT_EQ(a.materials[i].print.has_value(), b.materials[i].print.has_value());
    const auto& x = a.materials[i].infrared_noise;
    const auto& y = b.materials[i].infrared_noise;
    ASSERT_EQ(x.has_value(), y.has_value());
    if (x) {
      EXPECT_EQ(std::tie(x->other_albedo, x->scale_m, x->octaves),
                std::tie(y->other_albedo, y->scale_m, y->octaves));
    }
  }
  ASSERT_EQ(a.instances.size(), b.instances.size());
  for (std::size_t i = 0; i < a.instances.size(); ++i) {
    const Instance& x = a.instances[i];
    const Instance& y = b.instances[i];
    EXPECT_EQ(x.part_materials, y.part_materials);
    EXPECT_EQ(x.part_of, y.part_of);
    EXPECT_EQ(x.keypoint_carriers, y.keypoint_carriers);
    EXPECT_EQ(std::tie(x.id, x.name, x.category, x.is_specimen, x.model, x.material, x.mass_kg),
              std::tie(y.id, y.name, y.category, y.is_specimen, y.model, y.material, y.mass_kg));
    EXPECT_TRUE(same_pose(x.world_from_object, y.world_from_object));
    ASSERT_EQ(x.motion.size(), y.motion.size());
    for (std::size_t k = 0; k < x.motion.size(); ++k) {
      EXPECT_EQ(x.motion[k].time_s, y.motion[k].time_s);
      EXPECT_TRUE(same_pose(x.motion[k].world_from_object, y.motion[k].world_from_object));
    }
    ASSERT_EQ(x.labels.size(), y.labels.size());
    for (std::size_t k = 0; k < x.labels.size(); ++k) {
      EXPECT_EQ(std::tie(x.labels[k].name, x.labels[k].value),
                std::tie(y.labels[k].name, y.labels[k].value));
    }
    ASSERT_EQ(x.traits.size(), y.traits.size());
    for (std::size_t k = 0; k < x.traits.size(); ++k) {
      EXPECT_EQ(std::tie(x.traits[k].name, x.traits[k].unit, x.traits[k].value),
                std::tie(y.traits[k].name, y.traits[k].unit, y.traits[k].value));
    }
  }
  ASSERT_EQ(a.lights.size(), b.lights.size());
  EXPECT_EQ(std::get<Sun>(a.lights[0]).to_sun, std::get<Sun>(b.lights[0]).to_sun);
  EXPECT_EQ(std::get<Sky>(a.lights[1]).zenith, std::get<Sky>(b.lights[1]).zenith);
  EXPECT_EQ(std::get<Lamp>(a.lights[2]).radiance, std::get<Lamp>(b.lights[2]).radiance);
  ASSERT_EQ(a.views.size(), b.views.size());
  for (std::size_t i = 0; i < a.views.size(); ++i) {
    EXPECT_EQ(a.views[i].time_s, b.views[i].time_s);
    EXPECT_TRUE(same_pose(a.views[i].rig_from_world, b.views[i].rig_from_world));
    EXPECT_TRUE(same_pose(a.views[i].rig_from_world_end, b.views[i].rig_from_world_end));
    EXPECT_EQ(a.views[i].focus_in_world_m, b.views[i].focus_in_world_m);
  }
}

void expect_equal(const TruthImages& a, const TruthImages& b) {
  EXPECT_TRUE(same_bits(a.depth_m, b.depth_m));
  EXPECT_TRUE(same_bits(a.normal, b.normal));
  EXPECT_TRUE(same_bits(a.position_m, b.position_m));
  EXPECT_TRUE(same_bits(a.instance, b.instance));
  EXPECT_TRUE(same_bits(a.part, b.part));
  EXPECT_TRUE(same_bits(a.specimen_coverage, b.specimen_coverage));
  ASSERT_EQ(a.visibility.size(), b.visibility.size());
  for (std::size_t i = 0; i < a.visibility.size(); ++i) {
    const InstanceVisibility& x = a.visibility[i];
    const InstanceVisibility& y = b.visibility[i];
    EXPECT_EQ(
        std::tie(x.instance, x.pixels_full, x.pixels_visible, x.visible_fraction, x.box_x, x.box_y,
                 x.box_width, x.box_height, x.seen_x, x.seen_y, x.seen_width, x.seen_height),
        std::tie(y.instance, y.pixels_full, y.pixels_visible, y.visible_fraction, y.box_x, y.box_y,
                 y.box_width, y.box_height, y.seen_x, y.seen_y, y.seen_width, y.seen_height));
  }
  ASSERT_EQ(a.shares.size(), b.shares.size());
  for (std::size_t i = 0; i < a.shares.size(); ++i) {
    EXPECT_EQ(a.shares[i].instance, b.shares[i].instance);
    EXPECT_EQ(a.shares[i].pixels, b.shares[i].pixels);
    EXPECT_EQ(a.shares[i].area_px, b.shares[i].area_px);
  }
  ASSERT_EQ(a.keypoints.size(), b.keypoints.size());
  for (std::size_t i = 0; i < a.keypoints.size(); ++i) {
    const KeypointView &x = a.keypoints[i], &y = b.keypoints[i];
    EXPECT_EQ(std::tie(x.instance, x.keypoint, x.state), std::tie(y.instance, y.keypoint, y.state));
    EXPECT_EQ(std::isnan(x.depth_m), std::isnan(y.depth_m));
    if (!std::isnan(x.depth_m)) {
      EXPECT_EQ(x.pixel_px, y.pixel_px);
      EXPECT_EQ(x.depth_m, y.depth_m);
    }
  }
  for (const auto match : {&TruthImages::flow, &TruthImages::stereo}) {
    EXPECT_EQ((a.*match).flow_px, (b.*match).flow_px);
    EXPECT_EQ((a.*match).state, (b.*match).state);
  }
  EXPECT_EQ(a.masks_full, b.masks_full);
  EXPECT_TRUE(same_bits(a.noise_free_depth_m, b.noise_free_depth_m));
  EXPECT_EQ(a.invalid_reason, b.invalid_reason);
}

class TruthIoInFormats : public testing::TestWithParam<TruthFormat> {};

TEST_P(TruthIoInFormats, EveryBitComesBack) {
  const TemporaryFolder folder;
  const SceneTruth truth = sample_truth();
  write_truth(folder.path(), truth, GetParam());
  const SceneTruth read = read_truth(folder.path());
  EXPECT_EQ(read.seed, truth.seed);
  EXPECT_EQ(read.config_toml, truth.config_toml);
  EXPECT_EQ(read.shared_plants, truth.shared_plants);
  expect_equal(read.scene, truth.scene);
  ASSERT_EQ(read.views.size(), 2U);
  ASSERT_EQ(read.images.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(read.views[i].frame, truth.views[i].frame);
    EXPECT_EQ(read.views[i].time_s, truth.views[i].time_s);
    EXPECT_EQ(read.views[i].camera, truth.views[i].camera);
    EXPECT_TRUE(same_pose(read.views[i].camera_from_world, truth.views[i].camera_from_world));
    EXPECT_TRUE(
        same_pose(read.views[i].camera_from_world_end, truth.views[i].camera_from_world_end));
    EXPECT_EQ(read.views[i].exposure_s, truth.views[i].exposure_s);
    EXPECT_EQ(read.views[i].readout_s, truth.views[i].readout_s);
    EXPECT_EQ(read.views[i].aperture_radius_m, truth.views[i].aperture_radius_m);
    EXPECT_EQ(read.views[i].focus_m, truth.views[i].focus_m);
    expect_equal(read.images[i], truth.images[i]);
  }
  ASSERT_EQ(read.other_sensors.size(), 1U);
  EXPECT_EQ(read.other_sensors[0].sensor, "depth");
  for (std::size_t i = 0; i < 2; ++i) {
    const TrueView &a = read.other_sensors[0].views[i], &b = truth.other_sensors[0].views[i];
    EXPECT_EQ(a.camera, b.camera);
    EXPECT_EQ(a.time_s, b.time_s);
    EXPECT_TRUE(same_pose(a.camera_from_world, b.camera_from_world));
  }
}

TEST(TruthIo, WhatAnotherSensorSeesComesBackFromItsFolder) {
  const TemporaryFolder folder;
  SceneTruth truth = sample_truth();
  SensorViews right{"right", truth.views, truth.images};
  for (TruthImages& images : right.images) {
    images.flow = images.stereo = {};
    images.noise_free_depth_m = {};
    images.invalid_reason = {};
    images.instance(3, 4) = 10;
    images.visibility[0].pixels_visible = 49;
    images.keypoints.front().depth_m = 0.4;
  }
  truth.other_sensors.push_back(right);
  // The images of a frame can be written before.
  write_truth_images(folder.path() / "b", truth.scene, 0, right.images[0], TruthFormat::npy,
                     "right");
  write_truth(folder.path(), truth);
  const fs::path own = folder.path() / "truth/sensors/right";
  EXPECT_EQ(read_file(folder.path() / "b/truth/sensors/right/instance/000000.png"),
            read_file(own / "instance/000000.png"));
  EXPECT_NE(read_file(own / "instance/000000.png"),
            read_file(folder.path() / "truth/instance/000000.png"));
  EXPECT_FALSE(fs::exists(folder.path() / "truth/sensors/depth"));
  const SceneTruth read = read_truth(folder.path());
  EXPECT_EQ(sensors_with_truth(read), (std::vector<std::size_t>{0, 2}));
  for (std::size_t i = 0; i < 2; ++i) {
    expect_equal(truth_of_sensor(read, 2).images[i], right.images[i]);
    expect_equal(truth_of_sensor(read, 0).images[i], truth.images[i]);
  }
  truth.other_sensors[1].images.pop_back();
  EXPECT_THROW(write_truth(folder.path() / "c", truth), std::invalid_argument);
}

TEST(TruthIo, ASensorsNameLeadsNowhereElse) {
  const TemporaryFolder folder;
  SceneTruth truth = sample_truth();
  truth.other_sensors[0].sensor = "../../elsewhere";
  write_truth(folder.path(), truth);
  EXPECT_THAT(error_of([&] { read_truth(folder.path()); }),
              AllOf(HasSubstr("elsewhere"), HasSubstr("must lie inside the folder")));
}

INSTANTIATE_TEST_SUITE_P(Formats, TruthIoInFormats,
                         testing::Values(TruthFormat::npy, TruthFormat::exr),
                         [](const auto& format) { return to_string(format.param); });

TEST(TruthIo, AsPngDepthsAreRoundedAndAllElseComesBack) {
  const TemporaryFolder folder;
  const SceneTruth truth = sample_truth();
  write_truth(folder.path(), truth, TruthFormat::png16);
  EXPECT_TRUE(fs::exists(folder.path() / "truth/noise_free_depth/000005.png"));
  SceneTruth read = read_truth(folder.path());
  ASSERT_EQ(read.images.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    TruthImages& images = read.images[i];
    for (const auto depth : {&TruthImages::depth_m, &TruthImages::noise_free_depth_m}) {
      const Image<float>& expected = truth.images[i].*depth;
      ASSERT_EQ((images.*depth).size(), expected.size());
      for (std::size_t k = 0; k < expected.size(); ++k) {
        const float a = (images.*depth).data()[k], b = expected.data()[k];
        ASSERT_EQ(std::isnan(a), std::isnan(b));
        if (!std::isnan(b)) EXPECT_NEAR(a, b, 0.5e-4);  // half a step of 0.1 mm
      }
      images.*depth = expected;
    }
    expect_equal(images, truth.images[i]);
  }
}

TEST(TruthIo, TheSameImageInTwoFormatsIsRefused) {
  const TemporaryFolder folder;
  write_truth(folder.path(), sample_truth(), TruthFormat::exr);
  write_truth(folder.path(), sample_truth(), TruthFormat::npy);
  EXPECT_THAT(error_of([&] { read_truth(folder.path()); }),
              AllOf(HasSubstr("depth/000000.exr"), HasSubstr("depth/000000.npy")));
}

TEST(TruthIo, ADepthSensorsImagesMustFitItsOwnCamera) {
  const TemporaryFolder folder;
  SceneTruth truth = sample_truth();
  truth.images[0].invalid_reason = Image<std::uint8_t>(16, 12);  // the first sensor's size
  write_truth(folder.path(), truth);
  EXPECT_THAT(error_of([&] { read_truth(folder.path()); }),
              AllOf(HasSubstr("invalid_reason/000000.png (frame 0)"),
                    HasSubstr("16 x 12 pixels; its camera has 20 x 10")));
  truth.other_sensors[0].views.pop_back();
  EXPECT_THROW(write_truth(folder.path() / "b", truth), std::invalid_argument);
}

TEST(TruthIo, ImagesThatDoNotFitIntoMemoryAreRefusedBeforeTheyAreRead) {
  const TemporaryFolder folder;
  write_truth(folder.path(), sample_truth());
  // As if the views were of large images, whose files are small.
  const fs::path cameras = folder.path() / "truth/camera.json";
  std::string text = read_file(cameras);
  const std::string width = "\"width_px\": " + std::to_string(kWidth);
  ASSERT_NE(text.find(width), std::string::npos);
  for (std::size_t at = 0; (at = text.find(width, at)) != std::string::npos; ++at)
    text.replace(at, width.size(), "\"width_px\": 16000");
  write_file(cameras, text);
  set_memory_limit(1'000'000);
  EXPECT_THAT(error_of([&] { read_truth(folder.path()); }),
              AllOf(HasSubstr("truth/camera.json"), HasSubstr("the truth images up to frame"),
                    HasSubstr("the limit is 1000000 bytes")));
  set_memory_limit(0);
}

TEST(TruthIo, WhatWasNotPlannedIsNotThere) {
  const TemporaryFolder folder;
  SceneTruth truth = sample_truth();
  for (TruthImages& images : truth.images) {
    images.normal = {};
    images.position_m = {};
    images.instance = {};
    images.masks_full.clear();
  }
  write_truth(folder.path(), truth);
  for (const char* absent : {"normal", "position", "instance", "mask", "mask_visib"}) {
    EXPECT_FALSE(fs::exists(folder.path() / "truth" / absent)) << absent;
  }
  const SceneTruth read = read_truth(folder.path());
  expect_equal(read.images[1], truth.images[1]);

  const TemporaryFolder second;
  truth.images.clear();
  write_truth(second.path(), truth);
  EXPECT_FALSE(fs::exists(second.path() / "truth/scene_gt_info.json"));
  EXPECT_TRUE(read_truth(second.path()).images.empty());
}

TEST(TruthIo, AMaskWithoutAPixelHasNoFileAndReadsAsEmpty) {
  const TemporaryFolder folder;
  SceneTruth truth = sample_truth();
  truth.images[0].masks_full[0] = Image<std::uint8_t>(kWidth, kHeight);
  truth.images[0].visibility[0] = {.instance = 7};
  truth.images[0].instance(3, 4) = -1;
  write_truth(folder.path(), truth);
  for (const char* name : {"mask/000000_000000.png", "mask_visib/000000_000000.png"})
    EXPECT_FALSE(fs::exists(folder.path() / "truth" / name)) << name;
  EXPECT_TRUE(fs::exists(folder.path() / "truth/mask/000005_000000.png"));
  const SceneTruth read = read_truth(folder.path());
  expect_equal(read.images[0], truth.images[0]);
}

TEST(TruthIo, FramesWrittenOneByOneMakeTheSameFolder) {
  const TemporaryFolder whole, parts;
  SceneTruth truth = sample_truth();
  write_truth(whole.path(), truth);
  for (std::size_t i = 0; i < truth.images.size(); ++i) {
    write_truth_images(parts.path(), truth.scene, truth.views[i].frame, truth.images[i]);
    truth.images[i] = {.visibility = truth.images[i].visibility,
                       .keypoints = truth.images[i].keypoints};
  }
  write_truth(parts.path(), truth);
  std::size_t files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(whole.path())) {
    if (!entry.is_regular_file()) continue;
    const fs::path file = fs::relative(entry.path(), whole.path());
    EXPECT_EQ(read_file(parts.path() / file), read_file(entry.path())) << file;
    ++files;
  }
  std::size_t parts_files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(parts.path()))
    parts_files += entry.is_regular_file() ? 1 : 0;
  EXPECT_EQ(parts_files, files);
  std::swap(truth.images[0].visibility[0], truth.images[0].visibility[1]);
  EXPECT_THROW(write_truth_images(parts.path(), truth.scene, 0, truth.images[0]),
               std::invalid_argument);
}

TEST(TruthIo, BopMasksFollowTheSpecimensById) {
  const TemporaryFolder folder;
  write_truth(folder.path(), sample_truth());
  const fs::path truth = folder.path() / "truth";
  // Specimens are 7 and 10: the second is seen in pixel (4, 4).
  EXPECT_EQ(read_png8(truth / "mask_visib/000005_000001.png")(4, 4), 255);
  EXPECT_EQ(read_png8(truth / "mask_visib/000005_000001.png")(3, 4), 0);
  EXPECT_EQ(read_png8(truth / "mask_visib/000005_000000.png")(3, 4), 255);
  EXPECT_EQ(read_png8(truth / "mask/000000_000001.png")(4, 4), 255);
  EXPECT_TRUE(fs::exists(truth / "models/obj_000002.ply"));
  EXPECT_THAT(read_file(truth / "scene_gt.json"),
              AllOf(HasSubstr("cam_R_m2c"), HasSubstr("\"obj_id\": 1")));
}

TEST(TruthIo, ACaptureReadsWithoutTruth) {
  const TemporaryFolder folder;
  write_capture(folder.path(), sample_capture());
  write_truth(folder.path(), sample_truth());
  fs::remove_all(folder.path() / "truth");
  EXPECT_EQ(read_capture(folder.path()).frames.size(), 3U);
  EXPECT_THAT(error_of([&] { read_truth(folder.path()); }), HasSubstr("config.toml: cannot read"));
}

TEST(TruthIo, BadFilesAreNamed) {
  const TemporaryFolder folder;
  write_truth(folder.path(), sample_truth(), TruthFormat::exr);
  const fs::path truth = folder.path() / "truth";
  const auto error = [&] { return error_of([&] { read_truth(folder.path()); }); };
  const auto with = [&](const char* file, const std::string& from, const std::string& to) {
    const std::string good = read_file(truth / file);
    std::string bad = good;
    const std::size_t at = bad.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    if (at != std::string::npos) bad.replace(at, from.size(), to);
    write_file(truth / file, bad);
    const std::string message = error();
    write_file(truth / file, good);
    return message;
  };
  EXPECT_EQ(error(), "");
  EXPECT_THAT(with("seed", "1", "x"), HasSubstr("seed: not a number"));
  EXPECT_THAT(with("camera.json", "\"frame\": 5", "\"frame\": 0"), HasSubstr("occurs twice"));
  EXPECT_THAT(with("camera.json", "\"fx_px\": 50", "\"fx_px\": -50"),
              AllOf(HasSubstr("camera.json"), HasSubstr("frame 0")));
  EXPECT_THAT(with("scene.json", "models/obj_000001.ply", "../../obj.ply"), HasSubstr("\"..\""));
  EXPECT_THAT(with("scene.json", "\"model\": 1", "\"model\": 9"), HasSubstr("scene.json"));
  EXPECT_THAT(with("scene.json", "\"kind\": \"sun\"", "\"kind\": \"moon\""),
              HasSubstr("/lights/0/kind = \"moon\""));
  EXPECT_THAT(with("scene.json", "[0, 1, 1, 2, 0, 1]", "[0, 1, 2, 2, 0, 1]"),
              HasSubstr("/models/0/part_runs/2 = 2"));
  EXPECT_THAT(with("scene.json", "[0, 1, 1, 2, 0, 1]", "[0, 1, 1, 99999999]"),
              HasSubstr("/models/0/part_runs/3 = 99999999"));
  EXPECT_THAT(with("scene.json", "[0, 1, 1, 2, 0, 1]", "[0, 1, 1]"),
              HasSubstr("/models/0/part_runs"));
  EXPECT_THAT(with("traits.json", "\"instance\": 10", "\"instance\": 11"),
              HasSubstr("/instances/0/instance = 11"));
  EXPECT_THAT(with("camera.json", "\"readout_s\": 0.00", "\"readout_s\": -0.00"),
              HasSubstr("/views/0/readout_s = -0.00"));
  EXPECT_THAT(with("keypoints.json", "\"model\": 0", "\"model\": 4"),
              HasSubstr("/models/0/model = 4"));
  EXPECT_THAT(with("keypoints.json", "\"state\": \"visible\"", "\"state\": \"seen\""),
              HasSubstr("/frames/0/0/state = \"seen\""));
  EXPECT_THAT(with("keypoints.json", "\"keypoint\": 0", "\"keypoint\": 2"),
              HasSubstr("/frames/0/0/keypoint = 2"));
  EXPECT_THAT(with("keypoints.json", "\"instance\": 7", "\"instance\": 4"),
              HasSubstr("/frames/0/0/instance = 4"));
  EXPECT_THAT(with("scene_gt_info.json", "\"visib_fract\": 0.5", "\"visib_fract\": 1.5"),
              HasSubstr("visib_fract = 1.5"));
  EXPECT_THAT(with("scene_gt_info.json", "\"5\": [", "\"6\": ["), HasSubstr("lacks the key \"5\""));

  write_exr(truth / "depth/000005.exr", Image<float>(3, 3));
  EXPECT_THAT(error(),
              AllOf(HasSubstr("depth/000005.exr"), HasSubstr("frame 5"), HasSubstr("3 x 3")));
  fs::remove(truth / "depth/000005.exr");
  const std::string normals = read_file(truth / "normal/000005.exr");
  for (const std::size_t n :
       {std::size_t{0}, std::size_t{3}, normals.size() / 2, normals.size() - 1}) {
    write_file(truth / "normal/000005.exr", normals.substr(0, n));
    EXPECT_THAT(error(), HasSubstr("normal/000005.exr")) << n;
  }
  fs::copy_file(truth / "coverage/000005.exr", truth / "normal/000005.exr",
                fs::copy_options::overwrite_existing);
  EXPECT_THAT(error(), HasSubstr("lacks the channel X"));
  fs::remove(truth / "normal/000005.exr");
  fs::remove(truth / "mask/000000_000001.png");
  EXPECT_THAT(error(), AllOf(HasSubstr("mask"), HasSubstr("frame 0")));
  write_exr(truth / "coverage/000000_000001.exr", Image<float>(kWidth, kHeight, 1.5F));
  fs::copy_file(truth / "mask/000000_000000.png", truth / "mask/000000_000001.png");
  EXPECT_THAT(error(), AllOf(HasSubstr("000000_000001.exr"), HasSubstr("1.5")));
  fs::remove(truth / "coverage/000000_000001.exr");
  EXPECT_THAT(error(), AllOf(HasSubstr("coverage"), HasSubstr("2 specimens")));
}

TEST(TruthIo, BadNpyFilesAreNamed) {
  const TemporaryFolder folder;
  write_truth(folder.path(), sample_truth());
  const fs::path truth = folder.path() / "truth";
  const auto error = [&] { return error_of([&] { read_truth(folder.path()); }); };
  EXPECT_EQ(error(), "");
  const std::string depth = read_file(truth / "depth/000005.npy");
  write_npy(truth / "depth/000005.npy", Image<float>(3, 3));
  EXPECT_THAT(error(),
              AllOf(HasSubstr("depth/000005.npy"), HasSubstr("frame 5"), HasSubstr("3 x 3")));
  write_file(truth / "depth/000005.npy", depth.substr(0, depth.size() - 4));
  EXPECT_THAT(error(), AllOf(HasSubstr("depth/000005.npy"), HasSubstr("its shape needs")));
  fs::copy_file(truth / "normal/000005.npy", truth / "depth/000005.npy",
                fs::copy_options::overwrite_existing);
  EXPECT_THAT(error(), AllOf(HasSubstr("depth/000005.npy"), HasSubstr("(12, 16, 3)")));
  fs::remove(truth / "depth/000005.npy");
  Image<Eigen::Vector3f> flow(kWidth, kHeight, Eigen::Vector3f(0, 0, 4));
  write_npy(truth / "flow/000005.npy", flow);
  EXPECT_THAT(error(), AllOf(HasSubstr("flow/000005.npy"), HasSubstr("state 4")));
}

TEST(TruthIo, WhatCannotBeKeptIsRefused) {
  const TemporaryFolder folder;
  const auto refused = [&](const auto& change) {
    SceneTruth truth = sample_truth();
    change(truth);
    EXPECT_THROW(write_truth(folder.path(), truth), std::invalid_argument);
    EXPECT_FALSE(fs::exists(folder.path() / "truth" / "scene.json"));
  };
  refused([](SceneTruth& t) { t.images.pop_back(); });
  refused([](SceneTruth& t) { std::swap(t.images[0].visibility[0], t.images[0].visibility[1]); });
  refused([](SceneTruth& t) { t.images[0].masks_full.pop_back(); });
  refused([](SceneTruth& t) { t.images[0].instance(0, 0) = 70000; });
  refused([](SceneTruth& t) { t.scene.instances[0].model = 5; });
  refused([](SceneTruth& t) { t.views[1].frame = t.views[0].frame; });
}

}  // namespace
}  // namespace cousin
