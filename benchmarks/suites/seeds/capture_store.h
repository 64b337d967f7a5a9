#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "benchmarks/loop/simulate.h"

namespace cousin {

/// Hashes of the tables that the program has built in: what they hold decides captures, and no
/// configuration tells it.
std::string built_in_tables();

/// simulate with a memory: a capture that an earlier run left in `folder` is read with its
/// truth, and then there are no timings; else it is rendered and written, under its final name only
/// when whole. Several processes may share a folder. An empty `folder` renders and keeps nothing.
///
/// What decides a capture names its subfolder: program version, configuration of scene, rig and
/// renderer, the cultivars' and setting's data, a user's mesh, seed, scene index and truth passes.
/// How it is measured does not, so a change of the pipeline measures the same images again (the
/// stored truth/config.toml tells the pipeline of the run that rendered). A change of the
/// simulator's code within one version is not seen: remove the folder then.
/// @throws std::runtime_error naming folder or file if a stored capture is damaged, lacks views or
/// truth, or cannot be written.
SimulatedRun stored_seeds(const std::filesystem::path& folder, const RunConfig& config,
                          std::uint64_t seed, int scene_index, const TruthNeeds& needs,
                          const Progress& progress = {});

}  // namespace cousin
