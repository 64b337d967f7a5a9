#include "perception/sfm/colmap_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <stdexcept>
#include <tuple>

#include "perception/sfm/sfm_poses.h"
#include "sim/process/scratch_folder.h"
#include "tests/perception/sfm/colmap_database_file.h"
#include "tests/perception/sfm/plant_views.h"
#include "tests/perception/sfm/stand_in_colmap.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

/// Some black pictures, small as nobody looks at them, matched in order.
struct Pictures {
  explicit Pictures(int count) : images(static_cast<std::size_t>(count), Image<Rgb8>(32, 18)) {
    for (int i = 0; i < count; ++i) {
      images[static_cast<std::size_t>(i)](0, 0).r = static_cast<std::uint8_t>(i);
      input.images.push_back(&images[static_cast<std::size_t>(i)]);
    }
    input.lens = plant_lens();
    input.lens->width_px = 32;
    input.lens->height_px = 18;
    input.pairs = image_pairs(count);
  }
  std::vector<Image<Rgb8>> images;
  ColmapInput input;
};

class ColmapRunTest : public testing::Test {
 protected:
  ScratchFolder scratch_{"cousin-test"};
  fs::path work_ = scratch_.path() / "a work folder; with $(odd) name";
  ColmapConfig config(const StandInColmap& program) const {
    ColmapConfig result;
    result.program = program.program();
    result.folder = work_.string();
    return result;
  }
  /// What a run of five images throws, in a folder of its own.
  std::string error_text(const StandInColmap& program) {
    ColmapConfig own = config(program);
    own.folder.clear();
    return error_of([&] { run_colmap(Pictures(5).input, own); });
  }
};

TEST_F(ColmapRunTest, ImagesAreKnownByTheirNamesWhateverTheirIds) {
  StandInColmap program(scratch_.path() / "p");
  const PlantViews views = plant_views({.images = 5, .points = 30, .lost = {3}}, 1);
  program.add_model(0, views);
  const ColmapRun run = run_colmap(Pictures(5).input, config(program));
  ASSERT_EQ(run.status, ColmapStatus::ok) << run.reason;
  EXPECT_EQ(run.version, "3.8");
  EXPECT_THAT(run.model.images, ElementsAre(0, 1, 2, 4));
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(run.model.camera_from_world[i].translation_m,
              views.model.camera_from_world[i].translation_m);
    EXPECT_NEAR(run.model.lenses[i].cx_px, views.lens.cx_px, 1e-9);
  }
  ASSERT_EQ(run.model.points.size(), views.model.points.size());
  for (std::size_t p = 0; p < run.model.points.size(); ++p) {
    const auto& seen = run.model.points[p].sightings;
    const auto& expected = views.model.points[p].sightings;
    ASSERT_EQ(seen.size(), expected.size());
    for (std::size_t k = 0; k < seen.size(); ++k) {
      EXPECT_EQ(seen[k].image, expected[k].image);
      EXPECT_NEAR((seen[k].pixel_px - expected[k].pixel_px).norm(), 0, 1e-9);
    }
  }
  EXPECT_THAT(run.model_sizes, ElementsAre(4));
}

TEST_F(ColmapRunTest, OfSeveralModelsTheLargestCounts) {
  StandInColmap program(scratch_.path() / "p");
  program.add_model(0, plant_views({.images = 9, .points = 50, .lost = {0, 1, 2, 3, 4, 5}}, 1));
  program.add_model(1, plant_views({.images = 9, .points = 20, .lost = {6, 7, 8}}, 1));
  const ColmapRun run = run_colmap(Pictures(9).input, config(program));
  EXPECT_THAT(run.model.images, ElementsAre(0, 1, 2, 3, 4, 5));
  EXPECT_THAT(run.model_sizes, ElementsAre(6, 3));
}

