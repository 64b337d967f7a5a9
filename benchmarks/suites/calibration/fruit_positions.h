#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "benchmarks/score/scores.h"
#include "sim/types/camera.h"

namespace cousin {

/// The Strawberries paper's positioning, in full: fruits 0.3 to 0.6 m before a D457, depth at the
/// box's centre of the image aligned to colour (mean of a 5 x 5 window where there is none),
/// X = (u - cx) Z / fx as its equation 4 has it, held against a tape measure.
struct PositionsConfig {
  int points = 30;           ///< spread evenly over 0.3..0.6 m
  double tape_m = 0.002;     ///< sigma of one reading of each coordinate; free: 1 to 3 mm
  int readings = 2;          ///< averaged [paper, 2.6]
  double out_of_yaw_px = 0;  ///< disparity by which the unit has gone off since the factory
};

/// Where each step of the chain puts a point, in the colour camera's frame. Each step but the first
/// differs from the one before by one source of error; the last is what the paper's program prints.
enum class PositionStep {
  tape,        ///< what the tape says of the point that it was held to
  held,        ///< that point: the nearest of the fruit to the camera's plane
  box,         ///< the surface point under the box's centre, by the true lens
  aligned,     ///< with the depth that true depth aligned to colour has there
  unit,        ///< with the depth that this unit would report without noise
  measured,    ///< with the depth that it reports
  calibrated,  ///< by the calibrated lens
  pinhole      ///< by that lens without its distortion: equation 4
};
inline constexpr std::size_t kPositionSteps = 8;

struct FruitPosition {
  std::array<Eigen::Vector3d, kPositionSteps> step_m;
  Camera true_lens, calibrated_lens;
  Eigen::Vector2d box_px;  ///< centre
  bool has_depth = false;  ///< else the steps from `measured` on are NaN
};

/// One unit, one calibration, so many fruits. Deterministic in (config, seed, run).
std::vector<FruitPosition> measure_positions(const PositionsConfig& config, std::uint64_t seed,
                                             int run);

/// The paper's own calibration (Table 4).
Camera strawberry_paper_lens();

/// The method whose rows hold the tape to the point under the box's centre, not to the nearest.
inline constexpr const char* kHeldUnderBox =
    "as the paper, but held to the point under the box's centre";

/// Rows of several runs' positions: RMSE and MAE of x, y, z and range over 0.3-0.6 m and each
/// 0.1 m of it; for the whole chain, for each step's share alone, for the paper's lens in place of
/// the calibrated one with the tape's axes as the camera's and turned to fit, and the paper's
/// published numbers beside them.
std::vector<ScoreRow> position_rows(const std::vector<std::vector<FruitPosition>>& runs,
                                    const std::string& unit_name, std::uint64_t seed);

/// Table 5 of the paper as rows, and what share of a mean absolute error its RMSE is: .80 where
/// errors are normal about zero, 1 where they are all alike.
std::vector<ScoreRow> published_position_rows();

}  // namespace cousin
