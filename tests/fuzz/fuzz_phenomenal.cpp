#include <stdexcept>

#include "sim/dataset/import.h"
#include "tests/fuzz/fuzz_folder.h"

/// Any bytes as the calibration of a turntable cabin: a capture, or std::runtime_error.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cousin;
  fuzz_file("plant/calibration/calibration_camera_side.json", data, size);
  fuzz_file("plant/calibration/calibration_camera_top.json", data, size);
  std::filesystem::create_directories(fuzz_folder() / "plant/bin/side");
  try {
    import_phenomenal(fuzz_folder() / "plant");
  } catch (const std::runtime_error&) {
  }
  return 0;
}
