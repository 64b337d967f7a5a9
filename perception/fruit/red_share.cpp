#include "perception/fruit/red_share.h"

#include <algorithm>
#include <cmath>

#include "sim/config/limits.h"
#include "sim/imaging/color.h"

namespace cousin {
namespace {

bool shows(const DetectedBox& box, int x, int y) {
  if (x < box.low_px.x() || x > box.high_px.x() || y < box.low_px.y() || y > box.high_px.y())
    return false;
  if (box.mask.empty()) return true;
  const int mx = x - box.mask_at_px.x(), my = y - box.mask_at_px.y();
  return box.mask.contains(mx, my) && box.mask(mx, my) != 0;
}

bool is_inside(const DetectedBox& box, int x, int y, int inset) {
  return shows(box, x, y) && shows(box, x - inset, y) && shows(box, x + inset, y) &&
         shows(box, x, y - inset) && shows(box, x, y + inset);
}

bool is_red(const Rgb8& code, double red_over_green) {
  return static_cast<double>(linear_from_srgb8(code.r)) >=
         red_over_green * static_cast<double>(linear_from_srgb8(code.g));
}

}  // namespace

Fields fields(RedShareConfig& c) {
  return {
      {"red_over_green", &c.red_over_green, "least red over green of a red pixel, linear", 1, 10},
      {"least_cosine", &c.least_cosine, "of the surface against the view", 0.01, 1},
      {"inset_px", &c.inset_px, "of the mask", 0, 100},
      {"least_pixels", &c.least_pixels, "fewer are no share", 1, 1000000},
      {"sigma", &c.sigma, "of the share that is seen", 0, 1},
      {"sigma_hidden", &c.sigma_hidden, "of the hidden side's, over sqrt(p (1 - p))", 0, 10}};
}

void validate(const RedShareConfig& config) {
  RedShareConfig copy = config;
  check_limits(fields(copy), "red");
}

FruitMeasure red_share_seen(const Image<Rgb8>& color, const Camera& camera, const DetectedBox& box,
                            const FruitShape& shape, const RedShareConfig& config) {
  if (color.empty() || !box.low_px.allFinite() || !box.high_px.allFinite()) return {};
  const Lens lens(camera);
  const int x0 = std::max(0, static_cast<int>(std::max(box.low_px.x(), 0.0))),
            y0 = std::max(0, static_cast<int>(std::max(box.low_px.y(), 0.0)));
  const int x1 = static_cast<int>(std::min(box.high_px.x(), color.width() - 1.0)),
            y1 = static_cast<int>(std::min(box.high_px.y(), color.height() - 1.0));
  double red = 0, all = 0;
  int pixels = 0;
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      if (!is_inside(box, x, y, config.inset_px)) continue;
      const auto ray = lens.unproject(Eigen::Vector2d(x, y));
      if (!ray) continue;
      const double cosine = -ray->normalized().dot(normal_on_ray(shape, ray->normalized()));
      if (cosine < config.least_cosine) continue;
      all += 1 / cosine;
      if (is_red(color(x, y), config.red_over_green)) red += 1 / cosine;
      ++pixels;
    }
  }
  if (pixels < config.least_pixels) return {};
  const double share = red / all;
  // Half of the surface is never seen: with one count of each colour added, none is ever sure.
  const double spread = std::sqrt((share + 0.01) * (1.01 - share));
  return {share, std::hypot(config.sigma, 0.5 * config.sigma_hidden * spread)};
}

}  // namespace cousin
