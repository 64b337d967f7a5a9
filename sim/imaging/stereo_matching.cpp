#include "sim/imaging/stereo_matching.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/imaging/census.h"
#include "sim/imaging/semi_global.h"
#include "sim/types/no_value.h"

namespace cousin {
namespace {

std::size_t count_of(int n) { return static_cast<std::size_t>(n); }

[[noreturn]] void reject_matching(const std::string& what) {
  throw std::invalid_argument("stereo matching: " + what);
}

void require(bool good, const char* key, double value, const char* limit) {
  if (!good)
    reject_matching(std::string(key) + " = " + std::to_string(value) + " must be " + limit);
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

/// One row of what there is to choose by.
struct RowInputs {
  const std::uint8_t* block_costs;
  const std::uint16_t *part0, *part1;   ///< of the path sums
  const float *left_bits, *right_bits;  ///< set bits of a pixel's block
};

/// Chooses the disparities of one row from the sums of its path costs.
class RowChooser {
 public:
  RowChooser(const StereoMatchConfig& config, const CostVolume& costs)
      : config_(config),
        width_(costs.width()),
        candidates_(costs.candidates()),
        stride_(costs.stride()),
        first_px_(costs.first_disparity_px()),
        bits_per_cost_(static_cast<float>(1 << costs.shift())),
        least_bits_(
            static_cast<float>(config.texture * config.block_px * config.block_px *
                               census_pairs(config.census_width_px, config.census_height_px))),
        costs_(count_of(width_) * count_of(stride_)),
        right_(count_of(width_ + candidates_)) {}

  void operator()(const RowInputs& row, float* disparity_px, float* confidence,
                  MatchReason* reason) {
    row_ = row;
    const std::size_t count = costs_.size();
    for (std::size_t i = 0; i < count; ++i)
      costs_[i] = static_cast<std::uint16_t>(row.part0[i] + row.part1[i]);
    match_right();
    for (int x = 0; x < width_; ++x) {
      disparity_px[x] = kNone;
      confidence[x] = 0;
      reason[x] = row.left_bits[x] < least_bits_ ? MatchReason::no_texture
                                                 : choose(x, disparity_px[x], confidence[x]);
    }
  }

 private:
  /// The best candidate of each pixel of the right image, among those of the left one that meet it:
  /// the cost above the candidate, so that the least is found by whole numbers.
  void match_right() {
    std::fill(right_.begin(), right_.end(), std::numeric_limits<std::uint32_t>::max());
    for (int x = 0; x < width_; ++x) {
      const std::uint16_t* costs = costs_.data() + count_of(x) * count_of(stride_);
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
    const std::uint16_t* costs = costs_.data() + count_of(x) * count_of(stride_);
    const int inside = std::clamp(x - first_px_ + 1, 0, candidates_);
    if (inside == 0) return MatchReason::out_of_range;
    const std::uint16_t least = least_of(costs, 0, inside);
    int best = 0;
    while (costs[best] != least) ++best;
    const std::uint8_t* block = row_.block_costs + count_of(x) * count_of(stride_);
    const float next = std::min(least_of(block, 0, std::max(best - 1, 0)),
                                least_of(block, std::min(best + 2, inside), inside));
    const float cost = block[best];
    confidence = cost < next ? 1 - cost / next : 0;
    if (best == 0 || best == candidates_ - 1) return MatchReason::out_of_range;
    const float apart = row_.left_bits[x] + row_.right_bits[x - first_px_ - best];
    if (cost * bits_per_cost_ > static_cast<float>(config_.worst_cost) * apart)
      return MatchReason::unlike;
    if (confidence < static_cast<float>(config_.uniqueness)) return MatchReason::ambiguous;
    if (config_.left_right_px >= 0) {
      const int other = static_cast<int>(right_[count_of(width_ - 1 - x + best)] & 0xFFU);
      if (std::abs(other - best) > config_.left_right_px) return MatchReason::left_right;
    }
    disparity_px = static_cast<float>(first_px_) + refine(x, best, inside);
    return MatchReason::none;
  }

  /// Between candidates the block's own costs decide: path sums carry the prior for whole
  /// candidates, which draws disparities towards them (by up to 0.2 px at p1 = 0.04).
  float refine(int x, int best, int inside) const {
    const std::uint8_t* costs = row_.block_costs + count_of(x) * count_of(stride_);
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
  float bits_per_cost_, least_bits_;
  RowInputs row_{};
  std::vector<std::uint16_t> costs_;
  std::vector<std::uint32_t> right_;
};

/// Set bits of the census codes of a block about each pixel, the block cut at the border.
Image<float> count_bits(const Image<std::uint64_t>& codes, int block_px) {
  const int width = codes.width(), height = codes.height(), r = block_px / 2;
  Image<float> counts(width, height);
  tbb::parallel_for(tbb::blocked_range<int>(0, height, 16), [&](const auto& range) {
    std::vector<int> column(count_of(width + 2 * r));
    for (int y = range.begin(); y < range.end(); ++y) {
      std::fill(column.begin(), column.end(), 0);
      for (int j = std::max(y - r, 0); j <= std::min(y + r, height - 1); ++j) {
        const std::uint64_t* row = codes.row(j).data();
        for (int x = 0; x < width; ++x) column[count_of(x + r)] += std::popcount(row[x]);
      }
      for (int x = 0; x < width; ++x) {
        int sum = 0;
        for (int i = x; i <= x + 2 * r; ++i) sum += column[count_of(i)];
        counts(x, y) = static_cast<float>(sum);
      }
    }
  });
  return counts;
}

template <class Pixel>
StereoMatches match(const Image<Pixel>& left, const Image<Pixel>& right,
                    const StereoMatchConfig& config) {
  validate(config);
  if (left.empty() || left.width() != right.width() || left.height() != right.height()) {
    reject_matching("images of " + std::to_string(left.width()) + " x " +
                    std::to_string(left.height()) + " and " + std::to_string(right.width()) +
                    " x " + std::to_string(right.height()));
  }
  const int width = left.width(), height = left.height();
  const auto census = [&](const Image<Pixel>& image) {
    return census_transform(image, config.census_width_px, config.census_height_px, config.margin);
  };
  const Image<std::uint64_t> left_codes = census(left), right_codes = census(right);
  const Image<float> left_bits = count_bits(left_codes, config.block_px);
  const Image<float> right_bits = count_bits(right_codes, config.block_px);
  const int pairs = census_pairs(config.census_width_px, config.census_height_px);
  // One candidate at either end only shows that the best one lies beyond.
  const CostVolume costs = hamming_costs(left_codes, right_codes, 2 * pairs, config.block_px,
                                         config.range_px + 2, config.shift_px);
  const double largest =
      std::ldexp(2.0 * pairs * config.block_px * config.block_px, -costs.shift());
  const PathSums sums =
      sum_paths(costs, config.paths, static_cast<std::uint16_t>(std::lround(config.p1 * largest)),
                static_cast<std::uint16_t>(std::lround(config.p2 * largest)));
  StereoMatches matches{Image<float>(width, height), Image<float>(width, height),
                        Image<MatchReason>(width, height)};
  const std::size_t row_size = count_of(width) * count_of(costs.stride());
  tbb::parallel_for(tbb::blocked_range<int>(0, height, 16), [&](const auto& range) {
    RowChooser choose(config, costs);
    for (int y = range.begin(); y < range.end(); ++y) {
      choose({costs.row(y), sums.part[0].get() + count_of(y) * row_size,
              sums.part[1].get() + count_of(y) * row_size, left_bits.row(y).data(),
              right_bits.row(y).data()},
             matches.disparity_px.row(y).data(), matches.confidence.row(y).data(),
             matches.reason.row(y).data());
    }
  });
  return matches;
}

}  // namespace

void validate(const StereoMatchConfig& c) {
  census_pairs(c.census_width_px, c.census_height_px);
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
  require(c.texture >= 0 && c.texture <= 1, "texture", c.texture, "in [0, 1]");
  require(c.margin >= 0 && std::isfinite(c.margin), "margin", c.margin, "at least 0");
}

StereoMatches match_stereo(const Image<float>& left, const Image<float>& right,
                           const StereoMatchConfig& config) {
  return match(left, right, config);
}

StereoMatches match_stereo(const Image<std::uint16_t>& left, const Image<std::uint16_t>& right,
                           const StereoMatchConfig& config) {
  return match(left, right, config);
}

}  // namespace cousin
