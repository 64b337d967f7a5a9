#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "perception/ngp/ngp_rays.h"

namespace cousin {
namespace {

using namespace ngp;

constexpr int kBundle = 32;  ///< pixels of a row that pass the networks together

std::uint8_t to_byte(float value) {
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(value, 0.0F, 1.0F)));
}

}  // namespace

NgpImage render_ngp(const NgpModel& model, const Camera& camera, const Pose& camera_from_world) {
  validate(camera);
  const Image<Eigen::Vector3f> directions = pixel_directions(camera);
  const std::vector<GridLevel> levels = grid_levels(model.config.grid);
  const DenseKernels<float> kernels = dense_kernels();
  const MarchConfig march = march_config(model.config);
  const Pose world_from_camera = inverse(camera_from_world);
  const Eigen::Vector3f origin =
      ((world_from_camera.translation_m - model.volume.centre_in_world_m) / model.volume.side_m)
          .cast<float>();
  const Eigen::Matrix3f turn = world_from_camera.rotation.toRotationMatrix().cast<float>();
  std::array<float, 3> background;
  for (std::size_t c = 0; c < 3; ++c)
    background[c] = static_cast<float>(model.config.background[c]);

  NgpImage image;
  image.color = Image<Rgb8>(camera.width_px, camera.height_px);
  image.depth_m =
      Image<float>(camera.width_px, camera.height_px, std::numeric_limits<float>::quiet_NaN());
  image.alpha = Image<float>(camera.width_px, camera.height_px, 0);
  tbb::enumerable_thread_specific<RayBundle> bundles;
  tbb::parallel_for(0, camera.height_px, [&](int y) {
    RayBundle& bundle = bundles.local();
    std::vector<std::array<float, kHarmonics>> basis;
    for (int first = 0; first < camera.width_px; first += kBundle) {
      const int last = std::min(first + kBundle, camera.width_px);
      bundle.clear();
      basis.clear();
      for (int x = first; x < last; ++x) {
        const Eigen::Vector3f ray = turn * directions(x, y);
        bundle.add(model, march, origin, ray, 0.5F);
        basis.push_back(harmonics(ray));
      }
      bundle.run(model, levels, kernels, basis);
      for (int x = first; x < last; ++x) {
        const auto r = static_cast<std::size_t>(x - first);
        const RaySamples<float> samples = bundle.ray(r);
        const RayColor<float> color = composite(samples, background);
        image.color(x, y) = {to_byte(color.color[0]), to_byte(color.color[1]),
                             to_byte(color.color[2])};
        const float alpha = 1 - color.transmittance;
        image.alpha(x, y) = alpha;
        if (alpha < 0.5F) continue;
        float left = 1, sum = 0;
        for (int i = 0; i < color.used; ++i) {
          const float opacity =
              1 - std::exp(-density_of(samples.log_density[i]) * samples.length[i]);
          sum += left * opacity *
                 bundle.samples[static_cast<std::size_t>(bundle.begin[r] + i)].distance;
          left *= 1 - opacity;
        }
        image.depth_m(x, y) =
            sum / alpha * directions(x, y).z() * static_cast<float>(model.volume.side_m);
      }
    }
  });
  return image;
}

}  // namespace cousin
