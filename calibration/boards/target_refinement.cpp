#include "calibration/boards/target_refinement.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "calibration/boards/disc_fit.h"
#include "calibration/boards/homography.h"
#include "calibration/boards/saddle_fit.h"

namespace cousin {
namespace {

constexpr double kSnapShare = 0.33;      ///< of a step: from a prediction to its saddle
constexpr double kLeastContrast = 0.25;  ///< of the median
constexpr double kBorderBlurs = 2.5;     ///< a corner nearer to the image's border has lost a side
constexpr double kPooledPixels = 60;     ///< a window knows its own noise as well as so many say

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::optional<Eigen::Vector2d> snapped(const std::vector<Saddle>& saddles, const LocalMap& map,
                                       const Eigen::Vector2d& at_px, double reach_px, bool dark) {
  std::optional<Eigen::Vector2d> best;
  double least = reach_px;
  for (const Saddle& s : saddles) {
    const double away = (s.pixel_px - at_px).norm();
    if (away >= least) continue;
    // The image is convex towards the brighter squares.
    const double mixed = map.px_per_m.col(0).dot(s.hessian * map.px_per_m.col(1));
    if ((mixed < 0) != dark) continue;
    least = away;
    best = s.pixel_px;
  }
  return best;
}

/// Which pixels about a corner show its four squares and nothing of the print's next edges.
class ClearWindow {
 public:
  ClearWindow(const CalibrationTarget& target, const Eigen::Matrix2d& px_per_m, double blur_px)
      : m_per_px_(px_per_m.inverse()) {
    constexpr double kClearance = 2.5;  // blurs from an edge: a part in a hundred of it is left
    const double area = std::abs(px_per_m.determinant());
    const Eigen::Vector2d margin_m =
        kClearance * blur_px / area *
        Eigen::Vector2d(px_per_m.col(1).norm(), px_per_m.col(0).norm());
    const double p = target.pitch_m;
    const bool tags = target.kind == TargetKind::april_grid;
    outer_m_ =
        Eigen::Vector2d::Constant(tags ? std::min(1.0, target.mark_share) * p : p) - margin_m;
    constexpr double kTagBorder = 0.2;  // of a tag: two bits of ten
    const double inner = tags                                 ? kTagBorder * p
                         : target.kind == TargetKind::charuco ? 0.5 * (1 - target.mark_share) * p
                                                              : p;
    // Nearer than that a marker's border leaks in, from both white squares alike: by symmetry it
    // moves no corner.
    constexpr double kLeast_px = 1.2;
    inner_m_ = (Eigen::Vector2d::Constant(inner) - margin_m)
                   .cwiseMax(kLeast_px / (kClearance * blur_px) * margin_m);
  }
  bool operator()(const Eigen::Vector2d& offset_px) const {
    const Eigen::Array2d q = (m_per_px_ * offset_px).array().abs();
    return (q < outer_m_.array()).all() && (q < inner_m_.array()).any();
  }

 private:
  Eigen::Matrix2d m_per_px_;
  Eigen::Vector2d outer_m_, inner_m_;
};

/// From the outermost pixels' centres inward.
double border_px(const Image<float>& image, const Eigen::Vector2d& at_px) {
  return std::min(
      {at_px.x(), at_px.y(), image.width() - 1 - at_px.x(), image.height() - 1 - at_px.y()});
}

struct Measured {
  int index = 0;
  Eigen::Vector2d pixel_px;
  Eigen::Matrix2d unit_covariance_px2;
  double noise = 0, contrast = 0, blur_px = 0;
  int pixels = 0;
};

std::vector<Measured> fit_all(const Image<float>& light, const TargetGrid& grid,
                              const FoundPixels& found, bool inverted, double blur_px,
                              const TargetDetectionConfig& config) {
  std::vector<Measured> all;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (!found[i]) continue;
    const int index = static_cast<int>(i);
    const auto map = local_map(grid, found, index);
    if (!map) continue;
    const double step = step_px(*map, grid.target());
    const ClearWindow is_clear(grid.target(), map->px_per_m, blur_px);
    const auto fit = fit_saddle(light,
                                {.pixel_px = *found[i],
                                 .along_first = map->px_per_m.col(0),
                                 .along_second = map->px_per_m.col(1),
                                 .blur_px = blur_px},
                                {.half_window_px = config.half_window_px,
                                 .max_shift_px = std::clamp(0.25 * step, 1.0, 4.0)},
                                is_clear);
    if (!fit || fit->dark_ahead != (is_dark_ahead(grid, index) != inverted)) continue;
    if (border_px(light, fit->pixel_px) < kBorderBlurs * fit->blur_px) continue;
    all.push_back({index, fit->pixel_px, fit->unit_covariance_px2, fit->noise, fit->contrast,
                   fit->blur_px, fit->pixels});
  }
  return all;
}

/// Without those of little contrast or fits that leave too much.
void keep_clean(std::vector<Measured>& all, const TargetDetectionConfig& config) {
  if (all.empty()) return;
  std::vector<double> contrasts;
  for (const Measured& m : all) contrasts.push_back(m.contrast);
  const double least = kLeastContrast * median_of(contrasts);
  std::erase_if(all, [&](const Measured& m) {
    return m.contrast < least || m.noise > config.max_noise * m.contrast;
  });
}

double median_blur_px(const std::vector<Measured>& all) {
  std::vector<double> blurs;
  for (const Measured& m : all) blurs.push_back(m.blur_px);
  return median_of(blurs);
}

std::vector<TargetObservation> observations(const std::vector<Measured>& all,
                                            const TargetGrid& grid,
                                            const TargetDetectionConfig& config) {
  std::vector<TargetObservation> points;
  if (all.empty()) return points;
  std::vector<double> noises;
  for (const Measured& m : all) noises.push_back(m.noise);
  const double typical = median_of(noises);
  for (const Measured& m : all) {
    const double variance = (m.pixels * m.noise * m.noise + kPooledPixels * typical * typical) /
                            (m.pixels + kPooledPixels);
    const Eigen::Matrix2d covariance_px2 =
        variance * m.unit_covariance_px2 +
        config.floor_px * config.floor_px * Eigen::Matrix2d::Identity();
    if (!(std::sqrt(0.5 * covariance_px2.trace()) <= config.max_sigma_px)) continue;
    points.push_back(
        {grid.points()[static_cast<std::size_t>(m.index)].id, m.pixel_px, covariance_px2});
  }
  return points;
}

}  // namespace

