#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "perception/stem/node_matching.h"
#include "perception/stem/stem_fit.h"
#include "sim/types/rng.h"

namespace cousin {

/// A ZED in mode HD720 without distortion: 700 px, 120 mm.
inline EyePair made_eyes() {
  const Camera camera{LensModel::pinhole, 1280, 720, 700, 700, 639.5, 359.5, {}, {}};
  Pose right_from_left;
  right_from_left.translation_m = {-0.12, 0, 0};
  return {camera, camera, right_from_left};
}

/// A stem that leans and bends a little: the root, then nodes, up the image.
inline std::vector<Eigen::Vector3d> made_stem(double depth_m, double side_m = 0) {
  std::vector<Eigen::Vector3d> nodes;
  for (const double up : {0.0, 0.05, 0.09, 0.14, 0.21, 0.30})
    nodes.emplace_back(side_m + 0.04 * up, 0.15 - up, depth_m + 0.1 * up + 0.03 * up * up);
  return nodes;
}

/// What both eyes see, each with errors of its own and errors in common.
struct MadeView {
  EyeNodes left, right;
  std::vector<StemSighting> sightings;
};
inline MadeView made_view(const EyePair& eyes, const std::vector<Eigen::Vector3d>& nodes,
                          double own_px, double common_px, Rng rng) {
  MadeView view;
  const double told_px = std::max(0.05, std::hypot(own_px, common_px));
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Eigen::Vector2d both(common_px * normal(rng), common_px * normal(rng));
    StemSighting s;
    s.left = {
        *eyes.left.project(nodes[i]) + both + own_px * Eigen::Vector2d(normal(rng), normal(rng)),
        told_px};
    s.right = {*eyes.right.project(eyes.right_from_left * nodes[i]) + both +
                   own_px * Eigen::Vector2d(normal(rng), normal(rng)),
               told_px};
    (i == 0 ? view.left.roots : view.left.nodes).push_back(s.left);
    (i == 0 ? view.right.roots : view.right.nodes).push_back(s.right);
    view.sightings.push_back(s);
  }
  return view;
}

}  // namespace cousin
