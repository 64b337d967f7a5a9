#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "benchmarks/score/scores.h"

namespace cousin {

/// Trainings on a set of posed photographs, to about 40 and 180 s of wall time on two quiet cores:
/// mean PSNR over the held-out views (10 log10(1 / MSE), images clamped to 0..1), seconds, memory.
/// @param quick  the first only
std::vector<ScoreRow> splat_training_rows(const std::filesystem::path& photographs,
                                          std::uint64_t seed, bool quick);

inline constexpr const char* kSplatChoices = "choices";

/// The same photographs and the first goal's steps and Gaussians, with one technique changed at a
/// time: growth of each kind, coarse to fine, cadence, loss, low pass, rates. A case a choice, with
/// the seconds that it took: what each is worth.
std::vector<ScoreRow> splat_choice_rows(const std::filesystem::path& photographs,
                                        std::uint64_t seed, bool quick);

}  // namespace cousin
