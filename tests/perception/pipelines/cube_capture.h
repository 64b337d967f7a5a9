#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "benchmarks/suites/stability/splat_cube.h"
#include "perception/splats/splat_render.h"
#include "sim/types/capture.h"

namespace cousin {

/// Photographs of a cube of Gaussians from twelve places around it, whose poses the rig knows.
inline Capture cube_capture() {
  const SplatModel model = cube_of_splats();
  Capture capture;
  capture.rig.push_back({.camera = cube_camera()});
  constexpr int kViews = 12;
  for (int i = 0; i < kViews; ++i) {
    const double turn = 2 * M_PI * i / kViews;
    Frame frame{.id = i};
    frame.rig_from_world =
        look_at({1.5 * std::cos(turn), 1.5 * std::sin(turn), i % 2 == 0 ? 0.7 : 0.2}, {0, 0, 0});
    const auto planes = render_splats(model, cube_camera(), *frame.rig_from_world).color.channel;
    Image<Rgb8> color(planes[0].width(), planes[0].height());
    for (std::size_t p = 0; p < color.size(); ++p) {
      const auto code = [&](std::size_t k) {
        return static_cast<std::uint8_t>(
            std::lround(255 * std::clamp(planes[k].data()[p], 0.0F, 1.0F)));
      };
      color.data()[p] = {code(0), code(1), code(2)};
    }
    frame.sensors.push_back({.reported = cube_camera(), .color = std::move(color)});
    capture.frames.push_back(std::move(frame));
  }
  return capture;
}

}  // namespace cousin
