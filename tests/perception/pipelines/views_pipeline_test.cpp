#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <map>
#include <sstream>

#include "benchmarks/score/image_fidelity.h"
#include "perception/pipelines/views.h"
#include "perception/splats/splat_render.h"
#include "sim/dataset/atomic_file.h"
#include "sim/geometry/measure.h"
#include "sim/imaging/color.h"
#include "sim/process/scratch_folder.h"
#include "tests/perception/pipelines/cube_capture.h"
#include "tests/perception/splats/exposed_plane.h"

namespace cousin {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

ViewsPipelineConfig quick() {
  ViewsPipelineConfig config;
  config.steps = 300;
  config.most_splats = 1500;
  config.start_points = 600;
  config.mesh_cells = 40;
  return config;
}

Estimate run(const Capture& capture, const ViewsPipelineConfig& config) {
  return run_stages(reduced(capture, config.largest_side_px), views_stages(config, capture, 1),
                    views_stage_order());
}

bool same(const SplatModel& a, const SplatModel& b) {
  return a.splats.size() == b.splats.size() &&
         std::equal(a.splats.begin(), a.splats.end(), b.splats.begin(),
                    [](const Splat& s, const Splat& t) {
                      return s.centre_m == t.centre_m && s.log_scale == t.log_scale &&
                             s.rotation_wxyz == t.rotation_wxyz && s.sh_dc == t.sh_dc &&
                             s.sh_rest == t.sh_rest && s.opacity_logit == t.opacity_logit;
                    });
}

TEST(ViewsPipeline, GaussiansDepthCloudAndMeshOfPosedPhotographs) {
  const Capture capture = cube_capture();
  const Estimate estimate = run(capture, quick());
  EXPECT_GT(estimate.splats.splats.size(), 600U);
  ASSERT_EQ(estimate.depths.size(), 12U);
  EXPECT_EQ(estimate.depths[3].depth_m.width(), cube_camera().width_px);
  ASSERT_GT(estimate.cloud.size(), 300U);
  std::size_t near = 0;  // to the cube of 1 m, whose Gaussians reach a little over its faces
  for (const CloudPoint& point : estimate.cloud) {
    near += point.position_m.cwiseAbs().maxCoeff() < 0.7F ? 1 : 0;
    EXPECT_NEAR(point.normal.norm(), 1, 1e-3);
  }
  EXPECT_GT(static_cast<double>(near), 0.9 * static_cast<double>(estimate.cloud.size()));
  ASSERT_EQ(estimate.surfaces.size(), 1U);
  ASSERT_EQ(estimate.surfaces[0].status, SurfaceStatus::ok);
  const MassProperties body = mass_properties(estimate.surfaces[0].mesh);
  EXPECT_GT(body.volume_m3, 0.1);
  EXPECT_LT(body.volume_m3, 2);
  EXPECT_TRUE(estimate.corners.empty());
  EXPECT_TRUE(estimate.traits.empty());
}

TEST(ViewsPipeline, ViewsHeldOutChangeNoByteOfTheModel) {
  const Capture capture = cube_capture();
  ViewsPipelineConfig config = quick();
  config.steps = 60;
  config.hold_out_every = 4;
  Capture other = capture;
  for (std::size_t i = 0; i < other.frames.size(); ++i) {
    EXPECT_EQ(is_held_out(config, i), i % 4 == 0);
    if (is_held_out(config, i))
      other.frames[i].sensors[0].color = Image<Rgb8>(108, 75, {255, 0, 255});
  }
  EXPECT_TRUE(same(run(capture, config).splats, run(other, config).splats));
  other.frames[1].sensors[0].color = Image<Rgb8>(108, 75, {255, 0, 255});
  EXPECT_FALSE(same(run(capture, config).splats, run(other, config).splats));
  config.hold_out_every = 0;
  EXPECT_FALSE(is_held_out(config, 0));
}

TEST(ViewsPipeline, TheSameBytesOnAnyNumberOfThreads) {
  const Capture capture = cube_capture();
  ViewsPipelineConfig config = quick();
  config.steps = 60;
  const auto on = [&](int threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(threads));
    tbb::task_arena arena(threads);  // as many on a machine of fewer cores
    return arena.execute([&] { return run(capture, config); });
  };
  const Estimate one = on(1), four = on(4);
  EXPECT_TRUE(same(one.splats, four.splats));
  ASSERT_EQ(one.cloud.size(), four.cloud.size());
  for (std::size_t i = 0; i < one.cloud.size(); ++i) {
    EXPECT_EQ(one.cloud[i].position_m, four.cloud[i].position_m);
    EXPECT_EQ(one.cloud[i].normal, four.cloud[i].normal);
  }
  EXPECT_EQ(one.surfaces.at(0).mesh.triangles, four.surfaces.at(0).mesh.triangles);
  EXPECT_EQ(one.surfaces.at(0).mesh.vertices_m, four.surfaces.at(0).mesh.vertices_m);
}

