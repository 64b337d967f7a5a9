#pragma once

#include "sim/config/fields.h"
#include "sim/types/capture.h"
#include "sim/types/seams.h"

namespace cousin {

/// The part of the world that is swept, metres; the rest of each image is left out.
struct SweepVolume {
  Eigen::Vector3d low_m{-0.052, -0.052, -0.002};
  Eigen::Vector3d high_m{0.052, 0.052, 0.026};
};

struct MvsConfig {
  int neighbours = 6;           ///< views each reference is matched with
  int window_px = 7;            ///< side of the matching window, odd
  double step_px = 0.75;        ///< depth step as disparity in the neighbour that moves most
  double min_angle_rad = 0.08;  ///< parallax to a neighbour
  double max_angle_rad = 0.6;
  double min_score = 0.6;    ///< zero-mean NCC averaged over the better half of the neighbours
  int consistent_views = 2;  ///< other views whose depth agrees
  double consistency_px = 1.0;
  double consistency_depth = 0.001;  ///< relative; also the largest standard deviation that is kept
  bool normals = false;     ///< also those of the surfaces, 12 bytes a pixel of each reference
  int max_references = 20;  ///< 0 = every posed view; else evenly spread: a surface is seen by many
};
Fields fields(MvsConfig& config);
void validate(const MvsConfig& config);

/// Dense depth of each posed view by plane sweep or PatchMatch over lens-distorted images (warps
/// evaluated through the lens, on undistorted copies made once), sub-pixel refined, filtered by
/// consistency across views. TBB; vectorised; the same bytes on any number of threads. Views
/// without a pose or with too few neighbours get an empty image. depth images are on the *original*
/// (distorted) pixel grid of each frame. With `normals` a pixel with depth has the normal of the
/// surface's tangent plane as refinement left it, in the camera and towards it; zero = none.
Depths estimate_depths(const Capture& capture, const Poses& poses, const SweepVolume& volume,
                       const MvsConfig& config = {});

}  // namespace cousin
