// The loop as a whole, on a small scene: few seeds, few views, small images.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "benchmarks/loop/attribution.h"
#include "benchmarks/loop/perceive.h"
#include "benchmarks/loop/plan.h"
#include "benchmarks/loop/score_seeds.h"
#include "benchmarks/loop/seeds_run.h"
#include "benchmarks/loop/simulate.h"
#include "benchmarks/loop/truth_stages.h"
#include "benchmarks/suites/seeds/suite.h"
#include "benchmarks/suites/seeds/trained_models.h"
#include "perception/splats/splat_ply.h"
#include "sim/dataset/capture_io.h"
#include "sim/dataset/seam_io.h"
#include "sim/dataset/truth_io.h"
#include "sim/types/rng.h"
#include "tests/perception/sfm/stand_in_colmap.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

const std::vector<std::string>& small_scene() {
  static const std::vector<std::string> sets = {"seeds=2",
                                                "views=9",
                                                "rig.width_px=640",
                                                "rig.height_px=360",
                                                "ring_distances_m=[0.30, 0.30, 0.30]",
                                                "render.irradiance_samples=16",
                                                "render.edge_samples=16",
                                                "pipeline.surface.subdivisions=3",
                                                "pipeline.surface.samples=8"};
  return sets;
}

/// The least views and pixels that measure both seeds.
SeedsPipelineConfig small_pipeline() {
  const RunConfig config = seeds_run_config(small_scene());
  return seeds_pipeline(config);
}

RunConfig measured_scene(const std::vector<std::string>& more = {}) {
  std::vector<std::string> sets = small_scene();
  sets.insert(sets.end(), {"views=18", "rig.width_px=960", "rig.height_px=540"});
  sets.insert(sets.end(), more.begin(), more.end());
  return seeds_run_config(sets);
}

SimulatedRun simulate(std::size_t threads, const TruthNeeds& needs = {}) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  return simulate(seeds_run_config(small_scene()), 3, 0, needs);
}

fs::path fresh_folder(const std::string& name) {
  const fs::path folder = fs::path(testing::TempDir()) / ("closed_loop_" + name);
  fs::remove_all(folder);
  return folder;
}

std::string bytes_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

/// Every file below a folder but timings, as path -> bytes.
std::map<std::string, std::string> contents(const fs::path& folder) {
  std::map<std::string, std::string> result;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file() || entry.path().filename() == "timings.json") continue;
    result[fs::relative(entry.path(), folder).string()] = bytes_of(entry.path());
  }
  return result;
}

void perceive_into(const Capture& capture, const fs::path& folder, std::size_t threads) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  perceive(capture, small_pipeline(), 3, {}, 0, folder);
}

TEST(ClosedLoop, ImagesAndEstimatesAreTheSameOnOneTwoAndSevenThreads) {
  const SimulatedRun one = simulate(1);
  perceive_into(one.capture, fresh_folder("t1"), 1);
  const auto expected = contents(fs::path(testing::TempDir()) / "closed_loop_t1");
  EXPECT_GT(expected.size(), 5U);
  for (const std::size_t threads : {2, 7}) {
    const SimulatedRun run = simulate(threads);
    for (std::size_t i = 0; i < one.capture.frames.size(); ++i) {
      EXPECT_EQ(run.capture.frames[i].sensors[0].color, one.capture.frames[i].sensors[0].color)
          << "frame " << i;
    }
    const fs::path folder = fresh_folder("t" + std::to_string(threads));
    perceive_into(run.capture, folder, threads);
    EXPECT_EQ(contents(folder), expected) << threads << " threads";
  }
}

