#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "sim/dataset/manifest.h"

namespace cousin {

/// verify() that says how far it is. @param progress  called as files, or scenes of a real capture,
/// are done; from one thread at a time
std::vector<VerifyProblem> verify(const std::filesystem::path& dataset,
                                  const std::function<void(int done, int total)>& progress);

}  // namespace cousin
