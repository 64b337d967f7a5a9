#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "sim/render/cycles/cycles.h"

namespace cousin {

/// Writes a scene's arrays into `folder` and returns what scene.json says of it, without its runs.
/// Private to sim/render/cycles.
nlohmann::json write_cycles_scene(const Scene& scene, const TrueView& view,
                                  const CyclesConfig& config, const std::filesystem::path& folder);

}  // namespace cousin
