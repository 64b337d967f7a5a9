#include "perception/fruit/fruit_surface.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "sim/config/limits.h"

namespace cousin {
namespace {

/// The pixels of a box that count for its fruit, in the image's coordinates.
struct Region {
  Eigen::Vector2i low = Eigen::Vector2i::Zero(), size = Eigen::Vector2i::Zero();
  Image<std::uint8_t> inside;
  int pixels = 0;
  bool contains(int x, int y) const {
    const int lx = x - low.x(), ly = y - low.y();
    return inside.contains(lx, ly) && inside(lx, ly) != 0;
  }
};

bool counts(const DetectedBox& box, int x, int y) {
  if (!box.mask.empty()) {
    const int mx = x - box.mask_at_px.x(), my = y - box.mask_at_px.y();
    return box.mask.contains(mx, my) && box.mask(mx, my) != 0;
  }
  const Eigen::Vector2d half = 0.5 * (box.high_px - box.low_px);
  const Eigen::Vector2d at =
      (Eigen::Vector2d(x, y) - 0.5 * (box.low_px + box.high_px)).cwiseQuotient(half);
  return at.squaredNorm() <= 1;
}

/// One pixel is left free on each side.
Region region_of(const DetectedBox& box, int width, int height) {
  Region region;
  if (!box.low_px.allFinite() || !box.high_px.allFinite()) return region;
  const Eigen::Array2d limit(width - 1, height - 1);
  const Eigen::Array2d low = (box.low_px.array() + 0.5).max(0.0).min(limit);
  const Eigen::Array2d high = (box.high_px.array() - 0.5).max(-1.0).min(limit);
  region.low = low.cast<int>().matrix() - Eigen::Vector2i(1, 1);
  region.size = high.cast<int>().matrix() - region.low + Eigen::Vector2i(2, 2);
  if (region.size.minCoeff() < 3) return region;
  region.inside = Image<std::uint8_t>(region.size.x(), region.size.y());
  for (int y = 1; y + 1 < region.size.y(); ++y) {
    for (int x = 1; x + 1 < region.size.x(); ++x) {
      if (!counts(box, region.low.x() + x, region.low.y() + y)) continue;
      region.inside(x, y) = 1;
      ++region.pixels;
    }
  }
  return region;
}

/// Distance in pixels from what is outside, by two passes [Rosenfeld & Pfaltz 1966, with steps of 1
/// and sqrt 2].
Image<float> distance_from_edge(const Region& region) {
  const int w = region.size.x(), h = region.size.y();
  Image<float> away(w, h);
  const auto relax = [&](int x, int y, int dx, int dy, float step) {
    const int nx = x + dx, ny = y + dy;
    const float there = away.contains(nx, ny) ? away(nx, ny) : 0.0F;
    away(x, y) = std::min(away(x, y), there + step);
  };
  constexpr float kDiagonal = 1.41421356F;
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      if (region.inside(x, y) == 0) continue;
      away(x, y) = 1e6F;
      relax(x, y, -1, 0, 1), relax(x, y, 0, -1, 1);
      relax(x, y, -1, -1, kDiagonal), relax(x, y, 1, -1, kDiagonal);
    }
  }
  for (int y = h - 1; y >= 0; --y) {
    for (int x = w - 1; x >= 0; --x) {
      if (region.inside(x, y) == 0) continue;
      relax(x, y, 1, 0, 1), relax(x, y, 0, 1, 1);
      relax(x, y, 1, 1, kDiagonal), relax(x, y, -1, 1, kDiagonal);
    }
  }
  return away;
}

double middle_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct InnerPixel {
  int x, y;
  double depth_m, sigma_m;
};

/// Inner pixels that have depth, and how many there could.
struct InnerPixels {
  std::vector<InnerPixel> with_depth;
  int all = 0;
};
InnerPixels inner_pixels(const FrameDepth& depth, const Region& region, const Image<float>& away,
                         double rim_px) {
  InnerPixels inner;
  for (int y = 0; y < region.size.y(); ++y) {
    for (int x = 0; x < region.size.x(); ++x) {
      if (static_cast<double>(away(x, y)) <= rim_px) continue;
      ++inner.all;
      const int ix = region.low.x() + x, iy = region.low.y() + y;
      const auto z_m = static_cast<double>(depth.depth_m(ix, iy));
      if (!(z_m > 0)) continue;
      const double sigma_m =
          depth.sigma_m.empty() ? 0.002 : static_cast<double>(depth.sigma_m(ix, iy));
      inner.with_depth.push_back({ix, iy, z_m, sigma_m});
    }
  }
  return inner;
}

/// Every nth, so that at most so many are left.
template <class T>
std::vector<T> thinned(const std::vector<T>& all, int most) {
  const std::size_t step = (all.size() + static_cast<std::size_t>(most) - 1) /
                           static_cast<std::size_t>(std::max(1, most));
  std::vector<T> some;
  for (std::size_t i = step / 2; i < all.size(); i += std::max<std::size_t>(1, step))
    some.push_back(all[i]);
  return some;
}

