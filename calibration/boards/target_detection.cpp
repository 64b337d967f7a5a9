#include "calibration/boards/target_detection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "calibration/boards/chessboard_placement.h"
#include "calibration/boards/circle_grid.h"
#include "calibration/boards/grid_growth.h"
#include "calibration/boards/marker_detection.h"
#include "calibration/boards/seed_board_target.h"
#include "calibration/boards/target_refinement.h"
#include "sim/config/limits.h"
#include "sim/imaging/color.h"

namespace cousin {
namespace {

constexpr int kLeastPoints = 6;  ///< of a view: a plane's homography and a check of it
constexpr double kSmoothing_px = 1.0, kSaddleContrast = 0.01;

/// The picture for finding: made smaller by a whole number, black to white 0..1, roughly as the eye
/// sees it.
struct Tones {
  int scale = 1;
  Image<float> tone;
  Image<std::uint8_t> bytes;   ///< of `tone`
  Image<std::uint8_t> linear;  ///< black to white 0..255 in proportion to light

  Eigen::Vector2d full_px(const Eigen::Vector2d& small_px) const {
    return scale * (small_px + Eigen::Vector2d::Constant(0.5)) - Eigen::Vector2d::Constant(0.5);
  }
};

struct Levels {
  float black = 0, white = 1;
};

/// Near the darkest and the brightest.
Levels levels_of(const Image<float>& light) {
  constexpr std::size_t kMostSamples = 100'000;
  std::vector<float> values;
  const std::size_t step = std::max<std::size_t>(1, light.size() / kMostSamples);
  for (std::size_t i = 0; i < light.size(); i += step) {
    if (std::isfinite(light.data()[i])) values.push_back(light.data()[i]);
  }
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const auto at = [&](double share) {
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
  };
  Levels levels{at(0.005), at(0.995)};
  if (!(levels.white > levels.black)) levels.white = levels.black + 1e-6F;
  return levels;
}

/// A root that does not blow up the noise of black: its slope is 3 there and 0.6 at white.
float tone_of(float v) {
  constexpr float kLift = 0.04F;
  const float low = std::sqrt(kLift);
  return (std::sqrt(v + kLift) - low) / (std::sqrt(1 + kLift) - low);
}

Tones tones_of(const Image<float>& light, const Levels& levels, int scale) {
  Tones tones;
  tones.scale = scale;
  const int width = light.width() / scale, height = light.height() / scale;
  cv::Mat small(light.height(), light.width(), CV_32F, const_cast<float*>(light.data()));
  if (scale > 1) {
    // Whole blocks only, so that a small pixel is the mean of scale x scale.
    cv::Mat made;
    cv::resize(small(cv::Rect(0, 0, width * scale, height * scale)), made, {width, height}, 0, 0,
               cv::INTER_AREA);
    small = made;
  }
  tones.tone = Image<float>(width, height);
  tones.bytes = tones.linear = Image<std::uint8_t>(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float v = (small.at<float>(y, x) - levels.black) / (levels.white - levels.black);
      const float share = std::isfinite(v) ? std::clamp(v, 0.0F, 1.0F) : 0.0F;
      const float tone = tone_of(share);
      tones.linear(x, y) = static_cast<std::uint8_t>(std::lround(255 * share));
      tones.tone(x, y) = tone;
      tones.bytes(x, y) = static_cast<std::uint8_t>(std::lround(255 * tone));
    }
  }
  return tones;
}

std::vector<Saddle> saddles_of(const Tones& tones) {
  std::vector<Saddle> saddles = find_saddles(tones.tone, kSmoothing_px, kSaddleContrast);
  constexpr std::size_t kMost = 20'000;
  if (saddles.size() > kMost) saddles.resize(kMost);  // strongest first
  return saddles;
}

std::vector<Saddle> in_full(const Tones& tones, std::vector<Saddle> saddles) {
  for (Saddle& s : saddles) s.pixel_px = tones.full_px(s.pixel_px);
  return saddles;
}

/// Roughly where the points are.
struct Guess {
  TargetStatus status = TargetStatus::not_seen;
  std::string reason;
  FoundPixels found;
  std::vector<Saddle> saddles;  ///< in the full picture
  bool inverted = false;
  double radius_px = 0;  ///< of discs
};

bool is_usable_guess(const Guess& guess) {
  return guess.status == TargetStatus::ok || guess.status == TargetStatus::half_turn_unknown;
}

/// The strongest, down to a share of the one that would be the board's last if it were alone.
std::vector<Saddle> strong_ones(const std::vector<Saddle>& saddles, std::size_t points,
                                double share) {
  if (saddles.empty()) return {};
  const double least = share * saddles[std::min(points, saddles.size()) - 1].strength;
  std::vector<Saddle> strong = saddles;
  std::erase_if(strong, [&](const Saddle& s) { return s.strength < least; });
  return strong;
}

/// Lattices of strong saddles first: weak ones beside the board join it, and another board's size
/// comes out.
Guess guess_chessboard(const Image<float>& light, const TargetGrid& grid) {
  constexpr double kReach = 0.3;  // of the width: the longest side of a square
  constexpr std::array<double, 3> kShares = {0.4, 0.15, 0.0};
  const Levels levels = levels_of(light);
  const int base = std::max(1, static_cast<int>(std::lround(light.width() / 900.0)));
  std::vector<int> scales = {base, 2 * base};
  if (base > 1) scales.push_back(std::max(1, base / 2));
  Guess best;
  std::size_t most = 0;
  for (const int scale : scales) {
    if (std::min(light.width(), light.height()) / scale < 40) continue;
    const Tones tones = tones_of(light, levels, scale);
    const std::vector<Saddle> saddles = saddles_of(tones);
    for (const double share : kShares) {
      std::vector<LatticeCorner> lattice =
          grow_lattice(tones.tone, strong_ones(saddles, grid.points().size(), share),
                       std::max(grid.columns(), grid.rows()) + 2, kReach);
      for (LatticeCorner& c : lattice) c.pixel_px = tones.full_px(c.pixel_px);
      ChessboardPlacement placement =
          place_chessboard(grid, lattice, light.width(), light.height());
      Guess guess;
      guess.status = placement.status;
      guess.reason = placement.reason;
      guess.found = std::move(placement.found);
      guess.inverted = placement.inverted;
      const bool usable = is_usable_guess(guess);
      if (usable ? count_found(guess.found) > count_found(best.found) : lattice.size() > most) {
        if (usable || !is_usable_guess(best)) {
          guess.saddles = in_full(tones, saddles);
          best = std::move(guess);
        }
      }
      most = std::max(most, lattice.size());
      if (is_usable_guess(best) && count_found(best.found) == grid.columns() * grid.rows())
        return best;
    }
  }
  if (best.reason.empty()) best.reason = "no checkerboard is seen";
  return best;
}

Tones marker_tones(const Image<float>& light) {
  const int scale = std::max(1, static_cast<int>(std::lround(light.width() / 1600.0)));
  return tones_of(light, levels_of(light), scale);
}

std::vector<SeenMarker> markers_in(const Tones& tones, const CalibrationTarget& target) {
  return find_markers(std::array<const Image<std::uint8_t>*, 2>{&tones.linear, &tones.bytes},
                      target);
}

LayoutVotes votes_of(const CalibrationTarget& target, const std::vector<SeenMarker>& markers) {
  return {marker_order(target, CharucoLayout::current, markers).agree,
          marker_order(target, CharucoLayout::legacy, markers).agree};
}

/// What to say of markers that lie as on the same board in its other layout; else empty.
std::string other_layout(const CalibrationTarget& target, CharucoLayout layout,
                         const std::vector<SeenMarker>& markers) {
  if (!has_two_layouts(target)) return "";
  const LayoutVotes votes = votes_of(target, markers);
  const bool is_legacy = votes.legacy > votes.current;
  if (is_legacy == (layout == CharucoLayout::legacy)) return "";
  return is_legacy ? "; its layout is the legacy one, of OpenCV up to 4.5"
                   : "; its layout is the current one, of OpenCV 4.6 and later";
}

Guess guess_markers(const Image<float>& light, const TargetGrid& grid, CharucoLayout layout) {
  constexpr double kMostDiffer = 0.25;
  const Tones tones = marker_tones(light);
  std::vector<SeenMarker> markers = markers_in(tones, grid.target());
  Guess guess;
  const int count = marker_count(grid.target());
  const std::size_t seen = markers.size();
  std::erase_if(markers, [&](const SeenMarker& m) { return m.id >= count; });
  for (SeenMarker& m : markers) {
    for (Eigen::Vector2d& corner : m.corners_px) corner = tones.full_px(corner);
  }
  if (seen == 0) {
    guess.reason = "no marker is seen";
    return guess;
  }
  if (seen - markers.size() > markers.size() / 3) {
    guess.status = TargetStatus::wrong_target;
    guess.reason = std::to_string(seen - markers.size()) + " of " + std::to_string(seen) +
                   " markers have numbers of " + std::to_string(count) +
                   " or more, which the board has not";
    return guess;
  }
  const MarkerOrder order = marker_order(grid.target(), layout, markers);
  if (order.differ > kMostDiffer * (order.agree + order.differ)) {
    guess.status = TargetStatus::wrong_target;
    guess.reason =
        std::to_string(order.differ) + " of " + std::to_string(order.agree + order.differ) +
        " pairs of markers do not lie as on a board of " + std::to_string(grid.target().columns) +
        " x " + std::to_string(grid.target().rows) + other_layout(grid.target(), layout, markers);
    return guess;
  }
  guess.status = TargetStatus::ok;
  guess.found = points_from_markers(grid, layout, markers);
  guess.inverted = !is_first_square_black(grid.target(), layout);
  guess.saddles = in_full(tones, saddles_of(tones));
  return guess;
}

Guess guess_discs(const Image<float>& light, const TargetGrid& grid) {
  const int scale = std::max(1, static_cast<int>(std::lround(light.width() / 1600.0)));
  const Tones tones = tones_of(light, levels_of(light), scale);
  CircleGrid circles = find_circle_grid(tones.bytes, grid);
  Guess guess;
  guess.status = circles.status;
  guess.reason = circles.reason;
  guess.radius_px = scale * circles.radius_px;
  guess.found = std::move(circles.found);
  for (auto& at : guess.found) {
    if (at) at = tones.full_px(*at);
  }
  return guess;
}

TargetView refused(TargetStatus status, std::string reason) {
  TargetView view;
  view.status = status;
  view.reason = std::move(reason);
  return view;
}

}  // namespace