TEST_F(ColmapRunTest, WhatIsDoneIsNotDoneAgain) {
  StandInColmap program(scratch_.path() / "p");
  program.add_model(0, plant_views({.images = 5, .points = 30}, 1));
  const Pictures pictures(5);
  EXPECT_FALSE(run_colmap(pictures.input, config(program)).resumed);
  const std::string once = "help\nfeature_extractor\nmatches_importer\nmapper\n";
  EXPECT_EQ(program.calls(), once);
  const ColmapRun again = run_colmap(pictures.input, config(program));
  EXPECT_TRUE(again.resumed);
  EXPECT_EQ(again.status, ColmapStatus::ok);
  EXPECT_EQ(program.calls(), once + "help\n");
  // A step whose mark is gone is done again, and so is all after it.
  fs::remove(work_ / "mapping.done");
  EXPECT_TRUE(run_colmap(pictures.input, config(program)).resumed);
  EXPECT_EQ(program.calls(), once + "help\nhelp\nmapper\n");
}

/// A mapper that leaves other images without a place the second time.
const std::string kSecondModel =
    "if [ \"$1\" = mapper ]; then\n"
    "  [ -e \"$here/mapped\" ] && rm -r \"$here/models/0\" && mv \"$here/second\" "
    "\"$here/models/0\"\n"
    "  touch \"$here/mapped\"; fi";

TEST_F(ColmapRunTest, ImagesWithoutAPlaceAreMatchedWithAllOthers) {
  Pictures pictures(12);
  pictures.input.pairs = image_pairs(12, {.neighbours = 2, .far_per_image = 0});
  // The larger of both models counts.
  for (const auto& [folder, lost_then, expected] :
       {std::tuple("better", std::vector{7}, 11U),
        std::tuple("worse", std::vector{1, 3, 7, 9, 10}, 9U)}) {
    const fs::path home = scratch_.path() / folder;
    StandInColmap program(home, kSecondModel);
    program.add_model(0, plant_views({.images = 12, .points = 30, .lost = lost_then}, 1));
    fs::rename(home / "models" / "0", home / "second");
    program.add_model(0, plant_views({.images = 12, .points = 30, .lost = {3, 7, 9}}, 1));
    ColmapConfig own = config(program);
    own.folder += folder;
    own.match_lost = false;
    EXPECT_EQ(run_colmap(pictures.input, own).model.images.size(), 9U);
    EXPECT_FALSE(fs::exists(fs::path(own.folder) / "pairs_lost.txt"));
    own.match_lost = true;
    const ColmapRun run = run_colmap(pictures.input, own);
    ASSERT_EQ(run.status, ColmapStatus::ok) << run.reason;
    EXPECT_EQ(run.model.images.size(), expected);
    EXPECT_EQ(run.timings.size(), 5U);
    const std::string list = read_file(fs::path(own.folder) / "pairs_lost.txt");
    EXPECT_THAT(list, HasSubstr("000000.png 000003.png\n"));
    EXPECT_THAT(list, testing::Not(HasSubstr("000002.png 000003.png\n")));  // matched before
    EXPECT_THAT(list, testing::Not(HasSubstr("000000.png 000004.png\n")));  // both have a place
    // It goes on where it was, there too.
    const std::string calls = program.calls();
    EXPECT_EQ(run_colmap(pictures.input, own).model.images.size(), expected);
    EXPECT_EQ(program.calls(), calls + "help\n");
  }
}

TEST_F(ColmapRunTest, OtherImagesPairsOrSettingsStartAnew) {
  StandInColmap program(scratch_.path() / "p");
  program.add_model(0, plant_views({.images = 5, .points = 30}, 1));
  Pictures pictures(5);
  run_colmap(pictures.input, config(program));
  pictures.images[2](7, 7).g = 1;
  EXPECT_FALSE(run_colmap(pictures.input, config(program)).resumed);
  pictures.input.pairs.pop_back();
  EXPECT_FALSE(run_colmap(pictures.input, config(program)).resumed);
  pictures.input.lens->fx_px += 1;
  EXPECT_FALSE(run_colmap(pictures.input, config(program)).resumed);
  ColmapConfig other = config(program);
  other.max_features = 4000;
  EXPECT_FALSE(run_colmap(pictures.input, other).resumed);
  EXPECT_TRUE(run_colmap(pictures.input, other).resumed);
  // Its words of extraction are the same, and the database has matches of lost images by now.
  other.lens = other.lens == ColmapLens::focal ? ColmapLens::given : ColmapLens::focal;
  EXPECT_FALSE(run_colmap(pictures.input, other).resumed);
}