TEST(ViewsPipeline, TheReferencesScheduleIsLeftEarly) {
  ViewsPipelineConfig config = quick();
  config.method = ViewsMethod::splats_paper;
  config.reference_steps = 50;
  config.cloud_views = config.mesh_cells = 0;
  const Estimate estimate = run(cube_capture(), config);
  EXPECT_FALSE(estimate.splats.splats.empty());
  EXPECT_EQ(estimate.splats.low_pass_px2, 0.3);
  EXPECT_TRUE(estimate.cloud.empty());
  EXPECT_TRUE(estimate.surfaces.empty());
}

TEST(ViewsPipeline, SmallerPhotographsKeepWhereRaysGo) {
  Capture capture = cube_capture();
  Image<Rgb8>& color = capture.frames[0].sensors[0].color;  // 108 x 75
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 3; ++x) color(x, y) = {static_cast<std::uint8_t>(10 * (3 * y + x)), 0, 7};
  }
  const Capture small = reduced(capture, 40);
  const SensorFrame& sensor = small.frames[0].sensors[0];
  EXPECT_EQ(sensor.color.width(), 36);
  EXPECT_EQ(sensor.color.height(), 25);
  EXPECT_EQ(sensor.reported.width_px, 36);
  EXPECT_EQ(small.rig[0].camera.height_px, 25);
  EXPECT_EQ(sensor.color(0, 0).r, 40);  // the mean of 0, 10, ..., 80
  EXPECT_EQ(sensor.color(0, 0).b, 7);
  const Eigen::Vector3d ray(0.1, -0.2, 1);
  const Eigen::Vector2d large = *Lens(cube_camera()).project(ray);
  const Eigen::Vector2d less = *Lens(sensor.reported).project(ray);
  EXPECT_NEAR(less.x(), (large.x() + 0.5) / 3 - 0.5, 1e-9);
  EXPECT_NEAR(less.y(), (large.y() + 0.5) / 3 - 0.5, 1e-9);
  EXPECT_EQ(reduced(capture, 0).frames[0].sensors[0].color.width(), 108);
  EXPECT_EQ(reduced(capture, 108).frames[0].sensors[0].color.width(), 108);
  const Estimate estimate = [&] {
    ViewsPipelineConfig config = quick();
    config.steps = 20;
    config.largest_side_px = 40;
    return run(cube_capture(), config);
  }();
  EXPECT_EQ(estimate.poses[0].camera.width_px, 36);
  EXPECT_EQ(estimate.depths[0].depth_m.width(), 36);
}

TEST(ViewsPipeline, WhatCannotBeDoneIsSaid) {
  Capture capture = cube_capture();
  ViewsPipelineConfig config = quick();
  config.poses = ViewsPoses::reported;
  for (std::size_t i = 1; i < capture.frames.size(); ++i) capture.frames[i].rig_from_world.reset();
  EXPECT_THAT([&] { run(capture, config); },
              ThrowsMessage<StageError>(HasSubstr("1 of 12 views have a pose")));
  Capture parallel = cube_capture();  // all look along one axis, from beside each other
  for (std::size_t i = 0; i < parallel.frames.size(); ++i) {
    const double x = 0.1 * static_cast<double>(i);
    parallel.frames[i].rig_from_world = look_at({x, 0, 1}, {x, 0, 0}, Eigen::Vector3d::UnitY());
  }
  EXPECT_THAT([&] { run(parallel, quick()); },
              ThrowsMessage<StageError>(HasSubstr("look at no common point")));
  EXPECT_THROW(run({}, quick()), std::invalid_argument);
  Capture blind = cube_capture();
  for (std::size_t i = 1; i < blind.frames.size(); ++i) blind.frames[i].sensors[0].color = {};
  EXPECT_THAT([&] { run(blind, quick()); },
              ThrowsMessage<StageError>(HasSubstr("of 1 with a colour photograph none is left")));
  config.mesh_cells = 391;
  EXPECT_THAT([&] { validate(config); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("mesh_cells")));
  EXPECT_THAT([&] { set_field(fields(config), "poses=guessed"); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("best, reported, sfm")));
}

