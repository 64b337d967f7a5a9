#pragma once

#include <cstdint>
#include <vector>

#include "benchmarks/score/scores.h"
#include "benchmarks/suites/seedlings/field_training.h"

namespace cousin {

/// How near the surfaces of a model of Gaussians are to the tray's, in metres, of surface that two
/// of the views trained on at least could see: rows cloud_seen.* of all and specimens.cloud_seen.*
/// of plants alone (score_views.h), of the depths that those views show, fused, as method "...,
/// depths"; and as "..., centres" of the Gaussians' centres, the cloud of the Seeds paper. Poses
/// are exact.
/// @param base  labels; `method` is the training's
std::vector<ScoreRow> shape_rows(const SeedlingsSample& sample, std::uint64_t seed,
                                 const SplatModel& splats, const FieldViews& views,
                                 const ScoreRow& base);

}  // namespace cousin
