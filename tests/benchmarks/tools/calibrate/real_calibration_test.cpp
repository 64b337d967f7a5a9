// Published calibrations of real cameras [BoofCV-Data, example/calibration], from their images.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "benchmarks/tools/calibrate/calibration_run.h"
#include "tests/places/places.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const fs::path kSets = real_data() / "calib";
const CalibrationTarget kBoard{TargetKind::chessboard, 7, 5, 0.03, 0, ""};

/// The published lens: k1 and k2 alone.
CalibrateConfig as_published() {
  CalibrateConfig config;
  config.calibration.fixed = {"k3", "p1", "p2"};
  return config;
}

/// One camera's photographs of a set.
CalibrationPhotos only(CalibrationPhotos photos, int camera) {
  std::erase_if(photos.photos, [&](const CalibrationPhoto& p) { return p.camera != camera; });
  for (CalibrationPhoto& p : photos.photos) p.camera = 0;
  photos.cameras = {photos.cameras[static_cast<std::size_t>(camera)]};
  return photos;
}

void expect_focal(const CalibrationRun& run, double fx_px, double fy_px) {
  ASSERT_TRUE(run.problems.empty()) << run.problems.front();
  const Camera& camera = run.result.cameras.front();
  EXPECT_NEAR(camera.fx_px, fx_px, 0.002 * fx_px);
  EXPECT_NEAR(camera.fy_px, fy_px, 0.002 * fy_px);
}

class RealCalibration : public testing::Test {
 protected:
  void SetUp() override {
    if (!fs::is_directory(kSets)) GTEST_SKIP() << "no real captures at " << kSets;
#ifdef COUSIN_NO_CERES
    GTEST_SKIP() << "weighs points, which needs Ceres";
#endif
  }
};

TEST_F(RealCalibration, OneCamerasFocalLengthsAreThePublished) {
  const CalibrationRun run = run_calibration(
      photos_of_folder(kSets / "boofcv_sony_mono_chess", kBoard), as_published(), {});
  expect_focal(run, 701.012, 698.654);
}

TEST_F(RealCalibration, AStereoHeadsFocalLengthsAreThePublishedOneByOneAndItsBaselineTogether) {
  const CalibrationPhotos both = photos_of_folder(kSets / "boofcv_bumblebee2_stereo_chess", kBoard);
  // The published calibration takes each camera alone first.
  expect_focal(run_calibration(only(both, 0), as_published(), {}), 524.614, 526.920);
  expect_focal(run_calibration(only(both, 1), as_published(), {}), 526.437, 528.652);
  const CalibrationRun run = run_calibration(both, as_published(), {});
  ASSERT_TRUE(run.problems.empty()) << run.problems.front();
  EXPECT_NEAR(run.result.camera_from_rig[1].translation_m.norm(), 0.120044, 0.0002);
  EXPECT_LT(run.result.rms_px, 0.1);
}

TEST_F(RealCalibration, AFisheyeIsRefusedWithAPinholesLensAndFitsWithItsOwn) {
  CalibrationPhotos photos = photos_of_folder(kSets / "boofcv_fisheye_chess", kBoard);
  CalibrateConfig config;
  const CalibrationRun lean = run_calibration(photos, config, {});
  ASSERT_FALSE(lean.problems.empty());
  EXPECT_THAT(lean.problems, testing::Contains(HasSubstr("does not fit: residuals of")));
  config.model = LensModel::kannala_brandt4;
  const CalibrationRun wide = run_calibration(std::move(photos), config, {});
  EXPECT_TRUE(wide.problems.empty()) << wide.problems.front();
  EXPECT_LT(wide.result.rms_px, 0.25);
  // Of the published lens, a unified model: the centre, which both have.
  EXPECT_NEAR(wide.result.cameras.front().cx_px, 319.179, 1);
  EXPECT_NEAR(wide.result.cameras.front().cy_px, 319.717, 1);
}

}  // namespace
}  // namespace cousin
