#pragma once

#include <string>
#include <vector>

#include "benchmarks/metrics/scores.h"
#include "sim/types/seams.h"

namespace cousin {

/// "10 specimens" where all are measured, else "6 of at least 10 objects measured".
std::string specimens_text(const Traits& traits);

/// A line for each object that is not measured: "  seed 7 is not measured: ...".
std::vector<std::string> unmeasured_lines(const Traits& traits);

/// "6 of 10 specimens are measured; ..." of scored specimens, "" where all are.
std::string unmeasured_sentence(const std::vector<SpecimenRow>& specimens);

}  // namespace cousin
