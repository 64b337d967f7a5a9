#include "benchmarks/suites/splats/ngp_view.h"

#include "benchmarks/score/image_fidelity.h"

namespace cousin {
NgpView ngp_view(const SplatView& view) {
  const SplatViewLevel& level = view.full;
  NgpView out{level.camera, view.camera_from_world, {}, {}};
  out.color = rgb_of(level.color.channel);
  if (!level.weight.empty()) {
    out.mask = Image<std::uint8_t>(out.color.width(), out.color.height());
    for (std::size_t i = 0; i < out.mask.size(); ++i)
      out.mask.data()[i] = level.weight.data()[i] >= 0.999F;
  }
  return out;
}

}  // namespace cousin
