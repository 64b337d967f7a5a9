#include "benchmarks/splats/ngp_view.h"

#include <algorithm>
#include <cmath>

namespace cousin {
namespace {

std::uint8_t to_byte(float value) {
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(value, 0.0F, 1.0F)));
}

}  // namespace

NgpView ngp_view(const SplatView& view) {
  const SplatViewLevel& level = view.full;
  NgpView out{level.camera, view.camera_from_world, {}, {}};
  out.color = Image<Rgb8>(level.camera.width_px, level.camera.height_px);
  if (!level.weight.empty()) out.mask = Image<std::uint8_t>(out.color.width(), out.color.height());
  for (int y = 0; y < out.color.height(); ++y) {
    for (int x = 0; x < out.color.width(); ++x) {
      const auto& channel = level.color.channel;
      out.color(x, y) = {to_byte(channel[0](x, y)), to_byte(channel[1](x, y)),
                         to_byte(channel[2](x, y))};
      if (!level.weight.empty()) out.mask(x, y) = level.weight(x, y) >= 0.999F;
    }
  }
  return out;
}

}  // namespace cousin
