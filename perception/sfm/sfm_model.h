#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "sim/dataset/colmap_tracks.h"
#include "sim/types/camera.h"
#include "sim/types/image.h"
#include "sim/types/pose.h"

namespace cousin {

struct SfmSighting {
  int image = 0;  ///< index into the images given
  Eigen::Vector2d pixel_px;
};
struct SfmPoint {
  Eigen::Vector3d in_world_m;  ///< in the model's unit
  Rgb8 color;
  std::vector<SfmSighting> sightings;  ///< ascending by image, one an image
};

/// One connected reconstruction of some of the images. Frame and unit are arbitrary.
struct SfmModel {
  std::vector<int> images;              ///< ascending: those that are placed
  std::vector<Camera> lenses;           ///< one for each of `images`
  std::vector<Pose> camera_from_world;  ///< the same
  std::vector<SfmPoint> points;
};

/// Of a COLMAP model whose photographs have the names given, in whatever order it numbers them.
/// Points that fewer than two images show are left out.
/// @param where  for errors. @throws std::runtime_error naming a photograph that was not given
SfmModel sfm_model(const ColmapTracks& tracks, const std::vector<std::string>& names,
                   const std::string& where);

}  // namespace cousin