TEST_F(ColmapRunTest, AStepThatFailedIsTriedAgainWithWhatWasDoneBefore) {
  const std::string fails_once =
      "if [ \"$1\" = mapper ] && ! [ -e \"$here/failed\" ]; then touch \"$here/failed\"; "
      "echo 'no space left'; exit 3; fi";
  StandInColmap program(scratch_.path() / "p", fails_once);
  program.add_model(0, plant_views({.images = 5, .points = 30}, 1));
  const Pictures pictures(5);
  const ColmapRun failed = run_colmap(pictures.input, config(program));
  EXPECT_EQ(failed.status, ColmapStatus::program_failed);
  EXPECT_THAT(failed.reason, HasSubstr("mapping: "));
  EXPECT_THAT(failed.reason, HasSubstr("exited with 3"));
  EXPECT_THAT(failed.reason, HasSubstr("no space left"));
  const ColmapRun again = run_colmap(pictures.input, config(program));
  EXPECT_EQ(again.status, ColmapStatus::ok);
  EXPECT_TRUE(again.resumed);
}

TEST_F(ColmapRunTest, AFolderThatNoRunOfOursWroteIsLeftAsItIs) {
  StandInColmap program(scratch_.path() / "p");
  program.add_model(0, plant_views({.images = 5, .points = 30}, 1));
  const Pictures pictures(5);
  for (const char* name : {"images/field.png", "sparse/0/images.bin", "sparse_lost/a",
                           "database.db", "pairs.txt", "mapping.log", "features.done"}) {
    const fs::path theirs = work_ / name;
    write_file(theirs, "a day's work");
    EXPECT_THAT([&] { run_colmap(pictures.input, config(program)); },
                testing::ThrowsMessage<std::invalid_argument>(
                    HasSubstr((work_ / *fs::path(name).begin()).string() + " is there")));
    EXPECT_EQ(read_file(theirs), "a day's work");
    EXPECT_FALSE(fs::exists(work_ / "database.key"));
    fs::remove_all(work_);
  }
  // Whatever else lies there is nobody's hindrance.
  write_file(work_ / "notes.txt", "a day's work");
  EXPECT_EQ(run_colmap(pictures.input, config(program)).status, ColmapStatus::ok);
  EXPECT_EQ(read_file(work_ / "notes.txt"), "a day's work");
}

TEST_F(ColmapRunTest, FeaturesThatWereStoppedStartWithAnEmptyDatabase) {
  const std::string stopped_once =
      "if [ \"$1\" = feature_extractor ]; then\n"
      "  while [ $# -gt 0 ]; do [ \"$1\" = --database_path ] && database=$2; shift; done\n"
      "  [ -e \"$database\" ] && echo 'a camera is there' && exit 1\n"
      "  touch \"$database\"\n"
      "  [ -e \"$here/stopped\" ] || { touch \"$here/stopped\"; kill -9 $$; }; fi";
  StandInColmap program(scratch_.path() / "p", stopped_once);
  program.add_model(0, plant_views({.images = 5, .points = 30}, 1));
  const Pictures pictures(5);
  EXPECT_EQ(run_colmap(pictures.input, config(program)).status, ColmapStatus::program_failed);
  const ColmapRun again = run_colmap(pictures.input, config(program));
  EXPECT_EQ(again.status, ColmapStatus::ok) << again.reason;
}

