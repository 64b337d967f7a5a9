#include <stdexcept>

#include "sim/dataset/manifest.h"
#include "tests/fuzz/fuzz_folder.h"

/// Any bytes as manifest.json: a manifest that can be verified, or std::runtime_error, nothing
/// else.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cousin;
  fuzz_file("manifest.json", data, size);
  try {
    read_manifest(fuzz_folder());
    verify(fuzz_folder());
  } catch (const std::runtime_error&) {
  }
  return 0;
}
