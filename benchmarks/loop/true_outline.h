#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "benchmarks/score/scores.h"
#include "perception/pipelines/seeds.h"
#include "sim/dataset/truth_io.h"

namespace cousin {

Pose middle_pose(const TrueView& view);

/// Pixel of a world point through a rolling shutter: the row it lands on fixes the pose it is seen
/// from. The motion during readout is a pixel or so, so the fixed point iteration contracts fast.
std::optional<Eigen::Vector2d> project_rolling(const TrueView& view,
                                               const Eigen::Vector3d& point_in_world_m);

/// Edges between a triangle that faces the camera and one that does not, as pixel segments: those
/// of the outline, and those of folds inside it.
using TrueOutlineSegment = std::array<Eigen::Vector2d, 2>;
std::vector<TrueOutlineSegment> true_contour(const Mesh& mesh, const TrueView& view);

/// How far measured outlines lie from the true ones, along their normals, outwards positive.
struct OutlineScore {
  std::int64_t points = 0;  ///< on their objects, with a true outline within 3 px
  double bias_px = 0;
  double rms_px = 0;
  double normalized_rms = 0;  ///< of distance over the stated sigma
};

/// @param meshes_in_world  of the true objects
/// @param object_of        true object of each measured instance; -1: none
OutlineScore score_outlines(const Silhouettes& measured, const std::vector<TrueView>& views,
                            const std::vector<Mesh>& meshes_in_world,
                            const std::vector<int>& object_of);

}  // namespace cousin
