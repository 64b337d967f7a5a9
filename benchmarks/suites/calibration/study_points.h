#pragma once

#include <functional>
#include <string>
#include <vector>

#include "calibration/boards/target_detection.h"
#include "calibration/solve/calibrate.h"
#include "sim/types/rng.h"

namespace cousin {

/// Who finds the corners: find_target, or OpenCV's findChessboardCorners and cornerSubPix.
enum class CornerFinder { ours, opencv };

/// One way to calibrate from the corners of a study's photographs.
struct StudyMethod {
  std::string name;  ///< "ceres opencv5"
  int views = 0;     ///< the first so many of the point's photographs; 0 = all
  CornerFinder finder = CornerFinder::ours;
  LensModel model = LensModel::opencv5;
  CalibrationConfig solve;
  bool is_factory = false;  ///< nothing is calibrated: the lens that the device reports
  /// Calibrated after whatever `at_work` says has happened: the lens is then as photographed.
  bool is_fresh = false;
};

/// One value of what a study varies: photographs of a board, and how cameras are calibrated from
/// them.
struct StudyPoint {
  std::string axis;   ///< "tilt"
  std::string label;  ///< of this value, with its unit: "20 deg"; of kinds their name
  double x = 0;       ///< the value in `unit`; of kinds their number
  std::string unit;
  int views = 0;                  ///< photographs: the first so many of those that its group takes
  std::vector<std::string> sets;  ///< of BoardPhotographs, beyond the study's own: what light falls
  std::vector<std::string> sensor_sets;  ///< and what the sensor makes of it
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
std::vector<std::string> study_sets();

/// Points whose photographs show the same light: one board, one lens, the same places. A photograph
/// does not depend on how many there are, so that points with fewer take the first ones.
struct StudyGroup {
  std::vector<std::string> sets;  ///< of BoardPhotographs
  int views = 0;                  ///< the most that a point takes
  /// Keys of each sensor, and how many photographs it takes: those with the most come first.
  std::vector<std::vector<std::string>> sensors;
  std::vector<int> sensor_views;
  std::vector<StudyPoint> points;
  std::vector<std::size_t> sensor_of_point;
};
/// All points in groups, each group where its first point stands.
std::vector<StudyGroup> study_groups(bool quick);

/// Labels of the horizontal axis of each study, with unit; nothing for a study of kinds.
std::string study_label(const std::string& axis);

/// Moves a share of the points by 2 to 20 px in any direction, as corners of another square or of a
/// blurred edge are.
void spoil(std::vector<TargetView>& views, double share, Rng rng);

}  // namespace cousin
