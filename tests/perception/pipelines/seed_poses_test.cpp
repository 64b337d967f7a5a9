#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "perception/pipelines/seeds_splats.h"
#include "sim/process/scratch_folder.h"
#include "tests/perception/sfm/plant_views.h"
#include "tests/perception/sfm/stand_in_colmap.h"

namespace cousin {
namespace {

using testing::AllOf;
using testing::HasSubstr;

/// What lies on the board, with room above it.
const SweepVolume plant_volume{{-1, -1, -0.01}, {1, 1, 0.1}};

class SeedPosesTest : public testing::Test {
 protected:
  ScratchFolder scratch_{"cousin-test"};
  StandInColmap program_{scratch_.path() / "p"};
  std::vector<StartPoint> points_;
  SfmEstimate told_;

  /// A stand-in program looks at no photograph.
  Poses found(const PlantViews& views, SfmConfig config) {
    config.colmap.program = program_.program();
    Capture capture;
    for (const int id : views.frames) {
      Frame frame{.id = id};
      frame.sensors.push_back({.reported = views.lens, .color = Image<Rgb8>(1280, 720)});
      capture.frames.push_back(std::move(frame));
    }
    return poses_by_sfm(capture, views.corners, views.board, plant_volume, config, points_,
                        [this](const SfmEstimate& estimate) { told_ = estimate; });
  }
};

/// Of the camera centres, in the board's frame and size: no similarity is taken out.
double centres_rms_m(const Poses& poses, const PlantViews& views) {
  double square = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_EQ(poses[i].status, PoseStatus::ok) << i;
    square += (inverse(poses[i].camera_from_world).translation_m -
               inverse(views.camera_from_world[i]).translation_m)
                  .squaredNorm();
  }
  return std::sqrt(square / static_cast<double>(poses.size()));
}

TEST_F(SeedPosesTest, ThePapersWayAndOursAreMetricOnTheBoard) {
  const PlantViews views = plant_views({}, 3);
  program_.add_model(0, views);
  const Poses as_paper = found(views, paper_sfm_config());
  ASSERT_EQ(as_paper.size(), views.frames.size());
  EXPECT_LT(centres_rms_m(as_paper, views), 5e-3);
  Poses ours;
  try {
    ours = found(views, SfmConfig{});
  } catch (const NoPosesError& error) {
    if (error.status != SfmStatus::not_built) throw;
    GTEST_SKIP() << error.what();  // Ceres is off
  }
  ASSERT_EQ(ours.size(), views.frames.size());
  // 0.4 m away: 0.3 px of noise on 100 points, a few parts in ten thousand.
  EXPECT_LT(centres_rms_m(ours, views), 5e-4);
  EXPECT_GT(points_.size(), 20U);
  EXPECT_LT(points_.size(), views.points_in_world_m.size());  // not all lie in the volume
  for (const StartPoint& point : points_) {
    EXPECT_GE(point.position_m.z(), plant_volume.low_m.z());
    EXPECT_LE(point.position_m.z(), plant_volume.high_m.z());
  }
}

TEST_F(SeedPosesTest, WithoutAModelOrTheBoardItSaysWhy) {
  EXPECT_THAT([&] { found(plant_views({}, 3), paper_sfm_config()); },
              testing::ThrowsMessage<std::runtime_error>(HasSubstr("no metric model: no_model")));
  PlantViews views = plant_views({}, 3);
  program_.add_model(0, views);
  for (FrameCorners& corners : views.corners) corners.corners.clear();
  EXPECT_THAT([&] { found(views, paper_sfm_config()); },
              testing::ThrowsMessage<std::runtime_error>(HasSubstr("no metric model: no_scale")));
  EXPECT_TRUE(points_.empty());
}

TEST_F(SeedPosesTest, WhoGoesOnInTheSameFolderHasTheSamePosesAndTheirSeconds) {
  const PlantViews views = plant_views({}, 3);
  program_.add_model(0, views);
  SfmConfig config = paper_sfm_config();
  config.colmap.folder = (scratch_.path() / "kept").string();
  const Poses first = found(views, config);
  EXPECT_EQ(told_.done_before.wall_s, 0);
  program_.add_model(0, plant_views({}, 4));  // what COLMAP would find now
  const Poses again = found(views, config);
  EXPECT_GT(told_.done_before.wall_s, 0);
  ASSERT_EQ(again.size(), first.size());
  for (std::size_t i = 0; i < first.size(); ++i)
    EXPECT_EQ(again[i].camera_from_world.translation_m, first[i].camera_from_world.translation_m);
}

TEST_F(SeedPosesTest, ACalibrationThatIsNoLensIsToldAsSuch) {
  PlantViews views = plant_views({}, 3);
  views.lens.distortion = {-2, 0, 0, 0, 0};  // folds at half of the picture
  program_.add_model(0, views);
  try {
    found(views, paper_sfm_config());
    FAIL();
  } catch (const NoPosesError& error) {
    EXPECT_EQ(error.status, SfmStatus::not_determined);
    EXPECT_THAT(error.what(),
                AllOf(HasSubstr("do not fix the lens"), HasSubstr("model 0/cameras.bin"),
                      HasSubstr("not one-to-one at pixel")));
  }
  EXPECT_EQ(told_.status, SfmStatus::not_determined);
}

}  // namespace
}  // namespace cousin
