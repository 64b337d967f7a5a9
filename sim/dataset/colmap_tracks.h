#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "sim/dataset/colmap_model.h"
#include "sim/types/image.h"

namespace cousin {

/// Where a photograph of a COLMAP model shows a point.
struct ColmapSighting {
  int image = 0;             ///< key of ColmapModel::images
  Eigen::Vector2d pixel_px;  ///< as ours: pixel centres are integers
};

struct ColmapPoint {
  Eigen::Vector3d in_world;  ///< in the model's unit
  Rgb8 color;
  double error_px = 0;  ///< mean reprojection error as COLMAP gives it; -1: it gives none
  std::vector<ColmapSighting> sightings;
};

/// A model with its points, ascending by COLMAP's ids.
struct ColmapTracks {
  ColmapModel model;
  std::vector<ColmapPoint> points;
};

/// Reads cameras.bin, images.bin and points3D.bin.
/// @param name  of the model's folder, for errors. @throws std::runtime_error naming file, byte,
/// value and limit: a track that names an image or one of its points that does not exist, a number
/// that is not finite, a count that the file has no room for, a point that occurs twice.
ColmapTracks colmap_tracks_from_binary(const ColmapFiles& files, const std::string& name);

}  // namespace cousin
