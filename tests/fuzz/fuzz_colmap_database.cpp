#include <stdexcept>

#include "perception/sfm/colmap_database.h"
#include "tests/fuzz/fuzz_folder.h"

/// Any bytes as COLMAP's database: what it says of three images, or a complaint; nothing is thrown.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cousin;
  const ColmapDatabase database = read_colmap_database(fuzz_file("database.db", data, size), 3);
  if (!database.complaint.empty() && !database.images.empty()) __builtin_trap();
  return 0;
}
