#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string_view>

#include "sim/dataset/capture_json.h"

/// Any bytes as rig.json and as scene_camera.json of a rig of one sensor: a capture or
/// std::runtime_error, nothing else.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    cousin::rig_from_json(text, "fuzz");
  } catch (const std::runtime_error&) {
  }
  try {
    cousin::Capture capture;
    capture.rig.resize(1);
    capture.rig[0].camera = {
        .width_px = 64, .height_px = 48, .fx_px = 60, .fy_px = 60, .cx_px = 32, .cy_px = 24};
    cousin::frames_from_json(text, "fuzz", capture);
  } catch (const std::runtime_error&) {
  }
  return 0;
}