TEST(ClosedLoop, ThroughFilesAndWithoutTruthGivesTheBytesOfMemory) {
  const SimulatedRun run = simulate(2);
  const fs::path dataset = fresh_folder("data");
  write_capture(dataset / "000000", run.capture);
  write_truth(dataset / "000000", run.truth);
  perceive_into(run.capture, fresh_folder("memory"), 2);
  perceive_into(read_capture(dataset / "000000"), fresh_folder("files"), 2);
  fs::remove_all(dataset / "000000" / "truth");
  perceive_into(read_capture(dataset / "000000"), fresh_folder("no_truth"), 2);
  const auto memory = contents(fs::path(testing::TempDir()) / "closed_loop_memory");
  EXPECT_EQ(contents(fs::path(testing::TempDir()) / "closed_loop_files"), memory);
  EXPECT_EQ(contents(fs::path(testing::TempDir()) / "closed_loop_no_truth"), memory);
}

TEST(ClosedLoop, AFrameDoesNotDependOnWhichFramesCameBefore) {
  const RunConfig config = seeds_run_config(small_scene());
  const Simulation simulation(config, 3, 0);
  const Frame late = simulation.take(7, {.color = true}).frame;
  const SimulatedRun run = simulate(2);
  EXPECT_EQ(late.sensors[0].color, run.capture.frames[7].sensors[0].color);
  EXPECT_EQ(simulation.rig().reported(7).sensors[0].reported,
            run.capture.frames[7].sensors[0].reported);
}

TEST(ClosedLoop, TruthInEverySeamScoresPerfectly) {
  const SimulatedRun run = simulate(2, truth_stage_needs());
  const SeedsPipelineConfig pipeline = small_pipeline();
  const Stages truth = truth_stages(run, board_of(run.capture, pipeline));
  const Estimate estimate = run_seeds(run.capture, pipeline, truth);
  const SeedsScores scores = score_run(run.truth, estimate, {});
  ASSERT_EQ(scores.specimens.size(), 10U);
  for (const SpecimenRow& row : scores.specimens) EXPECT_EQ(row.measured, row.truth) << row.trait;
  for (const ScoreRow& row : scores.rows) {
    if (row.metric == "views.posed") {
      EXPECT_EQ(row.value, 1);
    }
    if (row.metric == "camera.centre_rms") {
      EXPECT_LT(row.value, 1e-12);
    }
    if (row.metric == "cloud.accuracy_rms") {
      EXPECT_LT(row.value, 1e-8);  // float points 0.1 m from the origin
    }
  }
}

/// Largest error of a length, m; every specimen must have been measured.
double worst_length_m(const SeedsScores& scores) {
  double worst = 0;
  for (const SpecimenRow& row : scores.specimens) {
    EXPECT_EQ(row.status, ScoreStatus::ok) << row.instance << " " << row.trait;
    if (row.trait == "length") worst = std::max(worst, std::abs(row.measured - row.truth));
  }
  return worst;
}

TEST(ClosedLoop, RenderedSeedsAreFoundAndMeasured) {
  const RunConfig config = measured_scene();
  const SimulatedRun run = simulate(config, 3, 0, {});
  SeedsPipelineConfig pipeline = seeds_pipeline(config);
  const Estimate measured = perceive(run.capture, pipeline, 3, {}, 0, {});
  const SeedsScores ours = score_run(run.truth, measured, {});
  ASSERT_EQ(ours.specimens.size(), 10U);
  EXPECT_LT(worst_length_m(ours), 3e-4);  // a pixel spans 0.37 mm
  for (const ScoreRow& row : ours.rows) {
    if (row.metric == "camera.centre_rms") {
      EXPECT_LT(row.value, 2e-3);
    }
  }
  pipeline.method = SeedsMethod::paper;
  Stages known = seeds_stages(pipeline, 3);
  known.corners = nullptr;
  known.poses = [&](const Capture&, const Estimate&) { return measured.poses; };
  known.depths = [&](const Capture&, const Estimate&) { return measured.depths; };
  const SeedsScores paper =
      score_run(run.truth, run_seeds(run.capture, pipeline, known), {.method = "paper"});
  EXPECT_LT(worst_length_m(paper), 3e-3);
  pipeline.method = SeedsMethod::splats;
  pipeline.splats.steps = 500;
  pipeline.splats.most_splats = 12000;
  const SeedsScores splats =
      score_run(run.truth, perceive(run.capture, pipeline, 3, {}, 0, {}), {.method = "splats"});
  ASSERT_EQ(splats.specimens.size(), 10U);
  EXPECT_LT(worst_length_m(splats), 2e-3);
}