/// Inner pixels on a lattice that gives about as many as asked for.
std::vector<InnerPixel> on_lattice(const std::vector<InnerPixel>& all, int most) {
  int step = 1;
  while (static_cast<int>(all.size()) / (step * step) > most) ++step;
  std::vector<InnerPixel> some;
  for (const InnerPixel& pixel : all) {
    if (pixel.x % step == 0 && pixel.y % step == 0) some.push_back(pixel);
  }
  return some;
}

/// A step of the mask's edge between an inner pixel and its outer neighbour.
struct EdgeStep {
  Eigen::Vector2d at_px, outward;
};

/// Edge steps in the order of their angle about the mask's middle, with smoothed normals.
std::vector<EdgeStep> edge_of(const Region& region, const Image<float>& away, int width,
                              int height) {
  std::vector<EdgeStep> edge;
  for (int y = 1; y + 1 < region.size.y(); ++y) {
    for (int x = 1; x + 1 < region.size.x(); ++x) {
      if (region.inside(x, y) == 0) continue;
      const int ix = region.low.x() + x, iy = region.low.y() + y;
      // Out is towards the pixels outside the mask, summed over 7 x 7.
      Eigen::Vector2d out = Eigen::Vector2d::Zero();
      for (const auto& [dx, dy] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
        if (region.inside(x + dx, y + dy) != 0) continue;
        const int ox = ix + dx, oy = iy + dy;
        if (ox < 0 || oy < 0 || ox >= width || oy >= height) continue;  // the image's own edge
        for (int ky = -3; ky <= 3; ++ky) {
          for (int kx = -3; kx <= 3; ++kx) {
            const bool is_in = away.contains(x + kx, y + ky) && away(x + kx, y + ky) > 0;
            if (!is_in) out += Eigen::Vector2d(kx, ky);
          }
        }
        if (out.norm() < 1e-9) out = Eigen::Vector2d(dx, dy);
        edge.push_back({{ix + 0.5 * dx, iy + 0.5 * dy}, out.normalized()});
        out.setZero();
      }
    }
  }
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const EdgeStep& step : edge) middle += step.at_px / static_cast<double>(edge.size());
  std::stable_sort(edge.begin(), edge.end(), [&](const EdgeStep& a, const EdgeStep& b) {
    const Eigen::Vector2d p = a.at_px - middle, q = b.at_px - middle;
    return std::atan2(p.y(), p.x()) < std::atan2(q.y(), q.x());
  });
  return edge;
}

double depth_at(const FrameDepth& depth, const Eigen::Vector2d& at) {
  const int x = static_cast<int>(std::lround(at.x())), y = static_cast<int>(std::lround(at.y()));
  return depth.depth_m.contains(x, y) ? static_cast<double>(depth.depth_m(x, y)) : kNaN;
}

/// What stands beyond an edge. What hides a fruit is nearer than the fruit is where it ends, and
/// what the rim stands before is farther. Near the edge the sensor smears the one into the other.
Beyond beyond_of(const FrameDepth& depth, const EdgeStep& step, double middle_m,
                 const FruitSurfaceConfig& config) {
  std::vector<double> inner, outer;
  for (const double in : {3.0, 4.5, 6.0}) {
    const double z_m = depth_at(depth, step.at_px - in * step.outward);
    if (z_m > 0 && std::abs(z_m - middle_m) < config.largest_fruit_m) inner.push_back(z_m);
  }
  const double own_m = inner.empty() ? middle_m : middle_of(inner);
  for (const double out : {0.2, 0.4, 0.6, 0.8, 1.0, 1.2}) {
    const double z_m = depth_at(depth, step.at_px + out * config.look_out_px * step.outward);
    if (!(z_m > 0)) continue;
    if (z_m < own_m - config.before_m) return Beyond::nearer;
    if (out > 0.7) outer.push_back(z_m);
  }
  if (outer.empty()) return Beyond::unknown;
  return middle_of(outer) > own_m + config.behind_m ? Beyond::farther : Beyond::unknown;
}

FruitSurface no_surface(FruitSurface surface, const std::string& why) {
  surface.why_none = why;
  surface.points.clear();
  surface.outline.clear();
  return surface;
}

bool is_cut(const Region& region, int width, int height) {
  for (int y = 0; y < height; ++y) {
    if (region.contains(0, y) || region.contains(width - 1, y)) return true;
  }
  for (int x = 0; x < width; ++x) {
    if (region.contains(x, 0) || region.contains(x, height - 1)) return true;
  }
  return false;
}

