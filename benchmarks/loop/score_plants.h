#pragma once

#include "benchmarks/loop/score_seeds.h"

namespace cousin {

/// Scores traits that are of one plant in one frame (TraitsOf::plants), and the nodes of its stem
/// (estimate.fits). In each frame a measured stem stands for the true plant whose points in the
/// first image are nearest to its own, within 60 pixels in the mean; its nodes stand for true ones
/// in their order, within 40 pixels, each once. True points are the keypoints "root" and "node ..."
/// that are inside the image; a node nearer than 6 pixels to the node below it is one with it to
/// any detector and left out.
/// - plants.found, .missed, .spurious; nodes.found, .missed, .spurious;
/// - internodes.measured: true internodes whose ends are measured next to each other;
///   internodes.false: measured ones that are no true one, for a node is missed or false;
/// - node.error_3d, .depth_rms, .across_rms: of nodes, in the camera's axes;
/// - internode.median_error, .median_share: of absolute errors, all and "of 20 mm or more";
/// - one specimen row for each true internode, as chord and along the stem, its instance being
///   100 times the plant's and the place of its upper end among the plant's points; and one of each
///   plant's height. not_solved where it was not measured.
/// @throws std::invalid_argument without true keypoints of every view
SeedsScores score_plants(const SceneTruth& truth, const Estimate& estimate,
                         const SeedsScoreLabels& labels);

/// A plant's root and nodes as the first image shows them, from the root upwards.
struct TruePlant {
  int instance = 0;  ///< id
  struct Point {
    bool is_root = false;
    Eigen::Vector2d pixel_px;
    Eigen::Vector3d in_camera_m;
    Eigen::Vector3d in_object_m;  ///< at rest
  };
  std::vector<Point> points;
};
/// Those of a view. @throws as score_plants
std::vector<TruePlant> true_plants(const SceneTruth& truth, std::size_t view);

/// Places of the true points that measured ones stand for, in their order; -1 = none.
std::vector<int> aligned_points(const std::vector<TruePlant::Point>& truth,
                                const std::vector<Eigen::Vector2d>& measured_px);

}  // namespace cousin
