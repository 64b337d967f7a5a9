#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace cousin {

/// Private to sim/dataset: the pictures of one instant.
struct RgbdFile {
  std::string key;  ///< what the names share
  double time_s = 0;
  std::filesystem::path color;
  std::optional<std::filesystem::path> depth;
  std::optional<std::filesystem::path> pose;  ///< a text of 4 rows of 4 numbers, camera to world
};
struct RgbdFiles {
  std::vector<RgbdFile> frames;
  std::string depth_name;  ///< folder or word of the depth images, for messages
  std::vector<std::string> warnings;
};

/// Colour and depth in folders (rgb, color, colour, image or images beside depth) or beside each
/// other with such words in their names. They belong together by their names; where no two names
/// are alike and all are time stamps, by times at most 0.02 s apart. Poses are NAME.txt in a folder
/// pose/ or poses/, or NAME.pose.txt beside the pictures. A colour image without depth is kept and
/// named in the warnings, a depth image without colour is not kept.
/// @throws std::runtime_error naming the folder and what is missing, or a link that leads out.
RgbdFiles find_rgbd_files(const std::filesystem::path& folder);

}  // namespace cousin
