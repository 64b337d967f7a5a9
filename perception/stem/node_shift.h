#pragma once

#include <Eigen/Core>
#include <string>

#include "perception/stem/eye_pair.h"
#include "sim/config/fields.h"
#include "sim/types/image.h"

namespace cousin {

/// How the images themselves say where the right eye sees what is at a pixel of the left one.
struct NodeShiftConfig {
  int half_width_px = 6;         ///< of the window: a stem and both of its edges
  int half_height_px = 13;       ///< along the stem
  double search_px = 8;          ///< to both sides of where the right point was found, or more:
  double search_sigmas = 4;      ///< so many deviations of the points' distance
  double least_likeness = 0.75;  ///< correlation of the windows; less is no match
  double sigma_px = 0.5;         ///< of a match [fitted on seeds 102 and 11: leaves before stems]
};
Fields fields(NodeShiftConfig& config);
void validate(const NodeShiftConfig& config);

/// Luma and excess green (2 g - r - b) of a picture, in codes: leaves differ from soil in either.
struct EyePicture {
  Image<float> luma, green;
};
EyePicture eye_picture(const Image<Rgb8>& color);

/// Where the right image shows what the left one has at a pixel.
struct NodeShift {
  std::string why_none;  ///< empty: it is found
  Eigen::Vector2d right_px = Eigen::Vector2d::Zero();
  double likeness = 0;
};
/// Compares windows along the epipolar line of the left point about the right one, then to a
/// fraction of a pixel by least squares over both coordinates with free brightness and contrast
/// [Gruen, Adaptive least squares correlation, 1985]. What both images have in common, as where the
/// left point is on the stem, it cannot mend.
/// @param off_px  how far right points lie below their epipolar lines
NodeShift find_shift(const EyePair& eyes, const EyePicture& left, const EyePicture& right,
                     const EyeNode& left_node, const EyeNode& right_node, double off_px,
                     const NodeShiftConfig& config = {});

}  // namespace cousin
