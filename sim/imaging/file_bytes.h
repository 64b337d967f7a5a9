#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace cousin::imaging {

/// Private to sim/imaging: whole files in and out, so that every codec works on memory.
std::vector<std::uint8_t> read_bytes(const std::filesystem::path& file);

/// Writes beside the final name, flushes to the disk, then renames; whatever fails, nothing new
/// stays.
/// @throws std::runtime_error naming the file and the system's reason.
void replace_file(const std::filesystem::path& file, std::span<const std::uint8_t> bytes);

/// @throws std::runtime_error "name: W x H pixels; ..." if a side is outside 1..65535 or the area
/// above 2^28.
void check_image_size(const std::string& name, std::uint64_t width, std::uint64_t height);

}  // namespace cousin::imaging
