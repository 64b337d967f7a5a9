#include "sim/dataset/capture_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/imaging/image_io.h"
#include "tests/sim/dataset/sample_capture.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

void expect_equal(const Capture& a, const Capture& b) {
  EXPECT_EQ(a.pipeline, b.pipeline);
  EXPECT_EQ(a.board, b.board);
  EXPECT_EQ(a.warnings, b.warnings);
  ASSERT_EQ(a.rig.size(), b.rig.size());
  for (std::size_t s = 0; s < a.rig.size(); ++s) {
    EXPECT_EQ(a.rig[s].name, b.rig[s].name);
    EXPECT_EQ(a.rig[s].camera, b.rig[s].camera);
    EXPECT_TRUE(same_pose(a.rig[s].sensor_from_rig, b.rig[s].sensor_from_rig));
    EXPECT_EQ(a.rig[s].exposure_s, b.rig[s].exposure_s);
    EXPECT_EQ(a.rig[s].shutter, b.rig[s].shutter);
    EXPECT_EQ(a.rig[s].readout_s, b.rig[s].readout_s);
    EXPECT_EQ(a.rig[s].linear_raw, b.rig[s].linear_raw);
  }
  ASSERT_EQ(a.frames.size(), b.frames.size());
  for (std::size_t i = 0; i < a.frames.size(); ++i) {
    const Frame& f = a.frames[i];
    const Frame& g = b.frames[i];
    EXPECT_EQ(f.id, g.id);
    EXPECT_EQ(f.time_s, g.time_s);
    ASSERT_EQ(f.rig_from_world.has_value(), g.rig_from_world.has_value());
    if (f.rig_from_world) {
      EXPECT_TRUE(same_pose(*f.rig_from_world, *g.rig_from_world));
    }
    ASSERT_EQ(f.sensors.size(), g.sensors.size());
    for (std::size_t s = 0; s < f.sensors.size(); ++s) {
      EXPECT_EQ(f.sensors[s].reported, g.sensors[s].reported);
      EXPECT_EQ(f.sensors[s].color, g.sensors[s].color);
      EXPECT_EQ(f.sensors[s].grey, g.sensors[s].grey);
      EXPECT_EQ(f.sensors[s].time_s, g.sensors[s].time_s);
      EXPECT_EQ(f.sensors[s].raw, g.sensors[s].raw);
      EXPECT_EQ(f.sensors[s].depth, g.sensors[s].depth);
      EXPECT_EQ(f.sensors[s].depth_unit_m, g.sensors[s].depth_unit_m);
    }
  }
}

TEST(CaptureIo, EveryBitComesBack) {
  const TemporaryFolder folder;
  const Capture capture = sample_capture();
  write_capture(folder.path(), capture);
  expect_equal(read_capture(folder.path()), capture);
}

TEST(CaptureIo, ABoardMayBeAnyTargetAsDesigned) {
  const TemporaryFolder folder;
  Capture capture = sample_capture();
  capture.board = "charuco columns=11 rows=8 pitch_m=0.022 mark_share=0.73 dictionary=DICT_4X4_50";
  write_capture(folder.path(), capture);
  EXPECT_EQ(read_capture(folder.path()).board, capture.board);
}

TEST(CaptureIo, ADepthCamerasSensorsHaveTheirFoldersAndComeBack) {
  const TemporaryFolder folder;
  const Capture capture = depth_camera_capture();
  write_capture(folder.path(), capture);
  expect_equal(read_capture(folder.path()), capture);
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder.path()))
    names.insert(entry.path().filename().string());
  EXPECT_EQ(names, (std::set<std::string>{"rig.json", "scene_camera.json", "rgb", "ir_left",
                                          "ir_right", "depth"}));
  EXPECT_EQ(frame_image_files(capture, 1),
            (std::vector<fs::path>{"rgb/000001.png", "ir_left/000001.png", "ir_right/000001.png",
                                   "depth/000001.png"}));
  // BOP's key is of what lies in depth/: 0.1 mm.
  EXPECT_THAT(read_file(folder.path() / "scene_camera.json"), HasSubstr("\"depth_scale\": 0.1"));
}

