#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

#include "calibration/solve/calibrate.h"

namespace cousin {

/// A corner of a board in a model without a scale, such as a self-calibration's.
struct ModelCorner {
  int id = 0;  ///< of the target's points
  Eigen::Vector3d in_model;
};

struct BoardScale {
  CalibrationStatus status = CalibrationStatus::not_converged;
  std::string reason;
  /// Metres a unit of the model: the true side of a square over the model's.
  double m_per_unit = std::numeric_limits<double>::quiet_NaN();
  double sigma = std::numeric_limits<double>::quiet_NaN();  ///< its deviation
  double rms_m = std::numeric_limits<double>::quiet_NaN();  ///< a coordinate, what is left
  int corners = 0;
};

/// The scale of a model from a board of known size in it (Seeds paper: true square side over model
/// square side): the similarity that takes the board's corners to the model's by least squares
/// [Horn, JOSA A 1987], which uses all distances between corners at once. The deviation is of
/// errors that are independent and alike in all coordinates of the model: a bend of the whole model
/// is not in it. `bad_input` for an id that does not exist, is given twice or a corner that is not
/// finite; `not_determined` for fewer than four corners or corners on a line.
[[nodiscard]] BoardScale scale_from_board(const std::vector<ModelCorner>& corners,
                                          const std::vector<Eigen::Vector3d>& target_m);

}  // namespace cousin