TEST(ViewsPipeline, StructureFromMotionIsAsItIsAskedForAndNamesNoProgram) {
  ViewsPipelineConfig config;
  for (const char* one : {"sfm.focal=per_image", "sfm.colmap.lens=self", "sfm.colmap.threads=2"})
    set_field(fields(config), one);
  EXPECT_EQ(config.sfm.focal, SfmFocal::per_image);
  EXPECT_EQ(config.sfm.colmap.lens, ColmapLens::self);
  EXPECT_EQ(config.sfm.colmap.threads, 2);
  EXPECT_NO_THROW(validate(config));
  // A configuration may come from elsewhere.
  for (const char* one : {"sfm.colmap.program=mine", "sfm.colmap.folder=/tmp"})
    EXPECT_THROW(set_field(fields(config), one), std::invalid_argument) << one;
  config.sfm.focal_jitter = 2;
  EXPECT_THAT([&] { validate(config); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("sfm.focal_jitter")));
}

TEST(ViewsPipeline, TheUnitOfLengthDoesNotMatter) {
  const Capture capture = cube_capture();
  ViewsPipelineConfig config = quick();
  config.steps = 60;
  const Estimate metres = run(capture, config);
  Capture large = capture;  // the same in millimetres
  for (Frame& frame : large.frames) frame.rig_from_world->translation_m *= 1000;
  const Estimate millimetres = run(large, config);
  ASSERT_GT(metres.cloud.size(), 100U);
  EXPECT_NEAR(static_cast<double>(millimetres.cloud.size()),
              static_cast<double>(metres.cloud.size()),
              0.1 * static_cast<double>(metres.cloud.size()));
  EXPECT_NEAR(mass_properties(millimetres.surfaces.at(0).mesh).area_m2,
              1e6 * mass_properties(metres.surfaces.at(0).mesh).area_m2, 2e6);
  for (Frame& frame : large.frames) frame.rig_from_world->translation_m *= 1e5;
  const Estimate hundreds_of_nanometres = run(large, config);  // steps of millions of units
  EXPECT_EQ(hundreds_of_nanometres.surfaces.at(0).status, SurfaceStatus::ok);
}

Capture moved_by(Capture capture, const Eigen::Vector3d& shift_m) {
  for (Frame& frame : capture.frames) {
    Pose& pose = *frame.rig_from_world;
    pose.translation_m -= pose.rotation * shift_m;
  }
  return capture;
}

TEST(ViewsPipeline, AFarOriginIsRefusedBeforeTheTraining) {
  ViewsPipelineConfig config = quick();
  config.steps = 60;
  const Estimate near = run(moved_by(cube_capture(), {300, 0, 0}), config);
  EXPECT_GT(near.cloud.size(), 100U);
  EXPECT_EQ(near.surfaces.at(0).status, SurfaceStatus::ok);
  const Capture far = moved_by(cube_capture(), {0, 5e6, 0});
  const auto before = [](std::string_view stage, bool finished, const Estimate&) {
    EXPECT_FALSE(finished && stage == "splats");
  };
  EXPECT_THAT([&] { run_stages(far, views_stages(config, far, 1), views_stage_order(), before); },
              ThrowsMessage<StageError>(HasSubstr("from the origin of the poses")));
  config.cloud_views = config.mesh_cells = 0;
  EXPECT_FALSE(run(far, config).splats.splats.empty());
}

TEST(ViewsPipeline, GrowthIsAsItIsAskedFor) {
  ViewsPipelineConfig config = quick();
  config.cloud_views = config.mesh_cells = 0;
  config.steps = 100;
  config.most_splats = 700;
  std::map<std::string, std::size_t> count;
  for (const std::string growth : {"budgeted", "mcmc", "fixed"}) {
    set_field(fields(config), "growth=" + growth);
    count[growth] = run(cube_capture(), config).splats.splats.size();
  }
  EXPECT_EQ(count["fixed"], 600U);
  EXPECT_EQ(count["budgeted"], 700U);
  EXPECT_GT(count["mcmc"], 620U);  // by a twentieth each time
  EXPECT_LE(count["mcmc"], 700U);
}