void add_outline(const FrameDepth& depth, const Lens& lens, const std::vector<EdgeStep>& edge,
                 const FruitSurfaceConfig& config, FruitSurface& surface) {
  surface.outline_length_px = static_cast<double>(edge.size()) * std::numbers::pi / 4;
  for (const EdgeStep& step : thinned(edge, config.most_outline)) {
    const auto ray = lens.unproject(step.at_px);
    const auto out = lens.unproject(step.at_px + step.outward);
    if (!ray || !out) continue;
    OutlinePlace place;
    place.ray = *ray;
    place.outward = (*out - *ray * ray->dot(*out)).normalized();
    place.beyond = beyond_of(depth, step, surface.depth_m, config);
    surface.outline.push_back(place);
  }
}

}  // namespace

Fields fields(FruitSurfaceConfig& c) {
  return {
      {"rim_px", &c.rim_px, "depths so near to the mask's edge are mixed", 0, 100},
      {"least_rim_px", &c.least_rim_px, "what is left of that where a mask is thin", 0, 100},
      {"most_points", &c.most_points, "points of the surface", 10, 100000},
      {"most_outline", &c.most_outline, "places of the outline", 8, 100000},
      {"least_depths", &c.least_depths, "fewer are no surface", 4, 100000},
      {"least_share", &c.least_share, "of inner pixels with depth; less is no surface", 0, 1},
      {"before_m", &c.before_m, "what is so far before the fruit's edge may hide it", 0, 1},
      {"behind_m", &c.behind_m, "what is so far behind the fruit's edge does not", 0, 1},
      {"look_out_px", &c.look_out_px, "from the outline to where what is beside it is seen", 1,
       100},
      {"largest_fruit_m", &c.largest_fruit_m, "depths farther from their median are not of it",
       0.01, 1},
      {"smallest_fruit_m", &c.smallest_fruit_m, "a visible part of less is too little", 0.001, 1},
      {"correlated_px", &c.correlated_px, "depths within this err alike", 1, 100}};
}

void validate(const FruitSurfaceConfig& config) {
  FruitSurfaceConfig copy = config;
  check_limits(fields(copy), "surface");
}

FruitSurface fruit_surface(const FrameDepth& depth, const Camera& camera, const DetectedBox& box,
                           const FruitSurfaceConfig& config) {
  FruitSurface surface;
  surface.focal_px = camera.fx_px;
  const int width = depth.depth_m.width(), height = depth.depth_m.height();
  if (depth.depth_m.empty()) return no_surface(surface, "the frame has no depth");
  if (!box.mask.empty() && box.image_px != Eigen::Vector2i::Zero() &&
      box.image_px != Eigen::Vector2i(width, height))
    return no_surface(surface, "its mask is of an image of " + std::to_string(box.image_px.x()) +
                                   " x " + std::to_string(box.image_px.y()) + "; the depth is of " +
                                   std::to_string(width) + " x " + std::to_string(height));
  const Region region = region_of(box, width, height);
  surface.mask_px = region.pixels;
  if (region.pixels == 0) return no_surface(surface, "no pixel of the image is in it");
  surface.is_cut = is_cut(region, width, height);
  const Image<float> away = distance_from_edge(region);
  const auto deepest = static_cast<double>(*std::max_element(away.begin(), away.end()));
  const double rim_px = std::max(config.least_rim_px, std::min(config.rim_px, 0.4 * deepest));
  InnerPixels inner = inner_pixels(depth, region, away, rim_px);
  const auto found = static_cast<double>(inner.with_depth.size());
  surface.share_with_depth = inner.all > 0 ? found / inner.all : 0;
  if (found < config.least_depths || surface.share_with_depth < config.least_share)
    return no_surface(surface, std::to_string(inner.with_depth.size()) + " of its " +
                                   std::to_string(inner.all) + " inner pixels have depth");
  std::vector<double> depths;
  for (const InnerPixel& pixel : inner.with_depth) depths.push_back(pixel.depth_m);
  surface.depth_m = middle_of(depths);
  std::erase_if(inner.with_depth, [&](const InnerPixel& pixel) {
    return std::abs(pixel.depth_m - surface.depth_m) > config.largest_fruit_m;
  });
  const auto kept = static_cast<double>(inner.with_depth.size());
  if (kept < config.least_depths) return no_surface(surface, "its depths are of several surfaces");
  const double across_m = 2 * deepest * surface.depth_m / camera.fx_px;
  if (across_m < config.smallest_fruit_m)
    return no_surface(surface, "what is seen is " + std::to_string(across_m * 1e3) + " mm wide");
  const Lens lens(camera);
  for (const InnerPixel& pixel : on_lattice(inner.with_depth, config.most_points)) {
    const auto ray = lens.unproject(Eigen::Vector2d(pixel.x, pixel.y));
    if (ray && ray->z() > 0)
      surface.points.push_back({*ray * (pixel.depth_m / ray->z()), pixel.sigma_m});
  }
  surface.independent_points = std::max(1.0, kept / (config.correlated_px * config.correlated_px));
  add_outline(depth, lens, edge_of(region, away, width, height), config, surface);
  return surface;
}

}  // namespace cousin
