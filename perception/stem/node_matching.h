#pragma once

#include <functional>
#include <vector>

#include "perception/stem/eye_pair.h"
#include "sim/config/fields.h"

namespace cousin {

/// Which point of the left image is which of the right one.
struct NodeMatchConfig {
  double paper_epsilon_px = 4;    ///< method paper: largest epipolar distance [free; not published]
  double most_sigmas = 4;         ///< ours: largest epipolar distance over its deviation
  double calibration_px = 1.5;    ///< deviation of the right image's offset from its calibration
  double cone_rad = 0.25;         ///< a node is above its root within this of the image's vertical
  double lean_sigma_rad = 0.175;  ///< deviation of a stem's lean to or from the camera
};
Fields fields(NodeMatchConfig& config);
void validate(const NodeMatchConfig& config);

/// How far all right points are below their epipolar lines, and how much one of them scatters.
struct EpipolarOffset {
  double offset_px = 0;
  double sigma_px = 0;  ///< of the offset
  int matches = 0;
};

/// A pair of points that are one.
struct NodePair {
  EyeNode left, right;
  double epipolar_px = 0;  ///< of the right point from the left one's line
};
/// One plant's points in both images, from the root upwards.
struct MatchedPlant {
  bool has_root = false;  ///< the first pair is the root
  std::vector<NodePair> pairs;
};

/// How unlike two places of the images look, 0 (alike) to 1; null = not asked.
using Unlikeness = std::function<double(const Eigen::Vector2d& left, const Eigen::Vector2d& right)>;

/// The paper's rule: two points match if each lies within epsilon of the other's epipolar line, and
/// each is the other's nearest [Maize 3.1; which of several it takes is not said there]. All nodes
/// are of the one root.
std::vector<MatchedPlant> match_by_paper(const EyePair& eyes, const EyeNodes& left,
                                         const EyeNodes& right, const NodeMatchConfig& config = {});

/// Ours: for each pair of roots the nodes above them are aligned in their order along the stem,
/// one to one, so that the sum of squared epipolar distances and of what is left alone is least
/// (dynamic programming); a stem leans little, so that its nodes' disparities are near the root's.
/// Plants are taken from the best pair of roots on, and each point once. Without a root in either
/// image all nodes are one plant's.
/// @param offset  of the right image, of an earlier pass; default: unknown
std::vector<MatchedPlant> match_in_order(const EyePair& eyes, const EyeNodes& left,
                                         const EyeNodes& right, const NodeMatchConfig& config = {},
                                         const EpipolarOffset& offset = {},
                                         const Unlikeness& unlikeness = {});

/// What the epipolar distances of matches say of the rig, with `calibration_px` as a prior.
EpipolarOffset epipolar_offset(const std::vector<MatchedPlant>& plants,
                               const NodeMatchConfig& config = {});

}  // namespace cousin
