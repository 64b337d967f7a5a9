#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace cousin {

/// What read_user_mesh passes over in a file, in words that name it: textures, materials, metals,
/// bytes behind the last triangle. The file is read for it. @throws as read_user_mesh.
std::vector<std::string> user_mesh_warnings(const std::filesystem::path& file);

}  // namespace cousin
