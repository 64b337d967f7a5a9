#include "benchmarks/seeds/render_noise.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "benchmarks/metrics/image_fidelity.h"

namespace cousin {

RenderNoise measure_render_noise(const SeedsSimulation& simulation, const PhoneConfig& sensor,
                                 int frame) {
  const Image<Rgbf> a = simulation.radiance(frame, 1);
  const Image<Rgbf> b = simulation.radiance(frame, 2);
  const double electrons = electrons_per_radiance(sensor, a);
  RenderNoise noise;
  double ratio_sum = 0, variance_sum = 0, sensor_sum = 0;
  std::vector<float> ratios;
  ratios.reserve(3 * a.size());
  for (int y = 0; y < a.height(); ++y) {
    for (int x = 0; x < a.width(); ++x) {
      const Rgbf& p = a(x, y);
      const Rgbf& q = b(x, y);
      for (const auto& [u, v] : {std::pair{p.r, q.r}, std::pair{p.g, q.g}, std::pair{p.b, q.b}}) {
        const double variance = 0.5 * (u - v) * (u - v);
        const double limit = sensor_variance(sensor, 0.5 * (u + v), electrons);
        ratio_sum += variance / limit;
        variance_sum += variance;
        sensor_sum += limit;
        ratios.push_back(static_cast<float>(variance / limit));
      }
      ++noise.pixels;
    }
  }
  const double count = static_cast<double>(ratios.size());
  noise.mean_ratio = ratio_sum / count;
  noise.ratio_of_means = variance_sum / sensor_sum;
  const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
  std::nth_element(ratios.begin(), middle, ratios.end());
  noise.median_ratio = *middle;
  return noise;
}

NoiseFloor measure_noise_floor(const SeedsSimulation& simulation, const GreenConfig& green,
                               int views) {
  const int all = static_cast<int>(simulation.views().size());
  if (views < 1 || views > all)
    throw std::invalid_argument("measure_noise_floor: " + std::to_string(views) + " views of " +
                                std::to_string(all));
  NoiseFloor floor;
  for (int i = 0; i < views; ++i) {
    const auto photograph = [&](std::uint64_t repeat) {
      return simulation.take(i * all / views, {.color = true}, repeat).frame.sensors.front().color;
    };
    const Image<Rgb8> first = photograph(0);
    const FidelityPlanes once = fidelity_planes(first), again = fidelity_planes(photograph(1));
    const Image<std::uint8_t> kept = without_specks(remove_green(first, green));
    const auto objects = std::count_if(kept.begin(), kept.end(), [](auto x) { return x != 0; });
    const double object_db = psnr_db(again, once, kept);
    floor.psnr_db += psnr_db(again, once) / views;
    floor.psnr_object_db += object_db / views;
    floor.psnr_whole_db += (object_db - 10 * std::log10(static_cast<double>(objects) /
                                                        static_cast<double>(kept.size()))) /
                           views;
  }
  return floor;
}

}  // namespace cousin