TEST_F(ColmapRunTest, ASecondTryThatFailsCostsNothingOfTheFirst) {
  const std::string fails_then =
      "if [ \"$1\" = mapper ]; then\n"
      "  [ -e \"$here/mapped\" ] && echo 'no space left' && exit 3\n"
      "  touch \"$here/mapped\"; fi";
  StandInColmap program(scratch_.path() / "p", fails_then);
  program.add_model(0, plant_views({.images = 12, .points = 30, .lost = {3, 7, 9}}, 1));
  Pictures pictures(12);
  pictures.input.pairs = image_pairs(12, {.neighbours = 2, .far_per_image = 0});
  const ColmapRun run = run_colmap(pictures.input, config(program));
  EXPECT_EQ(run.status, ColmapStatus::ok);
  EXPECT_EQ(run.model.images.size(), 9U);
  EXPECT_THAT(run.reason, HasSubstr("mapping_lost: "));
  EXPECT_THAT(run.reason, HasSubstr("no space left"));
}

TEST_F(ColmapRunTest, AStepThatDoesNotEndIsStopped) {
  StandInColmap program(scratch_.path() / "p", "[ \"$1\" = matches_importer ] && exec sleep 1000");
  ColmapConfig limited = config(program);
  limited.time_limit_s = 0.5;
  const ColmapRun run = run_colmap(Pictures(5).input, limited);
  // On a machine that stalls, the step before may have used the time up.
  EXPECT_EQ(run.status, ColmapStatus::timed_out);
  EXPECT_THAT(run.reason, HasSubstr("time limit"));
}

TEST_F(ColmapRunTest, ImagesThatShowNothingInCommonGiveNoModel) {
  StandInColmap program(
      scratch_.path() / "p",
      "[ \"$1\" = mapper ] && echo 'E1 sfm.cc:286] failed to create sparse model' && exit 1");
  const ColmapRun run = run_colmap(Pictures(5).input, config(program));
  EXPECT_EQ(run.status, ColmapStatus::no_model);
  StandInColmap empty(scratch_.path() / "q");
  EXPECT_EQ(run_colmap(Pictures(4).input, config(empty)).status, ColmapStatus::no_model);
}

TEST_F(ColmapRunTest, AModelOfOtherImagesOrADamagedOneIsAnError) {
  StandInColmap program(scratch_.path() / "p");
  program.add_model(0, plant_views({.images = 9, .points = 30}, 1));
  EXPECT_THAT(error_text(program), HasSubstr("a photograph \"000008.png\" that it was not given"));
  write_file(scratch_.path() / "p" / "models" / "0" / "points3D.bin", "x");
  EXPECT_THAT(error_text(program), HasSubstr("points3D.bin: byte 0: the file ends here"));
}

TEST_F(ColmapRunTest, AModelWhoseLensIsNoneIsLeftOutForASmallerOne) {
  StandInColmap program(scratch_.path() / "p");
  PlantViews bent = plant_views({.images = 9, .points = 50}, 1);
  bent.lens.distortion = {-2, 0, 0, 0, 0};
  program.add_model(0, bent);
  EXPECT_EQ(run_colmap(Pictures(9).input, config(program)).status, ColmapStatus::no_lens);
  program.add_model(1, plant_views({.images = 9, .points = 20, .lost = {6, 7, 8}}, 1));
  const ColmapRun run = run_colmap(Pictures(9).input, config(program));  // maps again
  EXPECT_EQ(run.status, ColmapStatus::ok);
  EXPECT_THAT(run.model_sizes, ElementsAre(6));
  EXPECT_THAT(run.reason, HasSubstr("model 0/cameras.bin"));
}

TEST_F(ColmapRunTest, WithoutTheProgramNothingRunsAndTheStatusSaysSo) {
  ColmapConfig none;
  none.program = "colmap-that-is-not-there";
  const ColmapRun run = run_colmap(Pictures(3).input, none);
  EXPECT_EQ(run.status, ColmapStatus::not_built);
  EXPECT_THAT(run.reason, HasSubstr("COLMAP was not found"));
  EXPECT_EQ(colmap_version(none.program), "");
  none.program = "true";  // a program, but not COLMAP
  EXPECT_EQ(run_colmap(Pictures(3).input, none).status, ColmapStatus::program_failed);
}

