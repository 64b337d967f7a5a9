#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "benchmarks/metrics/scores.h"

namespace cousin {

/// Held-out PSNR of Gaussians and of the radiance field (ngp.h) over wall time, on the same
/// photographs: those of a folder with a split, and the fox of instant-ngp, every eighth view held
/// out, at 480 px. @param quick  fewer steps, and no fox
std::vector<ScoreRow> field_rows(const std::filesystem::path& split_set,
                                 const std::filesystem::path& fox, std::uint64_t seed, bool quick);

}  // namespace cousin