// The same steps, starting places and photographs: only their rates differ.
TEST(ClosedLoop, GaussiansForImagesShowPhotographsBetterThanThoseForSurfaces) {
  const RunConfig config = seeds_run_config(
      {"seeds=2", "views=9", "rig.width_px=640", "rig.height_px=360",
       "ring_distances_m=[0.30, 0.30, 0.30]", "render.irradiance_samples=16",
       "render.edge_samples=16", "pipeline.splats.steps=200", "pipeline.splats.most_splats=50000"});
  const SimulatedRun run = simulate(config, 3, 0, {});
  const SeedsTrainingTask task = {.run = &run, .pipeline = seeds_pipeline(config), .stage_seed = 3};
  const auto psnr_db = [](const std::vector<ScoreRow>& rows, const std::string& method) {
    double value = kNaN;
    for (const ScoreRow& row : rows)
      if (row.metric == "train.psnr" && row.method == method) value = row.value;
    return value;
  };
  const double images_db = psnr_db(measure_for_images(task, 200), "splats_images");
  EXPECT_GT(images_db,
            psnr_db(measure_by_splats(task, SeedsMethod::splats).file.scores, "splats") + 1);
}

TEST(ClosedLoop, APlainBoardsFrameIsTurnedToTheTruths) {
  std::vector<std::string> sets = small_scene();
  sets.insert(sets.end(), {"markers=false", "views=3"});
  const RunConfig config = seeds_run_config(sets);
  const SimulatedRun run = simulate(config, 3, 0, truth_stage_needs());
  const Estimate exact =
      run_seeds(run.capture, seeds_pipeline(config),
                truth_stages(run, board_of(run.capture, seeds_pipeline(config))));
  for (int count = 0; count < 4; ++count) {
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.5 * M_PI * count, Eigen::Vector3d::UnitZ()));
    for (const bool with_poses : {true, false}) {
      Estimate turned = exact;
      for (FramePose& pose : turned.poses) {
        pose.camera_from_world = pose.camera_from_world * inverse(Pose{turn, {0, 0, 0}});
      }
      for (Surface& surface : turned.surfaces) {
        for (Eigen::Vector3d& p : surface.mesh.vertices_m) p = turn * p;
      }
      for (SpecimenTraits& s : turned.traits) s.centroid_in_world_m = turn * s.centroid_in_world_m;
      if (!with_poses) turned.poses.clear();
      const SeedsScores scores = score_run(run.truth, turned, {});
      EXPECT_LT(worst_length_m(scores), 1e-12) << count;
      for (const ScoreRow& row : scores.rows) {
        if (row.metric == "camera.centre_rms" || row.metric == "mesh.accuracy_rms") {
          EXPECT_LT(row.value, 1e-9) << row.metric << " " << count;
        }
      }
    }
  }
}

TEST(ClosedLoop, AttributionExplainsTheStagesThatRan) {
  const SimulatedRun run = simulate(2, truth_stage_needs());
  const SeedsPipelineConfig pipeline = small_pipeline();
  // A user's masks that see nothing: only the truth in their place (and later) measures a seed.
  Stages own = stages_of(pipeline, run.capture, 3, {}, 0);
  own.silhouettes = [](const Capture&, const Estimate&) { return Silhouettes{}; };
  const Estimate estimate = run_seeds(run.capture, pipeline, own);
  const std::vector<SeamStep> steps = attribute(run, pipeline, own, {}, &estimate);
  ASSERT_EQ(steps.size(), 9U);
  for (const SeamStep& step : steps) {
    const bool after = step.stage == "masks" || step.stage == "surfaces" || step.stage == "traits";
    for (const SpecimenRow& row : step.scores.specimens) {
      EXPECT_EQ(row.status == ScoreStatus::ok, after) << step.stage;
    }
  }
  EXPECT_EQ(worst_length_m(steps.back().scores), 0);
}