bool is_dark_ahead(const TargetGrid& grid, int index) {
  const TargetPoint& p = grid.points()[static_cast<std::size_t>(index)];
  const bool even = (p.column + p.row) % 2 == 0;
  // A tag is black to the right of and above its lower left corner; rows of squares run down.
  return grid.target().kind == TargetKind::april_grid ? even : !even;
}

void follow_saddles(const TargetGrid& grid, const std::vector<Saddle>& saddles, bool inverted,
                    FoundPixels& found) {
  const FoundPixels given = found;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (!given[i]) continue;
    const int index = static_cast<int>(i);
    const auto map = local_map(grid, given, index);
    found[i].reset();
    if (map) {
      found[i] = snapped(saddles, *map, *given[i], kSnapShare * step_px(*map, grid.target()),
                         is_dark_ahead(grid, index) != inverted);
    }
  }
  for (bool added = true; added;) {
    added = false;
    const FoundPixels before = found;
    for (std::size_t i = 0; i < found.size(); ++i) {
      if (before[i]) continue;
      const int index = static_cast<int>(i);
      const auto map = local_map(grid, before, index);
      if (!map) continue;
      found[i] = snapped(saddles, *map, map->pixel_px, kSnapShare * step_px(*map, grid.target()),
                         is_dark_ahead(grid, index) != inverted);
      added = added || found[i];
    }
  }
}

std::vector<TargetObservation> measure_corners(const Image<float>& light, const TargetGrid& grid,
                                               const FoundPixels& found, bool inverted,
                                               const TargetDetectionConfig& config) {
  std::vector<Measured> all = fit_all(light, grid, found, inverted, 1, config);
  keep_clean(all, config);
  if (all.empty()) return {};
  FoundPixels better(found.size());
  for (const Measured& m : all) better[static_cast<std::size_t>(m.index)] = m.pixel_px;
  drop_strays(grid, better, config.max_stray);
  drop_misplaced(grid, better, config.max_misplaced);
  all = fit_all(light, grid, better, inverted, median_blur_px(all), config);
  keep_clean(all, config);
  return observations(all, grid, config);
}

std::vector<TargetObservation> measure_discs(const Image<float>& light, const TargetGrid& grid,
                                             const FoundPixels& found, double radius_px,
                                             const TargetDetectionConfig& config) {
  const CalibrationTarget& target = grid.target();
  std::vector<Measured> all;
  std::vector<PlanePoint> plane;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (!found[i]) continue;
    const auto map = local_map(grid, found, static_cast<int>(i));
    const double radius_m = target.mark_share * target.pitch_m;
    const double here_px =
        map ? radius_m * std::max(map->px_per_m.col(0).norm(), map->px_per_m.col(1).norm())
            : radius_px;
    const double gap = target.kind == TargetKind::asymmetric_circles ? std::sqrt(2.0) : 1.0;
    const double gap_px =
        map ? 0.5 * (gap / target.mark_share - 2) * radius_m *
                  std::min(map->px_per_m.col(0).norm(), map->px_per_m.col(1).norm())
            : 2;
    const auto fit = fit_disc(light, *found[i], here_px, std::clamp(gap_px, 1.5, 4.0));
    if (!fit || fit->contrast <= 0) continue;
    all.push_back({static_cast<int>(i), fit->centre_px, fit->unit_covariance_px2, fit->noise,
                   fit->contrast, fit->blur_px, fit->pixels});
  }
  keep_clean(all, config);
  for (const Measured& m : all)
    plane.push_back({grid.points()[static_cast<std::size_t>(m.index)].at_m, m.pixel_px, 1});
  const HomographyFit fit = fit_homography(plane);
  if (!fit.ok) return {};
  for (Measured& m : all) {
    m.pixel_px += disc_centre_shift_px(fit.normalized_from_plane,
                                       grid.points()[static_cast<std::size_t>(m.index)].at_m,
                                       target.mark_share * target.pitch_m);
  }
  return observations(all, grid, config);
}

}  // namespace cousin
