#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "benchmarks/metrics/scores.h"

namespace cousin {

/// Gaussian splatting: core time of each blended pair, wall time of a training step, and held-out
/// PSNR against wall time on a set of posed photographs. Limits are in the metrics' names; those of
/// time hold on two quiet cores.
/// @param photographs  a folder with transforms.json, points.ply and split.txt (a line "FILE train"
/// or "FILE test" for each view); absent gives rows with status not_solved
/// @param fox  a transforms.json, every eighth view of which is held out; absent likewise
/// @param chair  a folder of photographs without poses and the camera's intrinsics; absent likewise
/// @param quick  without the long training, the fox and the chair
ScoreFile splats_suite(const std::filesystem::path& photographs, const std::filesystem::path& fox,
                       const std::filesystem::path& chair, std::uint64_t seed, bool quick,
                       const std::function<void(const std::string&, int, int)>& progress = {});

}  // namespace cousin