TEST(ViewsPipeline, SomebodysPointsAreTheStart) {
  const ScratchFolder scratch("cousin-start");
  const std::filesystem::path file = scratch.path() / "points3D.txt";
  std::string text;
  for (const Splat& s : cube_of_splats().splats) {
    std::ostringstream line;
    line << "1 " << s.centre_m.x() << ' ' << s.centre_m.y() << ' ' << s.centre_m.z()
         << " 10 20 30 0.5\n";
    text += line.str();
  }
  write_file(file, text);
  ViewsPipelineConfig config = quick();
  config.start = file.string();
  config.steps = 1;
  config.growth = SplatGrowth::fixed;
  config.swept_points = 0;
  config.one_exposure = false;
  config.mesh_cells = config.cloud_views = 0;
  const Capture capture = cube_capture();
  EXPECT_EQ(run(capture, config).splats.splats.size(), cube_of_splats().splats.size());
  write_file(file, "# Points\n");
  EXPECT_THAT([&] { run(capture, config); },
              ThrowsMessage<std::runtime_error>(HasSubstr("holds no point")));
  config.start = (scratch.path() / "absent.ply").string();
  EXPECT_THAT([&] { run(capture, config); },
              ThrowsMessage<std::runtime_error>(HasSubstr("absent.ply")));
}

TEST(ViewsPipeline, AMeshNeedsNoCloud) {
  ViewsPipelineConfig config = quick();
  config.cloud_views = 0;
  const Estimate estimate = run(cube_capture(), config);
  EXPECT_TRUE(estimate.cloud.empty());
  ASSERT_EQ(estimate.surfaces.at(0).status, SurfaceStatus::ok);
  EXPECT_GT(mass_properties(estimate.surfaces[0].mesh).volume_m3, 0.1);
}

TEST(ViewsPipeline, StagesSayOneThingOfEachFrame) {
  const Capture capture = cube_capture();
  Stages stages = views_stages(quick(), capture, 1);
  stages.splats = [](const Capture&, const Estimate&) { return cube_of_splats(); };
  Stages no_depth = stages, no_poses = stages;
  no_depth.depths = [](const Capture&, const Estimate&) { return Depths(); };
  EXPECT_TRUE(run_stages(capture, no_depth, views_stage_order()).cloud.empty());
  no_poses.poses = [](const Capture&, const Estimate&) { return Poses(); };
  EXPECT_THROW(run_stages(capture, no_poses, views_stage_order()), StageError);
  // Depth of a frame whose place nobody knows is no length.
  Stages one_lost = stages;
  one_lost.poses = [&](const Capture& of, const Estimate& so_far) {
    Poses poses = stages.poses(of, so_far);
    poses[2] = {.frame = poses[2].frame, .status = PoseStatus::no_board};
    return poses;
  };
  one_lost.depths = [&](const Capture& of, const Estimate& so_far) {
    Estimate all = so_far;
    all.poses = reported_poses(of);
    return stages.depths(of, all);
  };
  EXPECT_GT(run_stages(capture, one_lost, views_stage_order()).cloud.size(), 300U);
}

TEST(ViewsPipeline, FewReportedPosesAreNotTheBest) {
  Capture capture = cube_capture();
  ViewsPipelineConfig config = quick();
  for (std::size_t i = 6; i < capture.frames.size(); ++i) capture.frames[i].rig_from_world.reset();
  config.steps = 5;
  config.cloud_views = config.mesh_cells = 0;
  EXPECT_FALSE(run(capture, config).splats.splats.empty());
  capture.frames[5].rig_from_world.reset();  // fewer than half: COLMAP's, of which these have none
  for (Frame& frame : capture.frames) frame.sensors[0].color = Image<Rgb8>(108, 75, {0, 0, 0});
  EXPECT_THAT([&] { run(capture, config); },
              ThrowsMessage<StageError>(HasSubstr("structure from motion")));
}

TEST(ViewsPipeline, PlacingSaysWhereThePosesAreFrom) {
  const Capture capture = cube_capture();
  const auto placing = std::make_shared<ViewsFindings>();
  placing->is_metric = false;
  const Stages stages = views_stages(quick(), capture, 1, {}, placing);
  EXPECT_EQ(stages.poses(capture, {}).size(), 12U);
  EXPECT_FALSE(placing->by_tracks);
  EXPECT_TRUE(placing->is_metric);
}

TEST(ViewsPipeline, BlackPhotographsGiveNoSurface) {
  Capture capture = cube_capture();
  for (Frame& frame : capture.frames) frame.sensors[0].color = Image<Rgb8>(108, 75, {0, 0, 0});
  const Estimate estimate = run(capture, quick());
  EXPECT_TRUE(estimate.cloud.empty());
  EXPECT_TRUE(estimate.surfaces.empty() || estimate.surfaces[0].status == SurfaceStatus::empty);
}

