#pragma once

#include <functional>
#include <string>
#include <vector>

#include "calibration/calibrate.h"
#include "calibration/target_detection.h"
#include "sim/types/rng.h"

namespace cousin {

/// One way to calibrate from the corners of a study's photographs.
struct StudyMethod {
  std::string name;  ///< "ceres opencv5"
  LensModel model = LensModel::opencv5;
  CalibrationConfig solve;
  bool is_factory = false;  ///< nothing is calibrated: the lens that the device reports
};

/// One value of what a study varies: photographs of a board, and how cameras are calibrated from
/// them.
struct StudyPoint {
  std::string axis;   ///< "tilt"
  std::string label;  ///< of this value, with its unit: "20 deg"; of kinds their name
  double x = 0;       ///< the value in `unit`; of kinds their number
  std::string unit;
  std::vector<std::string> sets;  ///< of BoardPhotographs, beyond the study's own
  std::vector<StudyMethod> methods;
  double outlier_share = 0;  ///< of the corners found, moved by 2 to 20 px
  /// The lens at work after the calibration: it got a knock or is warm. Empty: as it was.
  std::function<Camera(const Camera&)> at_work;

  std::string name() const { return axis + " " + label; }
};

/// All points of `bench calibration`'s studies. @param quick  two or three a study
std::vector<StudyPoint> study_points(bool quick);

/// What holds for every point unless it says otherwise: an A4 board before a D457's colour camera,
/// 640 x 480, as in the Strawberries paper.
std::vector<std::string> study_sets(bool quick);

/// Labels of the horizontal axis of each study, with unit; nothing for a study of kinds.
std::string study_label(const std::string& axis);

/// Moves a share of the points by 2 to 20 px in any direction, as corners of another square or of a
/// blurred edge are.
void spoil(std::vector<TargetView>& views, double share, Rng rng);

}  // namespace cousin
