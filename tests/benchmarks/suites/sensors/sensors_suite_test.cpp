#include "benchmarks/suites/sensors/sensors_suite.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "benchmarks/suites/sensors/colour_rows.h"
#include "benchmarks/suites/sensors/depth_rows.h"
#include "benchmarks/suites/sensors/fit_sensor_rows.h"
#include "benchmarks/suites/sensors/flat_fields.h"
#include "benchmarks/suites/sensors/moving_edge.h"
#include "sim/sensors/rig.h"

namespace cousin {
namespace {

TEST(PhotonTransfer, FindsAGainAndANoiseThatAreNotThePresets) {
  CameraSensorConfig config = flat_camera(rig_preset("dslr_apsc_24mp").sensors[0].camera);
  config.photosites.full_well_e = 20000;
  config.photosites.read_noise_e = 11;
  config.photosites.dark_current_e_per_s = 3000;  // shifts mean and variance along the same line
  const CameraUnit unit = make_camera_unit(config, Rng(4));
  const PhotonTransfer t = photon_transfer(config, unit, 12, 9);
  const double k = (16383 - 600) / 20000.0;
  // 153 600 photosites in 12 exposures: the slope is known to 0.1 %, the intercept to 0.5 %.
  EXPECT_NEAR(t.slope / k, 1, 0.005);
  EXPECT_NEAR(t.intercept / (k * k * (121 + 0.09) + 1 / 12.0), 1, 0.025);
}

TEST(FixedPattern, IsFoundBesideTheTemporalNoise) {
  CameraSensorConfig config = flat_camera(rig_preset("zed_hd720").sensors[0].camera);
  config.photosites.prnu = 0.02;
  config.photosites.dsnu_e = 3;
  const CameraUnit unit = make_camera_unit(config, Rng(4));
  const FixedPattern p = fixed_pattern(config, unit, 6, 9);
  EXPECT_NEAR(p.prnu, p.true_prnu, 5 * p.prnu_sigma + 0.0015 * 0.02);
  EXPECT_NEAR(p.true_prnu / 0.02, 1, 0.01);
  EXPECT_NEAR(p.dsnu_e, p.true_dsnu_e, 5 * p.dsnu_sigma_e + 0.0015 * 3);
  EXPECT_LT(p.dsnu_sigma_e, 0.1);
  EXPECT_NEAR(p.true_dsnu_e, std::sqrt(9 + 0.25 + 0.09), 0.05);
}

TEST(MovingEdge, SkewsByReadoutAndTrailsByExposure) {
  RigConfig rig = rig_preset("zed_hd720");
  rig.sensors[0].camera.photosites.exposure_s = 0.007;  // half of the readout of 14 ms
  const MovingEdge edge = measure_moving_edge(rig, 0);
  EXPECT_NEAR(edge.expected_skew_px, 12, 1e-9);
  EXPECT_NEAR(edge.expected_blur_px, 6, 1e-9);
  EXPECT_NEAR(edge.skew_px, 12, 0.01);
  EXPECT_NEAR(edge.blur_px, 6, 0.01);
}

TEST(MovingEdge, AGlobalShutterDoesNotSkew) {
  RigConfig rig = rig_preset("zed_hd720");
  for (RigSensor& sensor : rig.sensors) sensor.camera.photosites.readout_s = 0;
  EXPECT_NEAR(measure_moving_edge(rig, 0).skew_px, 0, 1e-3);
}

TEST(SensorsSuite, EveryColourRowWithALimitKeepsIt) {
  int limited = 0;
  for (const ScoreRow& row : colour_rows(1, true)) {
    EXPECT_EQ(row.suite, "sensors");
    EXPECT_TRUE(row.status == ScoreStatus::ok || row.status == ScoreStatus::pass)
        << row.case_name << " " << row.metric << " = " << row.value;
    limited += row.status == ScoreStatus::pass;
  }
  EXPECT_GE(limited, 8 * static_cast<int>(rig_preset_names().size()));
}

TEST(SensorsSuite, DepthRowsOfACameraAreNumbers) {
  // Which of them keep their limits is the benchmark's to say.
  const std::vector<ScoreRow> rows = depth_rows_of("d405", 1, true);
  EXPECT_GE(rows.size(), 5U);
  for (const ScoreRow& row : rows) {
    EXPECT_NE(row.status, ScoreStatus::error) << row.case_name << " " << row.metric;
    EXPECT_TRUE(std::isfinite(row.value)) << row.case_name << " " << row.metric;
  }
}

TEST(SensorsSuite, FitSensorKeepsItsLimits) {
  int limited = 0;
  for (const ScoreRow& row : fit_sensor_rows(1, true)) {
    EXPECT_NE(row.status, ScoreStatus::fail)
        << row.case_name << " " << row.metric << " = " << row.value;
    limited += row.status == ScoreStatus::pass;
  }
  EXPECT_EQ(limited, 9);  // coverage, solved, held out; three wrong models; the full model's three
}

TEST(SensorsSuite, EveryDepthCameraIsAJobOfItsOwnAndQuickOnesHaveOtherFiles) {
  std::set<std::string> names, keys;
  for (const bool quick : {false, true}) {
    for (const ShardJob& job : sensors_suite_jobs(3, quick)) {
      EXPECT_TRUE(names.insert(job.name).second) << job.name;
      EXPECT_TRUE(keys.insert(job.key).second) << job.key;
    }
  }
  for (const char* rig : {"d405", "d415", "d435i", "d455", "d457"})
    EXPECT_TRUE(names.contains(std::string("depth-") + rig + ".json")) << rig;
}

}  // namespace
}  // namespace cousin
