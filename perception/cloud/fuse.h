#pragma once

#include "perception/segment/green.h"
#include "sim/config/fields.h"
#include "sim/types/capture.h"
#include "sim/types/seams.h"

namespace cousin {

struct FuseConfig {
  double voxel_m =
      0.00015;  ///< points of different views nearer than this along and across the surface merge
  double agreement_m =
      0.0004;         ///< along the normal: depths of other views farther off see another surface
  int min_views = 2;  ///< that see the surface there, the point's own included
};
Fields fields(FuseConfig& config);
void validate(const FuseConfig& config);

/// Depth images to one metric cloud with normals, colours and sigmas; green pixels are left out.
/// Each depth becomes a point that is moved along its normal to the mean (weights 1/sigma^2) of the
/// views that see the surface there and agree; then points are averaged in voxels. Normals are
/// those of the depths where they are there, finite and face the camera, else of planes through 5 x
/// 5 depths. Order: by voxel, so the same on any number of threads. Frames whose depth image is
/// empty, or whose pose is missing, add nothing. Depths without sigma count alike. Frames without
/// colour give grey points. Points more than 2^21 voxels (315 m by default) from the world's origin
/// along an axis are left out: floats do not tell them apart. @throws std::invalid_argument if a
/// camera is so far, or if sizes of capture, poses, depths or their images differ.
Cloud fuse_depths(const Capture& capture, const Poses& poses, const Depths& depths,
                  const GreenConfig& green, const FuseConfig& config = {});

}  // namespace cousin
