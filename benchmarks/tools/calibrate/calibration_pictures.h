#pragma once

#include <vector>

#include "benchmarks/tools/calibrate/calibration_run.h"
#include "sim/types/image.h"

namespace cousin {

/// The first of camera 0's photos that shows the board, an infrared one as grey; empty if none
/// does. @throws std::runtime_error naming a file that cannot be read.
Image<Rgb8> sample_picture(const CalibrationPhotos& photos, const std::vector<TargetView>& views);

/// Where a camera's points fell, over the first picture of it: green used, red rejected; the
/// outline of where to hold the board next, blue.
Image<Rgb8> coverage_picture(const CalibrationRun& run, int camera);

/// Mean residual of each cell of a 16 x 12 grid as a line from its middle, and the RMS as colour:
/// blue 0, yellow three times what detection predicted; grey without points. `pixels_per_px`: how
/// much longer than it is a line is drawn.
struct ResidualPicture {
  Image<Rgb8> image;
  double pixels_per_px = 0;
};
ResidualPicture residual_picture(const CalibrationRun& run, int camera);

/// Worst deviation of the projection over the image; blue least, yellow most, by logarithm.
struct UncertaintyPicture {
  Image<Rgb8> image;
  double least_px = 0, most_px = 0;
};
UncertaintyPicture uncertainty_picture(const CalibrationRun& run, int camera);

/// Measured less true depth in each cell of a 16 x 12 grid, the median of samples that are brought
/// to the working distance as a disparity's error is, by its square; grey without samples. Blue is
/// `-most_m`, green 0, yellow `most_m`. Empty for a run without depth.
struct DepthPicture {
  Image<Rgb8> image;
  double most_m = 0;
};
DepthPicture depth_picture(const CalibrationRun& run);

}  // namespace cousin
