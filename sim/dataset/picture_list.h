#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace cousin {

/// Private to sim/dataset: pictures that lie in a folder.
struct PictureList {
  std::vector<std::filesystem::path> files;  ///< sorted by name
  std::string not_read;  ///< "3 pictures are not read, as a.heic: ..."; "" = there are none
};

/// @param endings  that are read, in lower case, as ".png". Names that begin with "." are passed
/// over. @throws std::runtime_error naming the folder, a name that is not UTF-8, a link that leads
/// out, or more than a million files.
PictureList list_pictures(const std::filesystem::path& folder,
                          const std::vector<std::string_view>& endings);

std::string lower_case(std::string_view text);

}  // namespace cousin
