#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string_view>

#include "benchmarks/tools/fit_sensor/recordings.h"

/// Any bytes as recordings.toml beside a few folders: an index, or std::runtime_error, nothing
/// else.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    const cousin::Recordings r = cousin::recordings_from_index(
        {"dark", "flat_1", "wall_0.60m", "wall_a", "wall_1.2m"}, text, "fuzz");
    for (const cousin::WallFolder& wall : r.walls) {
      if (!(wall.distance_m >= 0.01 && wall.distance_m <= 100)) __builtin_trap();
    }
  } catch (const std::runtime_error&) {
  }
  return 0;
}