/// How far found corners lie off the true ones, root mean square an axis, px; of at least `least`.
double corners_off_px(const SimulatedRun& run, const SeedsPipelineConfig& pipeline, int least) {
  const SeedBoard board = board_of(run.capture, pipeline);
  const Corners truth = truth_stages(run, board).corners(run.capture, {});
  const Corners found = detect_board(run.capture, board, pipeline.board);
  int compared = 0;
  double squares = 0;
  for (std::size_t f = 0; f < truth.size(); ++f) {
    for (const CornerObservation& seen : found[f].corners) {
      for (const CornerObservation& exact : truth[f].corners) {
        if (seen.column != exact.column || seen.row != exact.row) continue;
        squares += (seen.pixel_px - exact.pixel_px).squaredNorm();
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, least);
  return std::sqrt(squares / (2 * compared));
}

// Noise at this size moves a corner by about 0.05 px an axis; a wrong pixel convention would show
// as 0.5.
constexpr double kMostOff_px = 0.12;

TEST(ClosedLoop, TrueCornersAgreeWithWhatIsFoundInTheImages) {
  EXPECT_LT(corners_off_px(simulate(2, truth_stage_needs()), small_pipeline(), 300), kMostOff_px);
}

// Taken for flat and of its nominal size, corners at the edge would be 3 px off.
TEST(ClosedLoop, TrueCornersOfAShrunkAndBentPrintAreThePrints) {
  std::vector<std::string> sets = small_scene();
  sets.insert(sets.end(), {"views=3", "print_scale=0.97", "sheet_sag_m=0.001"});
  const SimulatedRun run = simulate(seeds_run_config(sets), 3, 0, truth_stage_needs());
  EXPECT_LT(corners_off_px(run, small_pipeline(), 100), kMostOff_px);
}

TEST(ClosedLoop, GaussiansThatAreNoneAreLeftOutAloud) {
  const fs::path folder = fresh_folder("foreign_splats");
  fs::create_directories(folder);
  std::ofstream(folder / "splats.ply")
      << "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
         "property float z\nproperty float f_dc_0\nproperty float f_dc_1\n"
         "property float f_dc_2\nproperty float opacity\nproperty float scale_0\n"
         "property float scale_1\nproperty float scale_2\nproperty float rot_0\n"
         "property float rot_1\nproperty float rot_2\nproperty float rot_3\nend_header\n"
         "0 0 0  0 0 0  1  -5 -5 -5  1 0 0 0\n"
         "nan 0 0  0 0 0  1  -5 -5 -5  1 0 0 0\n"
         "0 0 0  0 0 0  1  -5 -5 -5  0 0 0 0\n";
  std::vector<std::string> warnings;
  const Stages stages = with_stage_sources(
      {}, {parse_stage_source("splats=dir:" + folder.string())}, seeds_stage_order(), 0,
      [&](const std::string& text) { warnings.push_back(text); });
  EXPECT_EQ(stages.splats({}, {}).splats.size(), 1U);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_THAT(warnings[0],
              AllOf(HasSubstr("splats.ply: 2 of 3 rows are left out"), HasSubstr("1 with NaN"),
                    HasSubstr("1 with a rotation of length zero")));
}

TEST(ClosedLoop, SeedsOfFilesAndPrograms) {
  const SimulatedRun run = simulate(2, truth_stage_needs());
  const SeedsPipelineConfig pipeline = small_pipeline();
  const Stages truth = truth_stages(run, board_of(run.capture, pipeline));
  const Estimate perfect = run_seeds(run.capture, pipeline, truth);
  const fs::path folder = fresh_folder("seam") / "000000";
  write_traits(folder, perfect.traits);

  // dir: the seam's file in place of the stage.
  const auto from_files =
      with_stage_sources(truth, {parse_stage_source("traits=dir:" + folder.parent_path().string())},
                         seeds_stage_order(), 0);
  EXPECT_EQ(from_files.traits(run.capture, perfect).size(), perfect.traits.size());

  // exec: a program that copies a prepared file; it must see the capture and earlier seams, and no
  // truth.
  const fs::path program = folder / "mine.sh";
  std::ofstream(program) << "#!/bin/sh\n[ -f \"$1/rig.json\" ] && [ -f \"$1/poses.json\" ] && [ ! "
                            "-e \"$1/truth\" ] && cp "
                         << (folder / "traits.json").string() << " \"$2\"/\n";
  fs::permissions(program, fs::perms::owner_all);
  const auto from_program = with_stage_sources(
      truth, {parse_stage_source("traits=exec:" + program.string())}, seeds_stage_order(), 0);
  EXPECT_EQ(from_program.traits(run.capture, perfect).size(), perfect.traits.size());

  std::ofstream(program) << "#!/bin/sh\nexit 3\n";
  try {
    run_seeds(run.capture, pipeline, from_program);
    FAIL() << "a failing program was not reported";
  } catch (const StageError& error) {
    EXPECT_EQ(error.stage, "traits");
    EXPECT_NE(std::string(error.what()).find("exited with 3"), std::string::npos) << error.what();
  }
}

TEST(ClosedLoop, ANoiseJobPhotographsTwiceAndMeasuresNothingElse) {
  SeedsSuiteConfig config;
  config.quick = true;
  config.sets = {"seeds=1",
                 "views=2",
                 "rig.width_px=160",
                 "rig.height_px=90",
                 "render.irradiance_samples=16",
                 "render.edge_samples=4"};
  int found = 0;
  for (const ShardJob& job : seeds_suite_jobs(config)) {
    if (job.name != "quick_noise_zhengdan958.json") continue;
    const ScoreFile file = scores_from_json(job.run(), job.name);
    ASSERT_EQ(file.scores.size(), 3U);
    // All but a part of the photograph is green: black in both, it has no error.
    EXPECT_GT(file.scores[2].value, file.scores[1].value);
    EXPECT_EQ(file.scores[0].metric, "noise_floor.psnr");
    EXPECT_EQ(file.scores[0].n, 2);
    EXPECT_GT(file.scores[0].value, 25);  // it is noise, and another one
    EXPECT_LT(file.scores[0].value, 60);
    ++found;
  }
  EXPECT_EQ(found, 1);
}

/// Where programs are looked for, while it lives.
class ProgramPath {
 public:
  explicit ProgramPath(const std::string& path) {
    if (const char* now = std::getenv("PATH")) before_ = now;
    setenv("PATH", path.c_str(), 1);
  }
  ~ProgramPath() { setenv("PATH", before_.c_str(), 1); }
  ProgramPath(const ProgramPath&) = delete;
  ProgramPath& operator=(const ProgramPath&) = delete;

 private:
  std::string before_;
};

/// What COLMAP could find of a run: true poses, and points over the board.
PlantViews true_model(const SimulatedRun& run, std::uint64_t seed) {
  PlantViews views;
  views.lens = run.truth.views.front().camera;
  const Lens lens(views.lens);
  Rng rng(seed);
  std::vector<SfmPoint> points(60);
  for (SfmPoint& point : points)
    point.in_world_m = {uniform(rng, -0.04, 0.04), uniform(rng, -0.04, 0.04), 0.003};
  for (std::size_t i = 0; i < run.truth.views.size(); ++i) {
    const int image = static_cast<int>(i);
    views.model.images.push_back(image);
    views.model.lenses.push_back(views.lens);
    views.model.camera_from_world.push_back(run.truth.views[i].camera_from_world);
    for (SfmPoint& point : points) {
      if (const auto pixel = lens.project(views.model.camera_from_world.back() * point.in_world_m))
        point.sightings.push_back({image, *pixel});
    }
  }
  views.model.points = points;
  return views;
}

TEST(ClosedLoop, AStoppedTrainingGoesOnWithThePosesThatColmapFoundForIt) {
  const SimulatedRun run = simulate(2);
  const fs::path folder = fresh_folder("stopped_colmap");
  StandInColmap program(folder / "p");
  program.add_model(0, true_model(run, 1));
  const ProgramPath path((folder / "p").string() + ":" + std::getenv("PATH"));
  SeedsPipelineConfig pipeline = small_pipeline();
  pipeline.method = SeedsMethod::splats;
  pipeline.splats.poses = SplatPoses::sfm;
  pipeline.splats.steps = 550;
  pipeline.splats.most_splats = pipeline.splats.start_points = 3000;
  const Estimate whole = perceive(run.capture, pipeline, 3, {}, 0, {});
  // A checkpoint is written after 500 steps.
  const Progress stop = [](const std::string& what, int done, int) {
    if (what.find("splats, step") != std::string::npos && done >= 520)
      throw std::runtime_error("stopped");
  };
  const fs::path out = folder / "out";
  EXPECT_THROW((void)perceive(run.capture, pipeline, 3, {}, 0, out, stop), StageError);
  EXPECT_TRUE(fs::exists(out / "splats.unfinished.colmap"));
  const Poses first = read_poses(out);
  ASSERT_EQ(first.size(), run.truth.views.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    const Eigen::Vector3d off_m = inverse(first[i].camera_from_world).translation_m -
                                  inverse(run.truth.views[i].camera_from_world).translation_m;
    EXPECT_LT(off_m.norm(), 2e-3) << i;
  }

  program.add_model(0, {});  // COLMAP would find nothing now
  int least = pipeline.splats.steps;
  const Progress watch = [&least](const std::string& what, int done, int) {
    if (what.find("splats, step") != std::string::npos) least = std::min(least, done);
  };
  const Estimate rest = perceive(run.capture, pipeline, 3, {}, 0, out, watch);
  EXPECT_GE(least, 500);
  ASSERT_EQ(rest.poses.size(), first.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(rest.poses[i].camera_from_world.translation_m,
              first[i].camera_from_world.translation_m);
  }
  EXPECT_FALSE(fs::exists(out / "splats.unfinished"));
  EXPECT_FALSE(fs::exists(out / "splats.unfinished.colmap"));
  const std::string calls = program.calls();
  const std::size_t first_map = calls.find("mapper");  // of the training that is not stopped
  EXPECT_EQ(calls.find("mapper", first_map + 1), calls.rfind("mapper"));
  write_splat_ply(folder / "whole.ply", whole.splats);
  write_splat_ply(folder / "rest.ply", rest.splats);
  EXPECT_EQ(bytes_of(folder / "whole.ply"), bytes_of(folder / "rest.ply"));
  fs::remove_all(folder);
}

TEST(ClosedLoop, AJobWhosePosesNeedColmapSaysThatItIsNotThere) {
  SeedsSuiteConfig config;
  config.quick = true;
  config.sets = {"seeds=1",
                 "views=3",
                 "rig.width_px=320",
                 "rig.height_px=180",
                 "render.irradiance_samples=16",
                 "render.edge_samples=4",
                 "pipeline.splats.poses=sfm"};
  const fs::path nowhere = fresh_folder("no_programs");
  fs::create_directories(nowhere);
  const ProgramPath path(nowhere.string());
  for (const ShardJob& job : seeds_suite_jobs(config)) {
    if (job.name != "quick_splats_zhengdan958.json") continue;
    std::string text;
    try {
      text = job.run();
    } catch (const StageError& error) {
      if (error.stage != "clusters") throw;
      GTEST_SKIP() << error.what();  // PCL is off
    }
    const ScoreFile file = scores_from_json(text, job.name);
    const auto row = std::find_if(file.scores.begin(), file.scores.end(), [](const ScoreRow& each) {
      return each.method == std::string("splats_paper");
    });
    ASSERT_NE(row, file.scores.end());
    EXPECT_EQ(row->status, ScoreStatus::not_built);
    EXPECT_EQ(row->metric, "poses: not_built");
    EXPECT_THAT(row->case_name, HasSubstr(", poses sfm"));
    return;
  }
  FAIL() << "no such job";
}

}  // namespace
}  // namespace cousin
