#include "sim/imaging/semi_global.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <bit>
#include <vector>

namespace cousin {
namespace {

/// Candidates are handled in whole vectors of this many.
constexpr int kVector = 16;
/// Above every path cost, with room for a penalty on top.
constexpr std::uint16_t kNoPath = 0x3FFF;

std::size_t size(int n) { return static_cast<std::size_t>(n); }

/// Hamming distances of one row, summed over the block's columns.
class RowCosts {
 public:
  RowCosts(int width, int stride, int candidates, int first_px, int bits, int radius)
      : width_(width),
        stride_(stride),
        candidates_(candidates),
        first_px_(first_px),
        bits_(static_cast<std::uint8_t>(bits)),
        radius_(radius),
        reversed_(size(width)),
        hamming_(size(width) * size(stride)),
        running_(size(stride)) {}

  void operator()(std::span<const std::uint64_t> left, std::span<const std::uint64_t> right,
                  std::uint16_t* sums) {
    // Reversed, so that candidates of one pixel lie one after the other.
    std::reverse_copy(right.begin(), right.end(), reversed_.begin());
    for (int x = 0; x < width_; ++x) {
      std::uint8_t* out = hamming_.data() + size(x) * size(stride_);
      const int inside = std::clamp(x - first_px_ + 1, 0, candidates_);
      const std::uint64_t code = left[size(x)];
      const std::uint64_t* other = reversed_.data() + (width_ - 1 - x + first_px_);
      for (int i = 0; i < inside; ++i)
        out[i] = static_cast<std::uint8_t>(std::popcount(code ^ other[i]));
      std::fill(out + inside, out + stride_, bits_);
    }
    std::fill(running_.begin(), running_.end(), std::uint16_t{0});
    for (int k = -radius_; k <= radius_; ++k) add(k, 1);
    for (int x = 0; x < width_; ++x) {
      std::copy(running_.begin(), running_.end(), sums + size(x) * size(stride_));
      add(x + radius_ + 1, 1);
      add(x - radius_, -1);
    }
  }

 private:
  void add(int x, int sign) {  // columns beyond the border repeat the border's
    const std::uint8_t* from = hamming_.data() + size(std::clamp(x, 0, width_ - 1)) * size(stride_);
    std::uint16_t* to = running_.data();
    if (sign > 0) {
      for (int i = 0; i < stride_; ++i) to[i] = static_cast<std::uint16_t>(to[i] + from[i]);
    } else {
      for (int i = 0; i < stride_; ++i) to[i] = static_cast<std::uint16_t>(to[i] - from[i]);
    }
  }

  int width_, stride_, candidates_, first_px_;
  std::uint8_t bits_;
  int radius_;
  std::vector<std::uint64_t> reversed_;
  std::vector<std::uint8_t> hamming_;
  std::vector<std::uint16_t> running_;
};

/// One step of a path: costs of a pixel from those of the pixel before, with `p1` for a change of
/// one candidate and `p2` for any other. `before` may be read one element either side.
struct Penalties {
  std::uint16_t p1, p2;
};

inline std::uint16_t step(const std::uint8_t* __restrict cost,
                          const std::uint16_t* __restrict before, std::uint16_t before_least,
                          std::uint16_t* __restrict after, std::uint16_t* __restrict sum,
                          int stride, Penalties penalties) {
  const std::uint16_t p1 = penalties.p1;
  const auto jump = static_cast<std::uint16_t>(before_least + penalties.p2);
  std::uint16_t least = kNoPath;
  for (int i = 0; i < stride; ++i) {
    const auto down = static_cast<std::uint16_t>(before[i - 1] + p1);
    const auto up = static_cast<std::uint16_t>(before[i + 1] + p1);
    const std::uint16_t near = std::min(before[i], std::min(down, up));
    const std::uint16_t way = std::min(near, jump);
    const auto value = static_cast<std::uint16_t>(cost[i] + way - before_least);
    after[i] = value;
    sum[i] = static_cast<std::uint16_t>(sum[i] + value);
    least = std::min(least, value);
  }
  return least;
}

/// Path costs of a row of pixels, with a margin on either side of each pixel and of the row.
class PathRow {
 public:
  PathRow(int width, int stride)
      : pitch_(size(stride) + 2 * kVector),
        values_((size(width) + 2) * pitch_, kNoPath),
        least_(size(width) + 2, 0) {
    // Beyond the border a path starts anew: all candidates cost nothing.
    for (const std::size_t x : {std::size_t{0}, size(width) + 1})
      std::fill_n(values_.begin() + static_cast<std::ptrdiff_t>(x * pitch_) + kVector, stride,
                  std::uint16_t{0});
  }
  /// Of pixel x, from -1 to width.
  std::uint16_t* at(int x) { return values_.data() + size(x + 1) * pitch_ + kVector; }
  std::uint16_t& least(int x) { return least_[size(x + 1)]; }
  void start(int width, int stride) {
    for (int x = 0; x < width; ++x) {
      std::fill_n(at(x), stride, std::uint16_t{0});
      least(x) = 0;
    }
  }