Fields fields(TargetDetectionConfig& config) {
  return {
      {"half_window_px", &config.half_window_px, "of a corner's window", 2, 20},
      {"least_share", &config.least_share, "of the target's points that a view must show", 0, 1},
      {"max_stray", &config.max_stray, "of a step: points farther from their place go", 0.01, 1},
      {"max_misplaced", &config.max_misplaced,
       "of a step: measured points farther from their neighbours' homography go", 0.01, 1},
      {"max_noise", &config.max_noise, "of the contrast: what a point's fit may leave", 0.001, 1},
      {"max_sigma_px", &config.max_sigma_px, "points predicted worse than this are dropped", 1e-3,
       10},
      {"floor_px", &config.floor_px, "deviation added for what the model leaves out", 0, 1},
  };
}

void validate(const TargetDetectionConfig& config) {
  TargetDetectionConfig copy = config;
  check_limits(fields(copy), "detection");
}

Image<float> light_of(const Image<Rgb8>& color) {
  std::array<float, 256> table{};
  for (std::size_t i = 0; i < table.size(); ++i)
    table[i] = linear_from_srgb8(static_cast<std::uint8_t>(i));
  Image<float> light(color.width(), color.height());
  for (std::size_t i = 0; i < color.size(); ++i) {
    const Rgb8 c = color.data()[i];
    light.data()[i] = 0.2126F * table[c.r] + 0.7152F * table[c.g] + 0.0722F * table[c.b];
  }
  return light;
}

