#include <stdexcept>

#include "sim/dataset/import.h"
#include "tests/fuzz/fuzz_folder.h"

/// Any bytes as a carving (.npz): voxels or std::runtime_error, nothing else.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cousin;
  try {
    read_phenomenal_voxels(fuzz_file("voxels.npz", data, size));
  } catch (const std::runtime_error&) {
  }
  return 0;
}
