#include "sim/imaging/stereo_matching.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/imaging/census.h"
#include "sim/imaging/semi_global.h"

namespace cousin {
namespace {

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

std::size_t size(int n) { return static_cast<std::size_t>(n); }

[[noreturn]] void reject(const std::string& what) {
  throw std::invalid_argument("stereo matching: " + what);
}

void require(bool good, const char* key, double value, const char* limit) {
  if (!good) reject(std::string(key) + " = " + std::to_string(value) + " must be " + limit);
}

/// Least cost among candidates first .. last - 1.
template <class Cost>
Cost least_of(const Cost* costs, int first, int last) {
  Cost least = std::numeric_limits<Cost>::max();
  for (int i = first; i < last; ++i) least = std::min(least, costs[i]);
  return least;
}

/// Offset in [-0.5, 0.5] of the true minimum from the middle one of three costs.
float sub_pixel(SubPixelFit fit, float before, float least, float after) {
  if (fit == SubPixelFit::parabola) {
    const float curvature = before - 2 * least + after;
    return curvature > 0 ? 0.5F * (before - after) / curvature : 0;
  }
  const float slope = std::max(before, after) - least;
  return slope > 0 ? 0.5F * (before - after) / slope : 0;
}

/// Chooses the disparities of one row from the sums of its path costs.
class RowChooser {
 public:
  RowChooser(const StereoMatchConfig& config, double largest_cost, int width, int candidates,
             int stride)
      : config_(config),
        width_(width),
        candidates_(candidates),
        stride_(stride),
        first_px_(config.shift_px),
        worst_cost_(static_cast<float>(config.worst_cost * largest_cost)),
        costs_(size(width) * size(stride)),
        right_(size(width + candidates)) {}

  void operator()(const std::uint8_t* block_costs, const std::uint16_t* part0,
                  const std::uint16_t* part1, const float* deviation, float* disparity_px,
                  float* confidence, MatchReason* reason) {
    block_costs_ = block_costs;
    const std::size_t count = costs_.size();
    for (std::size_t i = 0; i < count; ++i)
      costs_[i] = static_cast<std::uint16_t>(part0[i] + part1[i]);
    match_right();
    for (int x = 0; x < width_; ++x) {
      disparity_px[x] = kNone;
      confidence[x] = 0;
      const bool is_even =
          deviation != nullptr && deviation[x] < static_cast<float>(config_.texture);
      reason[x] = choose(x, disparity_px[x], confidence[x]);
      if (is_even) reason[x] = MatchReason::no_texture;
      if (reason[x] != MatchReason::none) disparity_px[x] = kNone;
    }
  }

 private:
  /// The best candidate of each pixel of the right image, among those of the left one that meet it:
  /// the cost above the candidate, so that the least is found by whole numbers.
  void match_right() {
    std::fill(right_.begin(), right_.end(), std::numeric_limits<std::uint32_t>::max());
    for (int x = 0; x < width_; ++x) {
      const std::uint16_t* costs = costs_.data() + size(x) * size(stride_);
      const int inside = std::clamp(x - first_px_ + 1, 0, candidates_);
      // Reversed, as in the costs: pixel x - first - i of the right image is at this + i.
      std::uint32_t* right = right_.data() + (width_ - 1 - x);
      for (int i = 0; i < inside; ++i) {
        const std::uint32_t key =
            static_cast<std::uint32_t>(costs[i]) << 8 | static_cast<std::uint32_t>(i);
        right[i] = std::min(right[i], key);
      }
    }
  }

  MatchReason choose(int x, float& disparity_px, float& confidence) const {
    const std::uint16_t* costs = costs_.data() + size(x) * size(stride_);
    const int inside = std::clamp(x - first_px_ + 1, 0, candidates_);
    if (inside == 0) return MatchReason::out_of_range;
    const std::uint16_t least = least_of(costs, 0, inside);
    int best = 0;
    while (costs[best] != least) ++best;
    const std::uint8_t* block = block_costs_ + size(x) * size(stride_);
    const float next = std::min(least_of(block, 0, std::max(best - 1, 0)),
                                least_of(block, std::min(best + 2, inside), inside));
    const float cost = block[best];
    confidence = cost < next ? 1 - cost / next : 0;
    if (best == 0 || best == candidates_ - 1) return MatchReason::out_of_range;
    if (cost > worst_cost_) return MatchReason::unlike;
    if (confidence < static_cast<float>(config_.uniqueness)) return MatchReason::ambiguous;
    if (config_.left_right_px >= 0) {
      const int other = static_cast<int>(right_[size(width_ - 1 - x + best)] & 0xFFU);
      if (std::abs(other - best) > config_.left_right_px) return MatchReason::left_right;
    }
    disparity_px = static_cast<float>(first_px_) + refine(x, best, inside);
    return MatchReason::none;
  }

  /// Between candidates the block's own costs decide: path sums carry the prior for whole
  /// candidates, which draws disparities towards them (by up to 0.2 px at p1 = 0.04).
  float refine(int x, int best, int inside) const {
    const std::uint8_t* costs = block_costs_ + size(x) * size(stride_);
    const int first = std::max(best - 1, 1), last = std::min(best + 1, inside - 2);
    for (int i = first; i <= last; ++i) {
      if (costs[i] < costs[best]) best = i;
    }
    if (best + 1 >= inside) return static_cast<float>(best);
    const float offset = sub_pixel(config_.fit, costs[best - 1], costs[best], costs[best + 1]);
    return static_cast<float>(best) + std::clamp(offset, -0.5F, 0.5F);
  }