Image<float> light_of(const Image<std::uint8_t>& linear_grey) {
  Image<float> light(linear_grey.width(), linear_grey.height());
  for (std::size_t i = 0; i < light.size(); ++i)
    light.data()[i] = static_cast<float>(linear_grey.data()[i]) / 255.0F;
  return light;
}

LayoutVotes layout_votes(const Image<float>& light, const CalibrationTarget& target) {
  validate(target);
  constexpr int kLeastSide = 40;
  if (!has_two_layouts(target) || std::min(light.width(), light.height()) < kLeastSide) return {};
  std::vector<SeenMarker> markers = markers_in(marker_tones(light), target);
  const int count = marker_count(target);
  std::erase_if(markers, [&](const SeenMarker& m) { return m.id >= count; });
  return votes_of(target, markers);
}

TargetView find_target(const Image<float>& light, const CalibrationTarget& target,
                       const TargetDetectionConfig& config, CharucoLayout layout) {
  validate(target);
  validate(config);
  constexpr int kLeastSide = 40;
  if (std::min(light.width(), light.height()) < kLeastSide)
    return refused(TargetStatus::not_seen, "the image has less than 40 pixels a side");
  if (target.kind == TargetKind::seed_board) return find_seed_board(light, target, config);

  const TargetGrid grid(target);
  const bool has_discs =
      target.kind == TargetKind::circles || target.kind == TargetKind::asymmetric_circles;
  Guess guess = has_discs                               ? guess_discs(light, grid)
                : target.kind == TargetKind::chessboard ? guess_chessboard(light, grid)
                                                        : guess_markers(light, grid, layout);
  if (!is_usable_guess(guess)) return refused(guess.status, guess.reason);
  // Order.
  const int guessed = count_found(guess.found);
  const int strays = drop_strays(grid, guess.found, config.max_stray);
  if (3 * strays > guessed) {
    return refused(TargetStatus::disordered, std::to_string(strays) + " of " +
                                                 std::to_string(guessed) +
                                                 " points do not lie among their neighbours");
  }
  if (guessed > 0 && !is_face_seen(grid, guess.found))
    return refused(TargetStatus::disordered,
                   "the print is seen from behind: the image is mirrored");
  // Place.
  TargetView view;
  if (has_discs) {
    view.points = measure_discs(light, grid, guess.found, guess.radius_px, config);
  } else {
    follow_saddles(grid, guess.saddles, guess.inverted, guess.found);
    drop_strays(grid, guess.found, config.max_stray);
    view.points = measure_corners(light, grid, guess.found, guess.inverted, config);
  }
  const int least = std::max(
      kLeastPoints,
      static_cast<int>(std::ceil(config.least_share * static_cast<double>(grid.points().size()))));
  if (static_cast<int>(view.points.size()) < least) {
    return refused(
        TargetStatus::too_few_points,
        std::to_string(view.points.size()) + " points; the least is " + std::to_string(least));
  }
  view.status = guess.status;
  view.reason = guess.reason;
  return view;
}

}  // namespace cousin
