#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

namespace cousin {

/// Most that one input may take in memory unless `set_memory_limit` says otherwise: 8 GiB, or half
/// of what this process may have (of the machine, of its container, by ulimit -v) if that is less.
std::uint64_t default_memory_limit_bytes();

/// Most that what is read from one file, or from all files of one capture, may take in memory.
std::uint64_t memory_limit_bytes();
/// For the whole process; the program does it once, before any work. 0 = the default.
void set_memory_limit(std::uint64_t bytes);

/// To be called with what a file asks for before memory is taken for it.
/// @param file   the file or folder that asks, named in the message.
/// @param bytes  in all; a sum that does not fit into 64 bits is to be given as the largest number.
/// @param what   what would be made: "300 images", "the mesh of its surface".
/// @throws std::runtime_error that names all of these and the limit, if it is exceeded.
void check_memory(const std::filesystem::path& file, std::uint64_t bytes, std::string_view what);

/// a * b; the largest number where that does not fit into 64 bits.
std::uint64_t bytes_times(std::uint64_t a, std::uint64_t b);
/// a + b, likewise.
std::uint64_t bytes_plus(std::uint64_t a, std::uint64_t b);

}  // namespace cousin