TEST_F(ColmapRunTest, TheLensIsHandedOverFromThePixelsCorner) {
  StandInColmap program(scratch_.path() / "p");
  program.add_model(0, plant_views({.images = 5, .points = 30}, 1));
  Pictures pictures(5);
  pictures.input.lens->distortion[4] = 0;
  run_colmap(pictures.input, config(program));
  EXPECT_THAT(
      program.arguments(),
      HasSubstr("\nOPENCV\n--ImageReader.camera_params\n1080,1080,643.5,356.5,0.05,-0.08,"));
  EXPECT_THAT(program.arguments(), HasSubstr("--ImageReader.single_camera\n1\n"));
  EXPECT_THAT(program.arguments(),
              HasSubstr("--database_path\n" + (work_ / "database.db").string()));
  ColmapConfig self = config(program);
  self.lens = ColmapLens::self;
  self.lens_per_image = true;
  self.folder = (scratch_.path() / "self").string();
  pictures.input.lens.reset();
  EXPECT_EQ(run_colmap(pictures.input, self).status, ColmapStatus::ok);
  EXPECT_THAT(program.arguments(), HasSubstr("single_camera_per_image\n1\n"
                                             "--ImageReader.camera_model\nSIMPLE_RADIAL\n"));
}

TEST_F(ColmapRunTest, WrongInputIsRefused) {
  Pictures pictures(3);
  EXPECT_THROW(run_colmap(pictures.input, {.threads = 0}), std::invalid_argument);
  ColmapInput no_lens = pictures.input;
  no_lens.lens.reset();
  EXPECT_THROW(run_colmap(no_lens), std::invalid_argument);
  ColmapInput pair = pictures.input;
  pair.pairs.push_back({1, 3});
  EXPECT_THROW(run_colmap(pair), std::invalid_argument);
  const Image<Rgb8> other(640, 480);
  ColmapInput sizes = pictures.input;
  sizes.images[1] = &other;
  EXPECT_THROW(run_colmap(sizes), std::invalid_argument);
  ColmapInput lens = pictures.input;
  lens.lens->width_px = 33;
  EXPECT_THROW(run_colmap(lens), std::invalid_argument);
  sizes.images[1] = nullptr;
  EXPECT_THROW(run_colmap(sizes), std::invalid_argument);
  EXPECT_EQ(run_colmap({}, {.lens = ColmapLens::self}).status, ColmapStatus::too_few_images);
}

/// A capture of the views' frames, whose photographs are black: a stand-in program looks at none.
Capture capture_of(const PlantViews& views) {
  Capture capture;
  for (const int id : views.frames) {
    Frame frame{.id = id};
    frame.sensors.push_back({.reported = views.lens, .color = Image<Rgb8>(1280, 720)});
    capture.frames.push_back(std::move(frame));
  }
  return capture;
}

TEST_F(ColmapRunTest, ACaptureGoesThroughTheProgramToMetricPoses) {
  StandInColmap program(scratch_.path() / "p");
  const PlantViews views = plant_views({.lost = {4}}, 3);
  program.add_model(0, views);
  SfmConfig sfm;
  sfm.colmap = config(program);
  const SfmEstimate estimate =
      estimate_poses_sfm(capture_of(views), views.corners, views.board, sfm);
  if (estimate.status == SfmStatus::not_built) GTEST_SKIP() << estimate.reason;
  EXPECT_EQ(estimate.status, SfmStatus::ok) << estimate.reason;
  EXPECT_THAT(estimate.by_board, ElementsAre(14));
  EXPECT_EQ(estimate.gauge, BundleGauge::metric);
  EXPECT_EQ(estimate.colmap_version, "3.8");
  std::vector<std::string> stages;
  for (const StageTiming& timing : estimate.timings) stages.push_back(timing.stage);
  EXPECT_THAT(stages, ElementsAre("features", "matches", "mapping", "matches_lost", "mapping_lost",
                                  "adjust"));
}

