#include "benchmarks/suites/seedlings/exact_surface.h"

#include <tbb/parallel_for.h>

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "perception/splats/view_exposures.h"

namespace cousin {
namespace {

/// Relative difference of depths: 3 mm at 0.3 m, more than a pixel spans on a face seen at 60
/// degrees and less than a leaf is above the soil.
constexpr double kSameSurface = 0.01;
constexpr int kStride_px = 4;  // between pixels that exposures are measured by

using Color = std::array<double, 3>;

/// The colour with which a view shows a point, if it does.
std::optional<Color> color_in(const SampleView& view, const Lens& lens,
                              const Eigen::Vector3d& at_m) {
  const SplatViewLevel& level = view.photograph.full;
  const Eigen::Vector3d in_camera_m = view.photograph.camera_from_world * at_m;
  if (!(in_camera_m.z() > 0)) return std::nullopt;
  const auto pixel = lens.project(in_camera_m);
  if (!pixel) return std::nullopt;
  // Just before the camera's plane a pixel may be no whole number.
  if (!(std::abs(pixel->x()) < 1e6 && std::abs(pixel->y()) < 1e6)) return std::nullopt;
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

/// What the views show of the surface of each of the held-out view's pixels, in the mean; NaN where
/// too few do.
FidelityPlanes mean_image(const std::vector<const SampleView*>& views,
                          const std::vector<Lens>& lenses, const SampleView& held_out) {
  const int width = held_out.position_m.width(), height = held_out.position_m.height();
  FidelityPlanes image;
  for (Image<float>& channel : image)
    channel = Image<float>(width, height, std::numeric_limits<float>::quiet_NaN());
  tbb::parallel_for(0, height, [&](int y) {
    for (int x = 0; x < width; ++x) {
      const Eigen::Vector3d at_m = held_out.position_m(x, y).cast<double>();
      if (held_out.shown(x, y) == 0 || !at_m.allFinite()) continue;
      Color sum{};
      int count = 0;
      for (std::size_t v = 0; v < views.size(); ++v) {
        const auto color = color_in(*views[v], lenses[v], at_m);
        if (!color) continue;
        for (std::size_t c = 0; c < 3; ++c) sum[c] += (*color)[c];
        ++count;
      }
      if (count < kEnoughViews) continue;
      for (std::size_t c = 0; c < 3; ++c) image[c](x, y) = static_cast<float>(sum[c] / count);
    }
  });
  return image;
}

/// PSNR over all views' pixels that are not NaN.
class PooledScore {
 public:
  void add(const FidelityPlanes& image, const FidelityPlanes& photograph) {
    ++score_.views;
    for (std::size_t i = 0; i < image[0].size(); ++i) {
      if (std::isnan(image[0].data()[i])) continue;
      ++score_.pixels;
      for (std::size_t c = 0; c < 3; ++c) {
        const double off =
            static_cast<double>(image[c].data()[i]) - static_cast<double>(photograph[c].data()[i]);
        squares_ += off * off;
      }
    }
  }
  ExactSurface score() const {
    ExactSurface result = score_;
    if (result.pixels > 0)
      result.psnr_db = -10 * std::log10(squares_ / (3 * static_cast<double>(result.pixels)));
    return result;
  }

 private:
  ExactSurface score_;
  double squares_ = 0;
};

std::vector<Lens> lenses_of(const std::vector<const SampleView*>& views) {
  std::vector<Lens> lenses;
  for (const SampleView* view : views) lenses.emplace_back(view->photograph.full.camera);
  return lenses;
}

}  // namespace

ExactSurface exact_surface(const FieldViews& views) {
  const std::vector<Lens> lenses = lenses_of(views.train);
  PooledScore pooled;
  for (const SampleView* held_out : views.held_out)
    pooled.add(mean_image(views.train, lenses, *held_out), held_out->photograph.full.color.channel);
  return pooled.score();
}

ExactSurface exact_surface_at_one_exposure(const FieldViews& views) {
  std::vector<SplatView> photographs;
  std::vector<Image<float>> depths_m;
  for (const auto* set : {&views.train, &views.held_out}) {
    for (const SampleView* view : *set) {
      photographs.push_back(view->photograph);
      depths_m.push_back(view->depth_m);
    }
  }
  const ViewExposures exposures = estimate_exposures(
      photographs, depths_m, {.stride_px = kStride_px, .depth_agreement = kSameSurface});
  if (exposures.status != ExposureStatus::ok) return {};
  std::vector<SampleView> even;
  for (std::size_t v = 0; v < views.train.size(); ++v) {
    even.push_back(*views.train[v]);
    SplatViewLevel& level = even.back().photograph.full;
    level = at_mean_exposure(std::move(level), exposures.gain_of(v), exposures.vignetting);
  }
  std::vector<const SampleView*> trained;
  for (const SampleView& view : even) trained.push_back(&view);
  const std::vector<Lens> lenses = lenses_of(trained);
  PooledScore pooled;
  for (std::size_t v = 0; v < views.held_out.size(); ++v) {
    if (!std::isfinite(exposures.log_gain[views.train.size() + v])) continue;
    const SplatView& photograph = views.held_out[v]->photograph;
    pooled.add(as_exposed({mean_image(trained, lenses, *views.held_out[v])}, photograph.full.camera,
                          exposures.gain_of(views.train.size() + v), exposures.vignetting)
                   .channel,
               photograph.full.color.channel);
  }
  return pooled.score();
}

}  // namespace cousin
