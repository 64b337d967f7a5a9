#pragma once

#include <map>
#include <stdexcept>
#include <string>
#include <string_view>

#include "sim/types/camera.h"
#include "sim/types/pose.h"

namespace cousin {

/// A photograph of a COLMAP model.
struct ColmapImage {
  std::string name;  ///< path below the folder of images
  int camera = 0;    ///< key of ColmapModel::cameras
  Pose camera_from_world;
};

/// What COLMAP's sparse model says of cameras; its points are not kept. Keys are COLMAP's ids.
struct ColmapModel {
  std::map<int, Camera> cameras;  ///< as ours: pixel centres are integers
  std::map<int, ColmapImage> images;
};

/// The three files of a model, as text (cameras.txt, ...) or binary (cameras.bin, ...). COLMAP
/// counts pixels from the image's corner, so that principal points are half a pixel larger there
/// [colmap.github.io/format.html].
struct ColmapFiles {
  std::string cameras;
  std::string images;
  std::string points;
};

/// Numbers of the text read back equal. There are no points.
/// @throws std::invalid_argument naming the camera whose lens COLMAP has no model for (thin prism
/// and splines).
ColmapFiles colmap_text(const ColmapModel& model);
ColmapFiles colmap_binary(const ColmapModel& model);

/// A file of cameras that is whole, its numbers finite, with a lens that is none (see `validate` of
/// a Camera): COLMAP writes such where it calibrates on images that do not fix the lens.
class ColmapLensError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Reads SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, FULL_OPENCV, OPENCV_FISHEYE,
/// SIMPLE_RADIAL_FISHEYE and RADIAL_FISHEYE. `points` is not read.
/// @param name  of the model's folder, for errors. @throws std::runtime_error naming file, line or
/// byte, value and limit; of a lens ColmapLensError.
ColmapModel colmap_from_text(const ColmapFiles& files, const std::string& name);
ColmapModel colmap_from_binary(const ColmapFiles& files, const std::string& name);

}  // namespace cousin
