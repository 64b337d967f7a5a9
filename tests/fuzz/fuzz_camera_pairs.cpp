#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string_view>

#include "sim/dataset/camera_pair.h"
#include "sim/dataset/camera_values.h"
#include "sim/dataset/matrix_pose.h"
#include "sim/dataset/rgbd_intrinsics.h"

namespace {

template <class Read>
void attempt(const Read& read) {
  try {
    read();
  } catch (const std::runtime_error&) {
  }
}

}  // namespace

/// Any bytes as calibrations of two cameras and as a pose: values, or std::runtime_error, nothing
/// else.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cousin;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const PairSizes sizes = {ImageSize{20, 12}, ImageSize{20, 12}};
  for (const char* name : {"fuzz.json", "fuzz.yaml", "fuzz.txt"})
    attempt([&] { rgbd_cameras_of_text(text, name, sizes, 0.001); });
  for (const char* name : {"fuzz.json", "fuzz.yaml"}) {
    attempt([&] { pair_of_values(values_of_file(text, name), sizes); });
    attempt([&] { pair_of_two(values_of_file(text, name), values_of_file(text, name), sizes); });
  }
  attempt([&] { pair_of_middlebury(text, "fuzz"); });
  attempt([&] { pair_of_kitti(text, "fuzz", {2, 3}, sizes); });
  attempt([&] { pose_of_text(text, "fuzz"); });
  return 0;
}