TEST(CaptureIo, ASensorOfDepthAloneTakesDepthFromTheFirst) {
  const TemporaryFolder folder;
  Capture capture = depth_camera_capture();
  for (Frame& frame : capture.frames)
    frame.sensors[0].depth = Image<std::uint16_t>(24, 18, 77);  // registered to colour
  write_capture(folder.path(), capture);
  expect_equal(read_capture(folder.path()), capture);
  EXPECT_TRUE(fs::exists(folder.path() / "rgb_depth/000000.png"));
  capture.frames[0].sensors[1].color = Image<Rgb8>(20, 10);
  EXPECT_THROW(write_frame_images(folder.path(), capture, 0), std::invalid_argument);
  capture = depth_camera_capture();
  capture.frames[0].sensors[3].grey = Image<std::uint8_t>(20, 10);
  EXPECT_THROW(write_frame_images(folder.path(), capture, 0), std::invalid_argument);
}

TEST(CaptureIo, TheBytesDoNotDependOnTheThreads) {
  const TemporaryFolder one, seven;
  for (const auto& [folder, threads] : {std::pair{&one, 1}, std::pair{&seven, 7}}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(threads));
    write_capture(folder->path(), sample_capture());
  }
  for (const auto& entry : fs::recursive_directory_iterator(one.path())) {
    if (!entry.is_regular_file()) continue;
    EXPECT_EQ(read_file(entry.path()),
              read_file(seven.path() / entry.path().lexically_relative(one.path())));
  }
}

TEST(CaptureIo, ShardsWriteTheSameFilesAsOneRun) {
  const TemporaryFolder whole, shards;
  const Capture capture = sample_capture();
  write_capture(whole.path(), capture);
  for (std::size_t i = 3; i-- > 0;) write_frame_images(shards.path(), capture, i);
  Capture without_images = capture;  // the completing shard holds none of the others' images
  for (Frame& frame : without_images.frames) {
    for (SensorFrame& sensor : frame.sensors) {
      sensor.color = {};
      sensor.raw = {};
      sensor.depth = {};
    }
  }
  write_capture_index(shards.path(), without_images);
  EXPECT_EQ(read_file(shards.path() / "scene_camera.json"),
            read_file(whole.path() / "scene_camera.json"));
  expect_equal(read_capture(shards.path()), capture);
}

TEST(CaptureIo, TruthIsNeverLookedAt) {
  const TemporaryFolder folder;
  write_capture(folder.path(), sample_capture());
  write_file(folder.path() / "truth" / "camera.json", "not even JSON");
  expect_equal(read_capture(folder.path()), sample_capture());
  fs::remove_all(folder.path() / "truth");
  expect_equal(read_capture(folder.path()), sample_capture());
}

TEST(CaptureIo, FoldersAreNamedAsInTheDesign) {
  const TemporaryFolder folder;
  write_capture(folder.path(), sample_capture());
  for (const char* file :
       {"rgb/000000.png", "raw/000020.png", "ir_left/000010.png", "ir_left_depth/000000.png"}) {
    EXPECT_TRUE(fs::exists(folder.path() / file)) << file;
  }
}

TEST(CaptureIo, PlainBopFilesAreRead) {
  const TemporaryFolder folder;
  Capture capture = sample_capture();
  capture.rig.resize(1);
  capture.rig[0].sensor_from_rig = {};
  for (Frame& frame : capture.frames) {
    frame.sensors.resize(1);
    frame.sensors[0].raw = {};
  }
  write_capture(folder.path(), capture);
  write_file(folder.path() / "scene_camera.json",
             R"({"0": {"cam_K": [60, 0, 11, 0, 61, 8, 0, 0, 1], "depth_scale": 0.1,
                       "cam_R_w2c": [0, 1, 0, -1, 0, 0, 0, 0, 1], "cam_t_w2c": [10, 20, 500]},
                 "10": {"cam_K": [60, 0, 11, 0, 61, 8, 0, 0, 1]}})");
  const Capture read = read_capture(folder.path());
  ASSERT_EQ(read.frames.size(), 2U);
  const SensorFrame& sensor = read.frames[0].sensors[0];
  EXPECT_EQ(sensor.reported.fy_px, 61);
  EXPECT_EQ(sensor.reported.distortion, capture.rig[0].camera.distortion);
  EXPECT_DOUBLE_EQ(sensor.depth_unit_m, 1e-4);
  EXPECT_EQ(sensor.color, capture.frames[0].sensors[0].color);
  EXPECT_TRUE(read.frames[0].rig_from_world->translation_m.isApprox(
      Eigen::Vector3d(0.01, 0.02, 0.5), 1e-12));
  EXPECT_FALSE(read.frames[1].rig_from_world.has_value());
}

