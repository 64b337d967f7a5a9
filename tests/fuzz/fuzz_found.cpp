#include <stdexcept>

#include "benchmarks/tools/detections/found_files.h"
#include "tests/fuzz/fuzz_folder.h"

/// Any bytes as COCO results and as a file of YOLO's: detections or std::runtime_error, nothing
/// else.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cousin;
  static const PictureNames kNames = {{"1", {0, 40, 30}}, {"a", {0, 40, 30}}};
  try {
    read_coco_results(fuzz_file("found.json", data, size), kNames);
  } catch (const std::runtime_error&) {
  }
  try {
    read_yolo_results(fuzz_file("labels/a.txt", data, size).parent_path(), kNames);
  } catch (const std::runtime_error&) {
  }
  return 0;
}
