#pragma once

#include "sim/dataset/json_interop.h"
#include "sim/truth/scene.h"

namespace cousin {

/// Materials and lights as truth files hold them. Fields that keep their default are left out,
/// except those that every material has.
Json to_json(const Material& material);
Material read_material(const JsonNode& node);
/// `kind` names the type: sun, sky, lamp, clear_sky, projector, environment. Pictures are arrays of
/// linear r, g, b, row by row.
Json to_json(const Light& light);
Light read_light(const JsonNode& node);

}  // namespace cousin
