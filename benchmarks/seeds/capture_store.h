#pragma once

#include <cstdint>
#include <filesystem>

#include "benchmarks/seeds/simulate.h"

namespace cousin {

/// simulate_seeds with a memory: a capture that an earlier run left in `folder` is read, with its
/// truth and the seconds that it took; else it is rendered and written, under its final name only
/// when whole. An empty `folder` renders and keeps nothing.
///
/// What decides a capture names its subfolder: program version, configuration of scene, rig and
/// renderer, seed, scene index and truth passes. How it is measured does not, so a change of the
/// pipeline measures the same images again. A change of the program's rendering code within one
/// version is not seen: remove the folder then.
/// @throws std::runtime_error naming the file if a stored capture is damaged or cannot be written.
SimulatedRun stored_seeds(const std::filesystem::path& folder, const SeedsRunConfig& config,
                          std::uint64_t seed, int scene_index, const TruthNeeds& needs,
                          const Progress& progress = {});

}  // namespace cousin
