#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "benchmarks/score/scores.h"

namespace cousin {

/// Held-out PSNR of Gaussians and of the radiance field (ngp.h) over wall time, on the same
/// photographs: those of a folder with a split, the fox of instant-ngp at 480 px and the chair of
/// BoofCV, which structure from motion places; of both every eighth view is held out.
/// @param quick  fewer steps, and neither fox nor chair
std::vector<ScoreRow> field_rows(const std::filesystem::path& split_set,
                                 const std::filesystem::path& fox,
                                 const std::filesystem::path& chair, std::uint64_t seed,
                                 bool quick);

}  // namespace cousin
