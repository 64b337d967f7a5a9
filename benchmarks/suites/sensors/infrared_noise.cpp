#include "benchmarks/suites/sensors/infrared_noise.h"

#include <algorithm>
#include <vector>

#include "sim/render/ray_scene.h"
#include "sim/sensors/optics.h"

namespace cousin {
namespace {

/// Along rows (step 1, 0) or columns (0, 1); borders repeat.
Image<float> blurred(const Image<float>& image, const std::vector<float>& weights, int step_x,
                     int step_y) {
  const int radius = static_cast<int>(weights.size() / 2);
  Image<float> out(image.width(), image.height(), 0.0F);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      for (int k = -radius; k <= radius; ++k) {
        out(x, y) += weights[static_cast<std::size_t>(k + radius)] *
                     image(std::clamp(x + k * step_x, 0, image.width() - 1),
                           std::clamp(y + k * step_y, 0, image.height() - 1));
      }
    }
  }
  return out;
}

}  // namespace

double render_noise_share(const WallCase& wall, const ActiveStereoConfig& config,
                          const ActiveStereoUnit& unit, const Rng& rng) {
  constexpr int kFiner = 36;
  const WallScene scene = make_wall(wall);
  const RayScene rays(scene.scene);
  const std::vector<float> weights = gaussian_weights(config.imager.blur_sigma_px);
  const auto render = [&](int factor) {
    ActiveStereoConfig still = config;
    still.infrared.speckle_contrast = 0;
    still.infrared.pixel_samples *= factor;
    const InfraredPair pair =
        render_infrared_pair(rays, scene.scene, scene.rig_from_world, still, unit,
                             rng.fork("render").fork(static_cast<std::uint64_t>(factor)));
    return blurred(blurred(pair.left.radiance, weights, 1, 0), weights, 0, 1);
  };
  const Image<float> a = render(1), fine = render(kFiner);
  const InfraredExposure exposure = auto_exposure(fine, config.imager);
  const double electrons = config.imager.electrons_at_unit_radiance * exposure.share;
  double squares = 0, sensor = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double difference = electrons * static_cast<double>(a.data()[i] - fine.data()[i]);
    squares += difference * difference;
    sensor += electrons * static_cast<double>(fine.data()[i]) +
              config.imager.read_noise_e * config.imager.read_noise_e;
  }
  return squares / sensor;
}

}  // namespace cousin
