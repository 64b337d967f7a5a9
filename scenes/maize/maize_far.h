#pragma once

#include "scenes/maize/maize_scene.h"

namespace cousin {

/// Private to scenes/maize: what stands about the plants that are looked at, none of it a specimen.

/// The field goes on to field.far_m in strips of coarse plants that share their meshes. None stands
/// among the specimens, nor near a camera or between one and what it looks at.
/// @param first_material  of maize_materials in the scene
void add_far_rows(Scene& scene, const MaizeSceneConfig& config, int first_material, const Rng& rng);

/// A line of trees where the soil ends.
void add_hedge(Scene& scene, const MaizeConfig::Field& field, const Rng& rng);

}  // namespace cousin
