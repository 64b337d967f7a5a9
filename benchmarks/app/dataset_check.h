#pragma once

#include <filesystem>

#include "sim/dataset/manifest.h"

namespace cousin {

/// A scene's cameras and truth must be what one run wrote: an estimate of another run's pictures
/// would be scored without a word. The pictures themselves are not read here; `cousin verify` does.
/// @throws std::runtime_error naming the file that the manifest lists with other bytes
void check_unchanged(const std::filesystem::path& dataset, const Manifest& manifest,
                     const std::filesystem::path& scene);

}  // namespace cousin