TEST_F(ColmapRunTest, WhyASecondTryFailedIsInTheEstimatesReason) {
  StandInColmap program(scratch_.path() / "p",
                        "if [ \"$1\" = mapper ]; then\n"
                        "  [ -e \"$here/mapped\" ] && echo 'no space left' && exit 3\n"
                        "  touch \"$here/mapped\"; fi");
  const PlantViews views = plant_views({.lost = {4}}, 3);
  program.add_model(0, views);
  SfmConfig sfm;
  sfm.colmap = config(program);
  sfm.place_by_board = false;
  const SfmEstimate estimate =
      estimate_poses_sfm(capture_of(views), views.corners, views.board, sfm);
  if (estimate.status == SfmStatus::not_built) GTEST_SKIP() << estimate.reason;
  EXPECT_THAT(estimate.lost, ElementsAre(14));
  EXPECT_THAT(estimate.reason, HasSubstr("no space left"));
}

/// Puts `made.db`, which lies beside the program, where the features go.
const std::string kOwnDatabase =
    "if [ \"$1\" = feature_extractor ]; then\n"
    "  while [ $# -gt 0 ]; do [ \"$1\" = --database_path ] && database=$2; shift; done\n"
    "  cp \"$here/made.db\" \"$database\"; fi";

TEST_F(ColmapRunTest, ADatabaseThatCannotBeReadCostsNoModel) {
  StandInColmap program(scratch_.path() / "p", kOwnDatabase);
  program.add_model(0, plant_views({.images = 5, .points = 30}, 1));
  write_file(scratch_.path() / "p" / "made.db", "no database");
  const ColmapRun run = run_colmap(Pictures(5).input, config(program));
  EXPECT_EQ(run.status, ColmapStatus::ok);
  EXPECT_EQ(run.model.images.size(), 5U);
  EXPECT_TRUE(run.images.empty());
  EXPECT_THAT(run.reason, HasSubstr("database.db: "));
}

TEST_F(ColmapRunTest, ALostFrameSaysWhatWasFoundOfIt) {
  StandInColmap program(scratch_.path() / "p", kOwnDatabase);
  const PlantViews views = plant_views({.images = 6, .lost = {4}}, 3);
  program.add_model(0, views);
  std::string images, features;
  for (int i = 0; i < 6; ++i) {
    const std::string id = std::to_string(20 - i), comma = i > 0 ? "," : "";
    images += comma + "(" + id + ", '" + colmap_image_name(i) + "')";
    features += comma + "(" + id + ", " + std::to_string(100 * i) + ")";
  }
  write_database(scratch_.path() / "p" / "made.db",
                 kColmapTables + "INSERT INTO images VALUES " + images +
                     "; INSERT INTO keypoints (image_id, rows) VALUES " + features +
                     "; INSERT INTO matches (pair_id, rows) VALUES " + colmap_pair(16, 17, 3) +
                     "," + colmap_pair(16, 19, 0) + "," + colmap_pair(17, 19, 80) +
                     "; INSERT INTO two_view_geometries VALUES " + colmap_pair(16, 17, 0) + "," +
                     colmap_pair(17, 19, 70));
  SfmConfig sfm;
  sfm.colmap = config(program);
  sfm.place_by_board = false;
  const SfmEstimate estimate =
      estimate_poses_sfm(capture_of(views), views.corners, views.board, sfm);
  if (estimate.status == SfmStatus::not_built) GTEST_SKIP() << estimate.reason;
  EXPECT_THAT(estimate.lost, ElementsAre(14));
  ASSERT_EQ(estimate.images.size(), 6U);
  EXPECT_EQ(estimate.images[3].partners, 1);
  EXPECT_THAT(estimate.reason,
              HasSubstr("frame 14: 400 features, matched with 2, of which 0 agree"));
}

}  // namespace
}  // namespace cousin
