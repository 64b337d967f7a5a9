#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "sim/types/image.h"

namespace cousin {

/// Passes of a reference image, each an EXR in `folder`: NAME_HASH_0.exr, NAME_HASH_1.exr, ...
/// A pass that is there is read; another is rendered and written whole, so that a run that was
/// stopped goes on with the next pass.
/// @param key     all that decides the passes; its SHA-256 is part of the files' names.
/// @param render  makes pass i.
/// @throws std::runtime_error naming a file that cannot be read or written or has not the first
/// one's size.
std::vector<Image<Rgbf>> reference_passes(const std::filesystem::path& folder,
                                          const std::string& name, const std::string& key,
                                          int passes,
                                          const std::function<Image<Rgbf>(int pass)>& render);

/// SHA-256 of an image's size and bytes: of one sample a pixel it tells whether a renderer or its
/// scene has changed.
std::string image_hash(const Image<Rgbf>& image);

}  // namespace cousin
