#include "benchmarks/seedlings/exact_surface.h"

#include <tbb/parallel_for.h>

#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "perception/splats/view_exposures.h"

namespace cousin {
namespace {

/// Relative difference of depths: 3 mm at 0.3 m, more than a pixel spans on a face seen at 60
/// degrees and less than a leaf is above the soil.
constexpr double kSameSurface = 0.01;

using Color = std::array<double, 3>;

/// The colour with which a view shows a point, if it does.
std::optional<Color> color_in(const SampleView& view, const Lens& lens,
                              const Eigen::Vector3d& at_m) {
  const SplatViewLevel& level = view.photograph.full;
  const Eigen::Vector3d in_camera_m = view.photograph.camera_from_world * at_m;
  if (!(in_camera_m.z() > 0)) return std::nullopt;
  const auto pixel = lens.project(in_camera_m);
  if (!pixel) return std::nullopt;
  const int left = static_cast<int>(std::floor(pixel->x()));
  const int top = static_cast<int>(std::floor(pixel->y()));
  if (!view.depth_m.contains(left, top) || !view.depth_m.contains(left + 1, top + 1))
    return std::nullopt;
  const double right = pixel->x() - left, down = pixel->y() - top;
  Color color{};
  for (int j = 0; j < 2; ++j) {
    for (int i = 0; i < 2; ++i) {
      const int x = left + i, y = top + j;
      const double off_m = static_cast<double>(view.depth_m(x, y)) - in_camera_m.z();
      if (!(std::abs(off_m) <= kSameSurface * in_camera_m.z())) return std::nullopt;
      if (view.shown(x, y) == 0) return std::nullopt;
      const double share = (i ? right : 1 - right) * (j ? down : 1 - down);
      for (std::size_t c = 0; c < 3; ++c)
        color[c] += share * static_cast<double>(level.color.channel[c](x, y));
    }
  }
  return color;
}

struct Squares {
  double sum = 0;
  std::int64_t pixels = 0;
};

}  // namespace

ExactSurface exact_surface(const FieldViews& views) {
  std::vector<Lens> lenses;
  for (const SampleView* view : views.train) lenses.emplace_back(view->photograph.full.camera);
  Squares all;
  for (const SampleView* held_out : views.held_out) {
    const auto& photograph = held_out->photograph.full.color.channel;
    std::vector<Squares> rows(static_cast<std::size_t>(held_out->position_m.height()));
    tbb::parallel_for(0, held_out->position_m.height(), [&](int y) {
      Squares& row = rows[static_cast<std::size_t>(y)];
      for (int x = 0; x < held_out->position_m.width(); ++x) {
        const Eigen::Vector3d at_m = held_out->position_m(x, y).cast<double>();
        if (held_out->shown(x, y) == 0 || !at_m.allFinite()) continue;
        Color sum{};
        int count = 0;
        for (std::size_t v = 0; v < views.train.size(); ++v) {
          const auto color = color_in(*views.train[v], lenses[v], at_m);
          if (!color) continue;
          for (std::size_t c = 0; c < 3; ++c) sum[c] += (*color)[c];
          ++count;
        }
        if (count < kEnoughViews) continue;
        ++row.pixels;
        for (std::size_t c = 0; c < 3; ++c) {
          const double off = sum[c] / count - static_cast<double>(photograph[c](x, y));
          row.sum += off * off;
        }
      }
    });
    for (const Squares& row : rows) {  // in one order, whatever the threads
      all.sum += row.sum;
      all.pixels += row.pixels;
    }
  }
  ExactSurface result;
  result.pixels = all.pixels;
  if (all.pixels > 0)
    result.psnr_db = -10 * std::log10(all.sum / (3 * static_cast<double>(all.pixels)));
  return result;
}

ExactSurface exact_surface_at_one_exposure(const FieldViews& views) {
  std::vector<SampleView> all;
  for (const auto* set : {&views.train, &views.held_out}) {
    for (const SampleView* view : *set) all.push_back(*view);
  }
  std::vector<SplatView> photographs;
  std::vector<Image<float>> depths_m;
  for (const SampleView& view : all) {
    photographs.push_back(view.photograph);
    depths_m.push_back(view.depth_m);
  }
  const ViewExposures exposures =
      estimate_exposures(photographs, depths_m, {.depth_agreement = kSameSurface});
  FieldViews even;
  for (std::size_t v = 0; v < all.size(); ++v) {
    SplatViewLevel& level = all[v].photograph.full;
    level = at_mean_exposure(std::move(level), exposures.gain_of(v), exposures.vignetting);
    (v < views.train.size() ? even.train : even.held_out).push_back(&all[v]);
  }
  return exact_surface(even);
}

}  // namespace cousin
