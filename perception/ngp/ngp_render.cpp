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

constexpr int kBundle = 64;        ///< pixels of a row that pass the networks together
constexpr std::size_t kRound = 8;  ///< samples of a ray that do: most rays end before their last

/// A pixel's ray: its samples, and what is known of it so far.
struct PixelRay {
  std::vector<RaySample> samples;
  std::size_t seen = 0;  ///< samples that have passed the networks
  std::array<float, kHarmonics> basis;
  RayColor<float> color;
  float distance_sum = 0;  ///< of the samples by weight, inner coordinates

  bool goes_on() const {
    return seen < samples.size() && color.transmittance > static_cast<float>(kOpaque);
  }
};

/// Scratch of one thread.
struct RowScratch {
  RayBundle bundle;
  FieldBatch<float> batch;
  std::vector<PixelRay> rays;
  std::vector<PixelRay*> together;  ///< rays of the bundle
  std::vector<std::array<float, kHarmonics>> basis;
};

std::uint8_t to_byte(float value) {
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(value, 0.0F, 1.0F)));
}

/// The next samples of all rays that are not yet opaque. False if there are none.
bool shade_round(const NgpModel& model, const std::vector<GridLevel>& levels,
                 const DenseKernels<float>& kernels, RowScratch& scratch) {
  scratch.bundle.clear();
  scratch.together.clear();
  scratch.basis.clear();
  for (PixelRay& ray : scratch.rays) {
    if (!ray.goes_on()) continue;
    const std::span<const RaySample> rest = std::span(ray.samples).subspan(ray.seen);
    scratch.bundle.add(rest.first(std::min(rest.size(), kRound)));
    scratch.together.push_back(&ray);
    scratch.basis.push_back(ray.basis);
  }
  if (scratch.together.empty()) return false;
  scratch.bundle.run(model, levels, kernels, scratch.basis, scratch.batch);
  for (std::size_t r = 0; r < scratch.together.size(); ++r) {
    PixelRay& ray = *scratch.together[r];
    const RaySamples<float> samples = scratch.bundle.ray(scratch.batch, r);
    const RaySample* places = ray.samples.data() + ray.seen;
    composite_on(samples, ray.color,
                 [&](int i, float weight) { ray.distance_sum += weight * places[i].distance; });
    ray.seen += static_cast<std::size_t>(samples.count);
  }
  return true;
}

}  // namespace

NgpImage render_ngp(const NgpModel& model, const Camera& camera, const Pose& camera_from_world) {
  validate(camera);
  if (!camera_from_world.translation_m.allFinite() ||
      !camera_from_world.rotation.coeffs().allFinite())
    throw std::invalid_argument("render_ngp: the pose is not finite");
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
  tbb::enumerable_thread_specific<RowScratch> scratches;
  tbb::parallel_for(0, camera.height_px, [&](int y) {
    RowScratch& scratch = scratches.local();
    for (int first = 0; first < camera.width_px; first += kBundle) {
      scratch.rays.resize(static_cast<std::size_t>(std::min(kBundle, camera.width_px - first)));
      for (std::size_t i = 0; i < scratch.rays.size(); ++i) {
        PixelRay& ray = scratch.rays[i];
        const Eigen::Vector3f& pixel = directions(first + static_cast<int>(i), y);
        const Eigen::Vector3f direction = turn * pixel;
        ray.samples.clear();
        if (direction.squaredNorm() > 0)
          ngp::march(model.volume, model.occupancy, march, origin, direction, 0.5F, ray.samples);
        ray.basis = harmonics(direction);
        ray.seen = 0;
        ray.color = {};
        ray.distance_sum = 0;
      }
      while (shade_round(model, levels, kernels, scratch)) {
      }
      for (std::size_t i = 0; i < scratch.rays.size(); ++i) {
        const int x = first + static_cast<int>(i);
        const PixelRay& ray = scratch.rays[i];
        std::array<std::uint8_t, 3> rgb;
        for (std::size_t c = 0; c < 3; ++c)
          rgb[c] = to_byte(ray.color.color[c] + ray.color.transmittance * background[c]);
        image.color(x, y) = {rgb[0], rgb[1], rgb[2]};
        const float alpha = 1 - ray.color.transmittance;
        image.alpha(x, y) = alpha;
        if (alpha < 0.5F) continue;
        image.depth_m(x, y) = ray.distance_sum / alpha * directions(x, y).z() *
                              static_cast<float>(model.volume.side_m);
      }
    }
  });
  return image;
}

}  // namespace cousin
