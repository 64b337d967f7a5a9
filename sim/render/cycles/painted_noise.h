#pragma once

#include "sim/truth/scene.h"

namespace cousin {

/// A model whose vertices have the colours that a noise texture gives it. Private to
/// sim/render/cycles.
struct PaintedNoise {
  ObjectModel model;  ///< triangles cut into equal ones where they are larger than a cell
  Material
      material;  ///< without noise: the brighter of its two albedos, of which vertices take shares
  double cell_m = 0;  ///< longest edge of triangles that were cut
};

/// Colours of the noise at vertices, linear between. Cells are half the size of the noise's
/// smallest features, or larger where the model would have more than `most_triangles` by cutting.
/// @throws std::invalid_argument if the material has no noise.
PaintedNoise paint_noise(const ObjectModel& model, const Material& material,
                         std::size_t most_triangles = 200'000);

}  // namespace cousin
