#pragma once

#include <string>
#include <vector>

#include "benchmarks/score/scores.h"
#include "sim/types/seams.h"

namespace cousin {

/// "10 specimens" where all are measured, else "6 of at least 10 objects measured".
std::string specimens_text(const Traits& traits);

/// "specimen 7", or of what one image shows "box 7 of view 3".
std::string name_of(const SpecimenTraits& traits);

/// A line for each object that is not measured: "  specimen 7 is not measured: ...".
std::vector<std::string> unmeasured_lines(const Traits& traits);

/// "6 of 10 specimens are measured; ..." of scored specimens, "" where all are.
std::string unmeasured_sentence(const std::vector<SpecimenRow>& specimens);

}  // namespace cousin
