#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/dataset/camera_pair.h"

namespace cousin {

/// Private to sim/dataset: which of a folder's files is the calibration of its pictures.

/// Text of a calibration, of at most 16 MiB.
std::string read_calibration(const std::filesystem::path& file);

/// The files of `folder` that have one of the names. A name may be a path below the folder.
/// @throws std::runtime_error naming a link that leads out.
std::vector<std::filesystem::path> files_there(const std::filesystem::path& folder,
                                               const std::vector<std::string>& names);

/// "STEM.yaml", "STEM.yml" and "STEM.json" of each stem.
std::vector<std::string> calibration_names(const std::vector<std::string>& stems);

/// The one file of that stem and of a calibration's ending; nothing if there is none.
/// @throws std::runtime_error if there are two.
std::optional<std::filesystem::path> calibration_there(const std::filesystem::path& folder,
                                                       const std::string& stem);

/// The pair of a rig.json of ours: its first sensor and its second.
CameraPair pair_of_rig(std::string_view text, const std::string& name);

/// The two cameras of one file of any of the formats of camera_pair.h, or of Kalibr's camchain;
/// nothing where it is a file of one camera.
/// @param kitti_numbers  of the folders image_2 and image_3; -1 where they say none.
std::optional<CameraPair> pair_of_file(const std::filesystem::path& file, const PairSizes& sizes,
                                       const std::array<int, 2>& kitti_numbers);

}  // namespace cousin
