#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <filesystem>

#include "perception/sfm/sfm_poses.h"
#include "sim/dataset/import.h"
#include "tests/places/places.h"

namespace cousin {
namespace {

/// The angle between where camera `b` stands and looks, seen from camera `a`, in two sets of poses:
/// no similarity changes it.
double turn_between_rad(const Pose& a, const Pose& b, const Pose& true_a, const Pose& true_b) {
  const Eigen::Quaterniond turn = b.rotation * a.rotation.conjugate();
  return turn.angularDistance(true_b.rotation * true_a.rotation.conjugate());
}

// The program itself, on pictures that were made with another renderer.
TEST(ColmapProgram, PlacesTheViewsOfARing) {
  const std::filesystem::path file =
      real_data() / ".." / "data" / "splat_neutral" / "transforms.json";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is absent";
  if (colmap_version().empty()) GTEST_SKIP() << "no program colmap";
  constexpr std::size_t kViews = 12;
  const Capture capture = import_nerfstudio(file);
  ASSERT_GE(capture.frames.size(), kViews);
  ColmapInput input;
  std::vector<int> frames;
  for (std::size_t i = 0; i < kViews; ++i) {
    input.images.push_back(&capture.frames[i].sensors.front().color);
    frames.push_back(capture.frames[i].id);
  }
  input.lens = capture.rig.front().camera;
  SfmConfig config;
  config.scale = SfmScale::none;
  input.pairs = image_pairs(static_cast<int>(kViews), config.pairs);
  // COLMAP's models vary: of ten runs on a busy machine one placed 3 of these images, and of some
  // fifty one had sightings at odds that 300 steps did not settle.
  ColmapRun run;
  SfmEstimate estimate;
  for (int attempt = 0; attempt < 3; ++attempt) {
    run = run_colmap(input, config.colmap);
    if (run.model.images.size() < kViews) continue;
    estimate = refine_sfm(run.model, frames, input.lens, {}, {}, config);
    if (estimate.status != SfmStatus::not_converged) break;
  }
  ASSERT_EQ(run.status, ColmapStatus::ok) << run.reason;
  EXPECT_EQ(run.model.images.size(), kViews) << run.reason;
  ASSERT_EQ(run.images.size(), kViews);
  int tried = 0;
  for (const ImageMatches& image : run.images) {
    EXPECT_GT(image.features, 100);
    EXPECT_GE(image.partners, 1);
    EXPECT_LE(image.partners, image.tried);
    tried += image.tried;
  }
  // The pairs given, and those of images that found no place at first.
  EXPECT_GE(tried, 2 * static_cast<int>(input.pairs.size()));
  EXPECT_LE(tried, static_cast<int>(kViews * (kViews - 1)));
  if (estimate.status == SfmStatus::not_built) GTEST_SKIP() << estimate.reason;
  ASSERT_EQ(estimate.status, SfmStatus::ok) << estimate.reason;
  ASSERT_EQ(estimate.poses.size(), kViews);
  for (std::size_t i = 1; i < kViews; ++i) {
    const double off_rad = turn_between_rad(
        estimate.poses[i - 1].camera_from_world, estimate.poses[i].camera_from_world,
        *capture.frames[i - 1].rig_from_world, *capture.frames[i].rig_from_world);
    EXPECT_LT(off_rad, 0.01) << i;
  }
}

}  // namespace
}  // namespace cousin
