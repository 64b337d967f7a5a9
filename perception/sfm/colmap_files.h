#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "perception/sfm/sfm_model.h"

namespace cousin {

/// Name of an image in COLMAP's folder: "000012.png". Names are in the order of the images; the
/// ids that COLMAP gives are not.
std::string colmap_image_name(int index);

/// Lines "first second" of names, as matches_importer reads them.
std::string match_list(const std::vector<std::array<int, 2>>& pairs);

/// What mapping left.
struct SfmModels {
  std::vector<SfmModel> models;   ///< that of most images first, of the same number of more points
  std::vector<std::string> bent;  ///< why others are left out: their lens is none
};
/// The models below `sparse` (0, 1, ...). None if there is no such folder.
/// @throws std::runtime_error for a malformed model
SfmModels read_models(const std::filesystem::path& sparse, int images);

}  // namespace cousin
