#pragma once

#include "scenes/maize/maize_plant.h"
#include "sim/truth/scene.h"

namespace cousin {

/// Private to scenes/maize. The field's surface: clods whose mesh is finest in the middle, as the
/// scene's next instance.
void add_soil(Scene& scene, const MaizeConfig::Field& field, Rng rng);

/// Clods that lie loose on that surface, denser in the middle, as one instance of its material; the
/// soil is the scene's first. @param rng  the one that add_soil had
void add_clods(Scene& scene, const MaizeConfig::Field& field, Rng rng);

/// Straws of last year's leaves and bits of its stalks that lie on that surface, denser in the
/// middle, as one instance. @param rng  the one that add_soil had
void add_residues(Scene& scene, const MaizeConfig::Field& field, Rng rng);

}  // namespace cousin
