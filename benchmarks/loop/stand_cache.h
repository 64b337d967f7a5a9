#pragma once

#include <cstdint>
#include <filesystem>

#include "scenes/apples/apples_scene.h"
#include "scenes/strawberries/strawberries_scene.h"

namespace cousin {

/// Stretch number `plant` of a run at rest: from the folder config.cache if it is kept there, else
/// settled, and kept there if a folder is named. The same bytes either way.
/// @throws std::runtime_error naming the file, what in it is wrong and the limit if it is damaged
/// or of another stretch; and as settle_stand.
StandRest stand_at_rest(const StrawberriesSceneConfig& config, std::uint64_t seed, int plant);
/// The stream of a stretch: what grows on it.
Rng stretch_rng(std::uint64_t seed, int plant);
/// The file that keeps it: named by a hash of all that decides it.
std::filesystem::path stand_file(const StrawberriesSceneConfig& config, std::uint64_t seed,
                                 int plant);

/// The same for the branches of an apple scene's tree, scene number `index` of a run.
BranchSettler tree_settler(const ApplesSceneConfig& config, std::uint64_t seed, int index);
std::filesystem::path tree_file(const ApplesSceneConfig& config, std::uint64_t seed, int index);

}  // namespace cousin
