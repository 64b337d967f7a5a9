#include <stdexcept>

#include "sim/geometry/mesh_io.h"
#include "tests/fuzz/fuzz_folder.h"

/// Any bytes as a cloud's PLY: points or std::runtime_error, nothing else; what was read can be
/// written and read again.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cousin;
  Clusters clusters;
  try {
    clusters = read_cloud_ply(fuzz_file("cloud.ply", data, size));
  } catch (const std::runtime_error&) {
    return 0;
  }
  write_ply(fuzz_folder() / "again.ply", clusters.cloud);
  read_cloud_ply(fuzz_folder() / "again.ply");
  return 0;
}
