#pragma once

#include <string>
#include <vector>

#include "sim/truth/scene.h"
#include "sim/truth/truth_images.h"

namespace cousin {

/// A scene of what Blender and glTF can say.
struct PlainScene {
  Scene scene;
  TrueView view;
  std::vector<std::string> changes;  ///< what differs from the scene given, a sentence each
};

/// Prints become vertex colours on a grid of `print_cell_m`, and so does noise, as finely as 200
/// 000 triangles a model allow; a leaf's back of its own and projectors are left out; the lens
/// becomes a pinhole of the same focal length if it is none.
/// @throws std::invalid_argument if the scene or the cell is not valid, or a print's face would
/// take more than 4 million cells.
PlainScene plain_scene(const Scene& scene, const TrueView& view, double print_cell_m = 0.0005);

}  // namespace cousin
