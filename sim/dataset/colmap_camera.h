#pragma once

#include <string>
#include <vector>

#include "sim/types/camera.h"

namespace cousin {

/// Private to sim/dataset: a camera as COLMAP writes it.
struct ColmapCamera {
  std::string model;  ///< "OPENCV"
  int model_id = 0;   ///< its number in binary files
  std::vector<double> parameters;
};

/// @throws std::invalid_argument naming `who` and the lens that COLMAP has no model for.
ColmapCamera to_colmap(const Camera& camera, const std::string& who);

/// Numbers of parameters of a model by name or number. @throws std::runtime_error starting with
/// `where` and listing the models that are read.
ColmapCamera colmap_model_named(const std::string& model, const std::string& where);
ColmapCamera colmap_model_numbered(int model_id, const std::string& where);

/// The camera, checked. @throws ColmapLensError starting with `where`; std::runtime_error where a
/// parameter is not finite.
Camera from_colmap(const ColmapCamera& colmap, int width_px, int height_px,
                   const std::string& where);

}  // namespace cousin