TEST(CaptureIo, ABadImageNamesFileAndFrame) {
  const TemporaryFolder folder;
  write_capture(folder.path(), sample_capture());
  const fs::path png = folder.path() / "rgb" / "000010.png";
  const std::string good = read_file(png);
  const auto error = [&] { return error_of([&] { read_capture(folder.path()); }); };

  write_png(png, Image<Rgb8>(25, 18));
  EXPECT_THAT(error(), AllOf(HasSubstr("rgb/000010.png"), HasSubstr("frame 10"),
                             HasSubstr("25 x 18"), HasSubstr("24 x 18")));
  write_file(png, good.substr(0, good.size() / 2));
  EXPECT_THAT(error(), AllOf(HasSubstr("rgb/000010.png"), HasSubstr("frame 10")));
  write_file(png, "");
  EXPECT_THAT(error(), AllOf(HasSubstr("rgb/000010.png"), HasSubstr("frame 10")));
  fs::remove(png);
  EXPECT_THAT(error(),
              AllOf(HasSubstr("rgb/000010.png"), HasSubstr("frame 10"), HasSubstr("missing")));
  fs::create_symlink("/etc/passwd", png);
  EXPECT_THAT(error(), AllOf(HasSubstr("rgb/000010.png"), HasSubstr("symbolic link")));
}

TEST(CaptureIo, TheErrorIsThatOfTheFirstBadFrame) {
  const TemporaryFolder folder;
  write_capture(folder.path(), sample_capture());
  fs::remove(folder.path() / "rgb/000020.png");
  fs::remove(folder.path() / "rgb/000010.png");
  for (int i = 0; i < 5; ++i)
    EXPECT_THAT(error_of([&] { read_capture(folder.path()); }), HasSubstr("frame 10"));
}

TEST(CaptureIo, MissingIndexesAreNamed) {
  const TemporaryFolder folder;
  EXPECT_THAT(error_of([&] { read_capture(folder.path()); }), HasSubstr("rig.json: cannot read"));
  write_capture(folder.path(), sample_capture());
  fs::remove(folder.path() / "scene_camera.json");
  EXPECT_THAT(error_of([&] { read_capture(folder.path()); }),
              HasSubstr("scene_camera.json: cannot read"));
}

TEST(CaptureIo, WhatCannotBeWrittenIsRefused) {
  const TemporaryFolder folder;
  const auto refused = [&](const auto& change) {
    Capture capture = sample_capture();
    change(capture);
    EXPECT_THROW(write_capture(folder.path(), capture), std::invalid_argument);
    EXPECT_FALSE(fs::exists(folder.path() / "rig.json"));
  };
  refused([](Capture& c) { c.rig[1].name = "rgb"; });
  refused([](Capture& c) { c.rig[0].name = "../up"; });
  refused([](Capture& c) { c.rig[0].name = "truth"; });
  refused([](Capture& c) { c.frames[1].id = c.frames[0].id; });
  refused([](Capture& c) { c.frames[1].id = 1'000'000; });
  refused([](Capture& c) { c.frames[1].sensors.pop_back(); });
  refused([](Capture& c) { c.rig.clear(); });
}

TEST(CaptureIo, SceneFoldersAreSixDigits) {
  const TemporaryFolder folder;
  for (const char* name : {"000002", "000000", "12", "estimates", "0000001"})
    fs::create_directories(folder.path() / name);
  write_file(folder.path() / "000009", "a file");
  EXPECT_THAT(scene_folders(folder.path()),
              testing::ElementsAre(folder.path() / "000000", folder.path() / "000002"));
  EXPECT_THAT(error_of([&] { scene_folders(folder.path() / "absent"); }),
              HasSubstr("not a folder"));
}

}  // namespace
}  // namespace cousin
