#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/render/truth_pass.h"
#include "sim/sensors/device.h"

namespace cousin {

/// What there is to know: disparity of rigs with two cameras, and of a depth sensor its noise-free
/// depth and why pixels have none, where its depth is taken.
TruthNeeds truth_there_is(const DeviceConfig& rig, const Streams& streams);
/// What a dataset holds if nobody chooses: visibility, and what is known of the depth taken.
TruthNeeds default_truth(const Streams& streams);

/// Truth images by the names that `--truth` takes: a list such as "depth,part", "all" or "none".
/// @throws std::invalid_argument naming the word that is none of them, and those that exist, or
/// that is not in `there_is`.
TruthNeeds truth_needs_from_string(std::string_view text,
                                   const TruthNeeds& there_is = truth_there_is(PhoneConfig{},
                                                                               {.color = true}));

/// What `cousin export --format` needs of a dataset, for coco, yolo and bop, beside `base`.
/// @throws std::invalid_argument naming the format and those that need truth
TruthNeeds truth_needs_for(std::string_view format, TruthNeeds base);

/// Every name that `--truth` takes, in a fixed order, and whether `needs` has it.
std::vector<std::pair<std::string, bool>> truth_names(const TruthNeeds& needs);

/// The names in a fixed order, "none" for none: equal choices give equal texts.
std::string to_string(const TruthNeeds& needs);

}  // namespace cousin
