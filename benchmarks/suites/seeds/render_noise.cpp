#include "benchmarks/suites/seeds/render_noise.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks/score/image_fidelity.h"
#include "perception/splats/splat_views.h"

namespace cousin {

RenderNoise measure_render_noise(const Simulation& simulation, const PhoneConfig& sensor,
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

namespace {

/// A photograph as models are scored by it: without its lens, and black where `screen` is not zero.
SplatViewLevel straight(const TrueView& view, Image<Rgb8> photograph,
                        const Image<std::uint8_t>& screen) {
  for (std::size_t i = 0; i < screen.size(); ++i) {
    if (screen.data()[i] != 0) photograph.data()[i] = {};
  }
  Capture capture;
  Frame frame;
  frame.sensors.push_back({.reported = view.camera, .color = std::move(photograph)});
  capture.frames.push_back(std::move(frame));
  FramePose pose;
  pose.status = PoseStatus::ok;
  pose.camera = view.camera;
  pose.camera_from_world = view.camera_from_world;
  return std::move(splat_views(capture, {pose}, {}, {}, {screen}).front().full);
}

}  // namespace

NoiseFloor measure_noise_floor(const Simulation& simulation, const GreenConfig& green, int views) {
  const int all = static_cast<int>(simulation.views().size());
  if (views < 1 || views > all)
    throw std::invalid_argument("measure_noise_floor: " + std::to_string(views) + " views of " +
                                std::to_string(all));
  NoiseFloor floor;
  for (int i = 0; i < views; ++i) {
    const auto photograph = [&](std::uint64_t repeat) {
      return simulation.take(i * all / views, {.color = true}, repeat).frame.sensors.front().color;
    };
    const TrueView& view = simulation.views()[static_cast<std::size_t>(i * all / views)];
    const Image<Rgb8> first = photograph(0), second = photograph(1);
    const Image<std::uint8_t> nothing(first.width(), first.height());
    Image<std::uint8_t> screen = without_specks(remove_green(first, green));
    for (std::uint8_t& x : screen) x = x != 0 ? 0 : 255;
    const SplatViewLevel whole = straight(view, first, nothing);
    const SplatViewLevel once = straight(view, first, screen),
                         again = straight(view, second, screen);
    const Image<std::uint8_t> counted = counted_pixels(once.weight);
    Image<std::uint8_t> objects(once.behind.width(), once.behind.height());
    for (std::size_t p = 0; p < objects.size(); ++p) {
      const bool counts = counted.empty() || counted.data()[p] != 0;
      objects.data()[p] = counts && once.behind.data()[p] < 0.5F ? 255 : 0;
    }
    floor.psnr_db += psnr_db(straight(view, second, nothing).color.channel, whole.color.channel,
                             counted_pixels(whole.weight)) /
                     views;
    floor.psnr_object_db += psnr_db(again.color.channel, once.color.channel, objects) / views;
    floor.psnr_whole_db += psnr_db(again.color.channel, once.color.channel, counted) / views;
  }
  return floor;
}

}  // namespace cousin
