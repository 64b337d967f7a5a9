#pragma once

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

namespace cousin {

/// A folder for readers that take a file's name; one a process, in memory where there is /dev/shm.
inline std::filesystem::path fuzz_folder() {
  static const std::filesystem::path folder = [] {
    const std::filesystem::path shm = "/dev/shm";
    const std::filesystem::path base =
        std::filesystem::is_directory(shm) ? shm : std::filesystem::temp_directory_path();
    const auto own = base / ("cousin_fuzz_" + std::to_string(getpid()));
    std::filesystem::create_directories(own);
    return own;
  }();
  return folder;
}

/// The input as a file of that name in the folder.
inline std::filesystem::path fuzz_file(const std::string& name, const std::uint8_t* data,
                                       std::size_t size) {
  const std::filesystem::path file = fuzz_folder() / name;
  std::filesystem::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  return file;
}

}  // namespace cousin
