#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace cousin {

/// Writes beside the final name, flushes, checks every error (a full disk too), then renames.
/// Parent folders are made. @throws std::runtime_error naming the file and the system's reason;
/// nothing is left then.
void write_file(const std::filesystem::path& file, std::string_view bytes);

/// Whole file. @throws std::runtime_error if it is missing, not a regular file, or above
/// `limit_bytes`.
std::string read_file(const std::filesystem::path& file,
                      std::size_t limit_bytes = std::size_t{1} << 30);

/// Whether a file name is one that a writer uses before it renames ("." first, ".part" or ".tmp"
/// last). A killed run may leave such files; manifests skip them.
bool is_temporary_name(std::string_view file_name);

/// `root / relative` for a path that a file or a user gave, without symbolic links. The last
/// component may be missing.
/// @throws std::runtime_error naming both if `relative` is absolute, has "..", or leads outside
/// `root` by a link.
std::filesystem::path resolve_inside(const std::filesystem::path& root,
                                     const std::filesystem::path& relative);

}  // namespace cousin
