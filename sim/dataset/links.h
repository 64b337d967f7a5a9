#pragma once

#include <filesystem>

namespace cousin {

/// Somebody else's folder must not make us read, or put into a page, what lies elsewhere.
/// @param folder  that was given; it may be a link itself.
/// @param part    a file or folder in it, which may be absent; all that it holds is looked at, but
///                folders named `without`.
/// @throws std::runtime_error naming a symbolic link that leads out of `folder`, and where to.
void refuse_links_out(const std::filesystem::path& folder, const std::filesystem::path& part,
                      const std::filesystem::path& without = {});

}  // namespace cousin
