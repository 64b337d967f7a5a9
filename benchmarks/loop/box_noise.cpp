#include "benchmarks/loop/box_noise.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "sim/config/limits.h"
#include "sim/types/rng.h"

namespace cousin {
namespace {

int seen_px(const DetectedBox& box) {
  return static_cast<int>(std::count_if(box.mask.begin(), box.mask.end(),
                                        [](std::uint8_t inside) { return inside != 0; }));
}

/// Distance of a pixel from the nearest one of the other kind, up to `most` pixels.
double edge_distance_px(const Image<std::uint8_t>& mask, int x, int y, int most) {
  const auto inside = [&](int u, int v) { return mask.contains(u, v) && mask(u, v) != 0; };
  const bool own = inside(x, y);
  double nearest = most + 1;
  for (int v = -most; v <= most; ++v) {
    for (int u = -most; u <= most; ++u) {
      if (inside(x + u, y + v) != own) nearest = std::min(nearest, std::hypot(u, v));
    }
  }
  return nearest;
}

/// The box with what of its image a mask covers; false where that is nothing.
bool set_mask(const Image<std::uint8_t>& mask, const Eigen::Vector2i& at_px, DetectedBox& box) {
  Eigen::Vector2i low(mask.width(), mask.height()), high(-1, -1);
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      const Eigen::Vector2i in_image = at_px + Eigen::Vector2i(x, y);
      if (mask(x, y) == 0 || (in_image.array() < 0).any() ||
          (in_image.array() >= box.image_px.array()).any())
        continue;
      low = low.cwiseMin(Eigen::Vector2i(x, y));
      high = high.cwiseMax(Eigen::Vector2i(x, y));
    }
  }
  if (high.x() < 0) return false;
  const Eigen::Vector2i size = high - low + Eigen::Vector2i::Ones();
  box.mask = Image<std::uint8_t>(size.x(), size.y());
  for (int y = 0; y < size.y(); ++y) {
    for (int x = 0; x < size.x(); ++x) box.mask(x, y) = mask(low.x() + x, low.y() + y);
  }
  box.mask_at_px = at_px + low;
  box.low_px = box.mask_at_px.cast<double>().array() - 0.5;
  box.high_px = (box.mask_at_px + size).cast<double>().array() - 0.5;
  return true;
}

/// Moves a mask's edge outward; inward where it is negative.
bool grow(double by_px, DetectedBox& box) {
  if (by_px == 0) return true;
  const int margin = static_cast<int>(std::ceil(std::abs(by_px)));
  Image<std::uint8_t> grown(box.mask.width() + 2 * margin, box.mask.height() + 2 * margin);
  for (int y = 0; y < grown.height(); ++y) {
    for (int x = 0; x < grown.width(); ++x) {
      const int u = x - margin, v = y - margin;
      const bool inside = box.mask.contains(u, v) && box.mask(u, v) != 0;
      // The edge is half a pixel from the middle of the first pixel beyond it.
      const double away_px = edge_distance_px(box.mask, u, v, margin) - 0.5;
      grown(x, y) = inside ? (by_px > 0 || away_px >= -by_px ? 255 : 0)
                           : (by_px > 0 && away_px < by_px ? 255 : 0);
    }
  }
  return set_mask(grown, box.mask_at_px - Eigen::Vector2i(margin, margin), box);
}

/// A disc with the pixels of `like`, somewhere in its image.
bool false_box(const DetectedBox& like, Rng& rng, DetectedBox& box) {
  box = like;
  box.instance = -1;
  const double radius_px = std::sqrt(seen_px(like) / std::numbers::pi);
  const Eigen::Vector2d at(uniform(rng, 0, like.image_px.x() - 1.0),
                           uniform(rng, 0, like.image_px.y() - 1.0));
  const int half = static_cast<int>(std::ceil(radius_px));
  const Eigen::Vector2i middle(static_cast<int>(std::lround(at.x())),
                               static_cast<int>(std::lround(at.y())));
  Image<std::uint8_t> disc(2 * half + 1, 2 * half + 1);
  for (int y = 0; y < disc.height(); ++y) {
    for (int x = 0; x < disc.width(); ++x)
      disc(x, y) = std::hypot(x - half, y - half) <= radius_px ? 255 : 0;
  }
  return set_mask(disc, middle - Eigen::Vector2i(half, half), box);
}

}  // namespace

Fields fields(BoxNoiseConfig& c) {
  return {{"missed", &c.missed, "share of true boxes that are not found", 0, 1},
          {"half_px", &c.half_px, "pixels in sight of which half are found; 0: all", 0, 1e6},
          {"edge_sigma_px", &c.edge_sigma_px, "a mask is larger or smaller all round", 0, 10},
          {"false_boxes", &c.false_boxes, "mean count in an image of boxes of nothing", 0, 1000}};
}

void validate(const BoxNoiseConfig& config) {
  BoxNoiseConfig copy = config;
  check_limits(fields(copy), "boxes");
}

bool takes_boxes(const PipelineRow& row) {
  return std::find(row.from_outside.begin(), row.from_outside.end(), "boxes") !=
         row.from_outside.end();
}

Boxes detected_boxes(const Boxes& truth, const BoxNoiseConfig& config, std::uint64_t seed) {
  validate(config);
  const Rng rng = Rng(seed).fork("boxes");
  Boxes found;
  std::map<std::pair<int, int>, std::vector<const DetectedBox*>> of_image;
  for (const DetectedBox& box : truth) {
    of_image[{box.frame, box.sensor}].push_back(&box);
    Rng own = rng.fork(static_cast<std::uint64_t>(box.id));
    const double chance = uniform(own),
                 by_px = config.edge_sigma_px * std::clamp(normal(own), -3.0, 3.0);
    const double over = config.half_px / std::max(1, seen_px(box));
    if (chance >= (1 - config.missed) / (1 + over * over)) continue;
    DetectedBox one = box;
    if (grow(by_px, one)) found.push_back(std::move(one));
  }
  for (const auto& [image, boxes] : of_image) {
    Rng own = rng.fork("false")
                  .fork(static_cast<std::uint64_t>(image.first))
                  .fork(static_cast<std::uint64_t>(image.second));
    const int count = static_cast<int>(poisson(own, config.false_boxes));
    for (int i = 0; i < count; ++i) {
      DetectedBox one;
      if (false_box(*boxes[uniform_index(own, boxes.size())], own, one))
        found.push_back(std::move(one));
    }
  }
  for (std::size_t i = 0; i < found.size(); ++i) found[i].id = static_cast<int>(i);
  return found;
}

}  // namespace cousin