/// Photographs by automatic exposure, brighter and darker in turn.
Capture exposed_capture() {
  Capture capture;
  for (const SplatView& view : exposed_plane()) {
    if (capture.rig.empty()) capture.rig.push_back({.camera = view.full.camera});
    Frame frame{.id = 10 + 2 * view.frame, .rig_from_world = view.camera_from_world};  // no place
    frame.sensors.push_back(
        {.reported = view.full.camera, .color = rgb_of(view.full.color.channel)});
    capture.frames.push_back(std::move(frame));
  }
  return capture;
}

TEST(ViewsPipeline, ExposuresAreMeasuredAndTakenOut) {
  const Capture capture = exposed_capture();
  ViewsPipelineConfig config = quick();
  config.steps = 150;
  config.hold_out_every = 4;
  config.cloud_views = config.mesh_cells = 0;
  const auto findings = std::make_shared<ViewsFindings>();
  const auto trained = [&] {
    return run_stages(capture, views_stages(config, capture, 1, {}, findings), views_stage_order());
  };
  const Estimate even = trained();
  ASSERT_EQ(findings->exposures.status, ExposureStatus::ok);
  ASSERT_EQ(findings->exposed_frames, (std::vector<int>{1, 2, 3, 5, 6, 7}));
  for (std::size_t v = 1; v < 6; ++v) {
    const int frame = findings->exposed_frames[v], first = findings->exposed_frames[0];
    EXPECT_NEAR(findings->exposures.log_gain[v] - findings->exposures.log_gain[0],
                plane_log_gain(frame) - plane_log_gain(first), 0.02);
  }
  // The model has one exposure; each photograph's is put into its images, and of one held out that
  // of its neighbours.
  const std::vector<SplatView> views = splat_views(capture, even.poses);
  const auto light = [](const ColorPlanes& planes) {
    return linear_from_srgb(planes.channel[1](80, 60));
  };
  const auto drawn = [&](const SplatView& view) {
    return render_splats(even.splats, view.full.camera, view.camera_from_world).color;
  };
  const auto ratio = [&](std::size_t v) {  // of what is shown to the photograph
    return light(as_exposed(drawn(views[v]), views[v], *findings)) / light(views[v].full.color);
  };
  EXPECT_NEAR(light(drawn(views[1])) / 1.3 / light(views[1].full.color), 1, 0.15);
  EXPECT_NEAR(light(drawn(views[2])) * 1.3 / light(views[2].full.color), 1, 0.15);
  EXPECT_NEAR(ratio(1), 1, 0.15);
  EXPECT_NEAR(ratio(2), 1, 0.15);
  EXPECT_NEAR(ratio(4), 1 / (1.3 * 1.3), 0.1);
  config.one_exposure = false;
  trained();
  EXPECT_NE(findings->exposures.status, ExposureStatus::ok);
  EXPECT_TRUE(findings->exposed_frames.empty());
}

TEST(ViewsPipeline, BetweenPhotographsExposureChangesEvenly) {
  ViewsFindings findings;
  findings.exposures.status = ExposureStatus::ok;
  findings.exposed_frames = {1, 3, 5, 6};
  findings.exposures.log_gain = {0, std::log(2.0), kNaN, std::log(4.0)};
  SplatView photograph;
  photograph.full.camera = {LensModel::pinhole, 1, 1, 20, 20, 0, 0};
  const auto light_at = [&](int frame) {
    ColorPlanes image;
    for (Image<float>& channel : image.channel)
      channel = Image<float>(1, 1, srgb_from_linear(0.1F));
    photograph.frame = frame;
    return linear_from_srgb(as_exposed(image, photograph, findings).channel[0](0, 0));
  };
  EXPECT_NEAR(light_at(3), 0.2, 1e-5);  // its own
  EXPECT_NEAR(light_at(2), 0.1 * std::sqrt(2.0), 1e-5);
  EXPECT_NEAR(light_at(4), 0.2 * std::cbrt(2.0), 1e-5);  // the first of three steps from 2 to 4
  EXPECT_NEAR(light_at(5), 0.1, 1e-5);                   // it was trained on as it is
  EXPECT_NEAR(light_at(0), 0.1, 1e-5);
  EXPECT_NEAR(light_at(9), 0.4, 1e-5);
  findings.exposures.log_gain.assign(4, kNaN);
  EXPECT_NEAR(light_at(3), 0.1, 1e-5);
}

}  // namespace
}  // namespace cousin
