#include <stdexcept>

#include "perception/splats/splat_ply.h"
#include "tests/fuzz/fuzz_folder.h"

/// Any bytes as splats: a model or std::runtime_error, nothing else; what was read can be written
/// and read again, and loses nothing.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cousin;
  const SplatPlyConfig config{.most_splats = 100'000};
  SplatFile file;
  try {
    file = read_splat_ply(fuzz_file("splats.ply", data, size), config);
  } catch (const std::runtime_error&) {
    return 0;
  }
  write_splat_ply(fuzz_folder() / "again.ply", file.model);
  const SplatFile again = read_splat_ply(fuzz_folder() / "again.ply", config);
  if (again.model.splats.size() != file.model.splats.size() || again.not_finite > 0 ||
      again.zero_rotations > 0 || again.model.origin_in_world_m != file.model.origin_in_world_m) {
    throw std::logic_error("splats that were read are not read again");
  }
  return 0;
}