 private:
  std::size_t pitch_;
  std::vector<std::uint16_t> values_;
  std::vector<std::uint16_t> least_;
};

/// Both paths along a row.
void sum_row(const CostVolume& costs, int y, Penalties penalties, std::uint16_t* sums) {
  const int stride = costs.stride();
  PathRow path(2, stride);
  const std::uint8_t* row = costs.row(y);
  std::fill_n(sums, size(costs.width()) * size(stride), std::uint16_t{0});
  for (const int direction : {1, -1}) {
    path.start(2, stride);
    int now = 0;
    for (int k = 0; k < costs.width(); ++k, now = 1 - now) {
      const std::size_t x = size(direction > 0 ? k : costs.width() - 1 - k) * size(stride);
      path.least(now) = step(row + x, path.at(1 - now), path.least(1 - now), path.at(now), sums + x,
                             stride, penalties);
    }
  }
}

/// The paths that come from the row before: straight, or with both diagonals.
void sum_columns(const CostVolume& costs, bool downwards, bool diagonals, Penalties penalties,
                 std::uint16_t* sums) {
  const int width = costs.width(), stride = costs.stride();
  const std::size_t row_size = size(width) * size(stride);
  struct Path {
    int dx;
    PathRow before, after;
  };
  std::vector<Path> paths;
  for (const int dx : {0, -1, 1}) {
    if (dx != 0 && !diagonals) continue;
    paths.push_back({dx, PathRow(width, stride), PathRow(width, stride)});
    paths.back().before.start(width, stride);
  }
  for (int k = 0; k < costs.height(); ++k) {
    const int y = downwards ? k : costs.height() - 1 - k;
    std::uint16_t* out = sums + size(y) * row_size;
    const std::uint8_t* row = costs.row(y);
    for (int x = 0; x < width; ++x) {
      const std::size_t at = size(x) * size(stride);
      for (Path& path : paths) {
        path.after.least(x) =
            step(row + at, path.before.at(x + path.dx), path.before.least(x + path.dx),
                 path.after.at(x), out + at, stride, penalties);
      }
    }
    for (Path& path : paths) std::swap(path.before, path.after);
  }
}

}  // namespace

CostVolume::CostVolume(int width, int height, int candidates, int first_disparity_px)
    : width_(width),
      height_(height),
      candidates_(candidates),
      first_disparity_px_(first_disparity_px),
      stride_((candidates + kVector - 1) / kVector * kVector),
      costs_(std::make_unique_for_overwrite<std::uint8_t[]>(size(width) * size(height) *
                                                            size(stride_))) {}

CostVolume hamming_costs(const Image<std::uint64_t>& left, const Image<std::uint64_t>& right,
                         int bits, int block_px, int candidates, int first_disparity_px) {
  CostVolume costs(left.width(), left.height(), candidates, first_disparity_px);
  const int radius = block_px / 2, height = left.height(), stride = costs.stride();
  const std::size_t row_size = size(left.width()) * size(stride);
  int shift = 0;
  while ((bits * block_px * block_px) >> shift > 255) ++shift;
  costs.set_shift(shift);
  tbb::parallel_for(tbb::blocked_range<int>(0, height, 32), [&](const auto& range) {
    RowCosts row_costs(left.width(), stride, candidates, first_disparity_px, bits, radius);
    std::vector<std::uint16_t> ring(size(block_px) * row_size);
    const auto slot = [&](int y) { return ring.data() + size((y + radius) % block_px) * row_size; };
    int next = range.begin() - radius;
    for (int y = range.begin(); y < range.end(); ++y) {
      for (; next <= y + radius; ++next) {
        const int from = std::clamp(next, 0, height - 1);
        row_costs(left.row(from), right.row(from), slot(next));
      }
      std::uint8_t* out = costs.row(y);
      std::vector<const std::uint16_t*> rows;
      for (int k = -radius; k <= radius; ++k) rows.push_back(slot(y + k));
      for (std::size_t first = 0; first < row_size; first += size(stride)) {
        std::uint16_t total[kVector];
        for (std::size_t i = first; i < first + size(stride); i += kVector) {
          std::fill_n(total, kVector, std::uint16_t{0});
          for (const std::uint16_t* row : rows) {
            for (int j = 0; j < kVector; ++j)
              total[j] = static_cast<std::uint16_t>(total[j] + row[i + size(j)]);
          }
          for (int j = 0; j < kVector; ++j)
            out[i + size(j)] = static_cast<std::uint8_t>(total[j] >> shift);
        }
      }
    }
  });
  return costs;
}

PathSums sum_paths(const CostVolume& costs, int paths, std::uint16_t p1, std::uint16_t p2) {
  const std::size_t row_size = size(costs.width()) * size(costs.stride());
  const std::size_t total = row_size * size(costs.height());
  PathSums sums;
  for (auto& part : sums.part) part = std::make_unique_for_overwrite<std::uint16_t[]>(total);
  const Penalties penalties{p1, p2};
  const bool diagonals = paths == 8;
  tbb::parallel_for(tbb::blocked_range<int>(0, costs.height(), 8), [&](const auto& range) {
    for (int y = range.begin(); y < range.end(); ++y) {
      sum_row(costs, y, penalties, sums.part[0].get() + size(y) * row_size);
      std::fill_n(sums.part[1].get() + size(y) * row_size, row_size, std::uint16_t{0});
    }
  });
  tbb::parallel_invoke(
      [&] { sum_columns(costs, true, diagonals, penalties, sums.part[0].get()); },
      [&] { sum_columns(costs, false, diagonals, penalties, sums.part[1].get()); });
  return sums;
}

}  // namespace cousin
