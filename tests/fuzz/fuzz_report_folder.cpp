#include <stdexcept>

#include "benchmarks/loop/report_scene.h"
#include "tests/fuzz/fuzz_folder.h"

/// Any bytes as the list of a report's pictures: scenes, or std::runtime_error, nothing else.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cousin;
  fuzz_file("report/scene/scene.json", data, size);
  try {
    read_report_scenes(fuzz_folder() / "report", {});
  } catch (const std::runtime_error&) {
  }
  return 0;
}