  const StereoMatchConfig& config_;
  int width_, candidates_, stride_, first_px_;
  float worst_cost_;
  const std::uint8_t* block_costs_ = nullptr;
  std::vector<std::uint16_t> costs_;
  std::vector<std::uint32_t> right_;
};

template <class Pixel>
Image<float> deviation_of(const Image<Pixel>& image, int width_px, int height_px) {
  if (width_px < 1 || height_px < 1) reject("a window without pixels");
  const int width = image.width(), height = image.height();
  const int rx = width_px / 2, ry = height_px / 2;
  Image<float> result(width, height);
  tbb::parallel_for(tbb::blocked_range<int>(0, height, 16), [&](const auto& range) {
    std::vector<double> sum(size(width)), squares(size(width));
    for (int y = range.begin(); y < range.end(); ++y) {
      std::fill(sum.begin(), sum.end(), 0.0);
      std::fill(squares.begin(), squares.end(), 0.0);
      const int top = std::max(y - ry, 0), bottom = std::min(y + ry, height - 1);
      for (int j = top; j <= bottom; ++j) {
        const Pixel* row = image.row(j).data();
        for (int x = 0; x < width; ++x) {
          const auto value = static_cast<double>(row[x]);
          sum[size(x)] += value;
          squares[size(x)] += value * value;
        }
      }
      for (int x = 0; x < width; ++x) {
        const int left = std::max(x - rx, 0), right = std::min(x + rx, width - 1);
        double a = 0, b = 0;
        for (int i = left; i <= right; ++i) {
          a += sum[size(i)];
          b += squares[size(i)];
        }
        const double n = (right - left + 1) * (bottom - top + 1);
        result(x, y) = static_cast<float>(std::sqrt(std::max(0.0, b / n - a / n * (a / n))));
      }
    }
  });
  return result;
}

template <class Pixel>
StereoMatches match(const Image<Pixel>& left, const Image<Pixel>& right,
                    const StereoMatchConfig& config) {
  validate(config);
  if (left.empty() || left.width() != right.width() || left.height() != right.height()) {
    reject("images of " + std::to_string(left.width()) + " x " + std::to_string(left.height()) +
           " and " + std::to_string(right.width()) + " x " + std::to_string(right.height()));
  }
  const int width = left.width(), height = left.height();
  const int bits = census_bits(config.census_width_px, config.census_height_px);
  // One candidate at either end only shows that the best one lies beyond.
  const int candidates = config.range_px + 2;
  const CostVolume costs =
      hamming_costs(census_transform(left, config.census_width_px, config.census_height_px),
                    census_transform(right, config.census_width_px, config.census_height_px), bits,
                    config.block_px, candidates, config.shift_px);
  const double largest = costs.largest();
  const PathSums sums =
      sum_paths(costs, config.paths, static_cast<std::uint16_t>(std::lround(config.p1 * largest)),
                static_cast<std::uint16_t>(std::lround(config.p2 * largest)));
  Image<float> deviation;
  if (config.texture > 0) {
    deviation = deviation_of(left, config.census_width_px + config.block_px - 1,
                             config.census_height_px + config.block_px - 1);
  }
  StereoMatches matches{Image<float>(width, height), Image<float>(width, height),
                        Image<MatchReason>(width, height)};
  const std::size_t row_size = size(width) * size(costs.stride());
  tbb::parallel_for(tbb::blocked_range<int>(0, height, 16), [&](const auto& range) {
    RowChooser choose(config, largest, width, candidates, costs.stride());
    for (int y = range.begin(); y < range.end(); ++y) {
      choose(costs.row(y), sums.part[0].get() + size(y) * row_size,
             sums.part[1].get() + size(y) * row_size,
             deviation.empty() ? nullptr : deviation.row(y).data(),
             matches.disparity_px.row(y).data(), matches.confidence.row(y).data(),
             matches.reason.row(y).data());
    }
  });
  return matches;
}

}  // namespace

void validate(const StereoMatchConfig& c) {
  census_bits(c.census_width_px, c.census_height_px);
  require(c.block_px >= 1 && c.block_px <= 15 && c.block_px % 2 == 1, "block_px", c.block_px,
          "odd, in 1..15");
  require(c.shift_px >= 0 && c.shift_px <= 65535, "shift_px", c.shift_px, "in 0..65535");
  require(c.range_px >= 1 && c.range_px <= 254, "range_px", c.range_px, "in 1..254");
  require(c.paths == 4 || c.paths == 8, "paths", c.paths, "4 or 8");
  require(c.p1 >= 0 && c.p1 <= c.p2, "p1", c.p1, "in 0..p2");
  require(c.p2 <= 4, "p2", c.p2, "at most 4");
  require(c.worst_cost > 0 && c.worst_cost <= 1, "worst_cost", c.worst_cost, "in (0, 1]");
  require(c.uniqueness >= 0 && c.uniqueness < 1, "uniqueness", c.uniqueness, "in [0, 1)");
  require(c.left_right_px <= 255, "left_right_px", c.left_right_px, "at most 255");
  require(c.texture >= 0 && std::isfinite(c.texture), "texture", c.texture, "at least 0");
}

StereoMatches match_stereo(const Image<float>& left, const Image<float>& right,
                           const StereoMatchConfig& config) {
  return match(left, right, config);
}

StereoMatches match_stereo(const Image<std::uint16_t>& left, const Image<std::uint16_t>& right,
                           const StereoMatchConfig& config) {
  return match(left, right, config);
}

Image<float> local_deviation(const Image<float>& image, int width_px, int height_px) {
  return deviation_of(image, width_px, height_px);
}

Image<float> local_deviation(const Image<std::uint16_t>& image, int width_px, int height_px) {
  return deviation_of(image, width_px, height_px);
}

}  // namespace cousin
