#include "calibration/boards/grid_growth.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <utility>

namespace cousin {
namespace {

constexpr int kBucketPx = 8;

/// Saddles by place: buckets of 8 x 8 pixels.
class SaddleIndex {
 public:
  SaddleIndex(const std::vector<Saddle>& saddles, int width, int height)
      : saddles_(saddles),
        columns_(width / kBucketPx + 1),
        rows_(height / kBucketPx + 1),
        buckets_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)) {
    for (std::size_t i = 0; i < saddles.size(); ++i) {
      const int c = bucket(saddles[i].pixel_px.x(), columns_);
      const int r = bucket(saddles[i].pixel_px.y(), rows_);
      buckets_[static_cast<std::size_t>(r * columns_ + c)].push_back(static_cast<int>(i));
    }
  }

  /// Calls visit(index) for the saddles in the buckets that a disc touches, in a fixed order.
  template <class Visit>
  void near(const Eigen::Vector2d& centre, double radius, const Visit& visit) const {
    if (!centre.allFinite()) return;
    const int c0 = bucket(centre.x() - radius, columns_),
              c1 = bucket(centre.x() + radius, columns_);
    const int r0 = bucket(centre.y() - radius, rows_), r1 = bucket(centre.y() + radius, rows_);
    for (int r = r0; r <= r1; ++r) {
      for (int c = c0; c <= c1; ++c) {
        for (const int i : buckets_[static_cast<std::size_t>(r * columns_ + c)]) visit(i);
      }
    }
  }

  const Saddle& operator[](int i) const { return saddles_[static_cast<std::size_t>(i)]; }

 private:
  static int bucket(double x, int count) {
    return static_cast<int>(std::clamp(std::floor(x / kBucketPx), 0.0, count - 1.0));
  }
  const std::vector<Saddle>& saddles_;
  int columns_, rows_;
  std::vector<std::vector<int>> buckets_;
};

/// +1 for corners of the same kind, -1 for neighbours: one square on, a checkerboard is its own
/// negative, however it is foreshortened and blurred. (The directions in which the Hessian vanishes
/// are no such invariant: blur takes more of the finer of the board's two diagonal waves, and turns
/// them.)
double likeness(const Saddle& a, const Saddle& b) {
  return a.hessian.cwiseProduct(b.hessian).sum() / (a.hessian.norm() * b.hessian.norm());
}

float bilinear(const Image<float>& image, const Eigen::Vector2d& at) {
  const int x = static_cast<int>(std::floor(at.x())), y = static_cast<int>(std::floor(at.y()));
  if (!image.contains(x, y) || !image.contains(x + 1, y + 1)) return 0;
  const float u = static_cast<float>(at.x() - x), v = static_cast<float>(at.y() - y);
  return (1 - v) * ((1 - u) * image(x, y) + u * image(x + 1, y)) +
         v * ((1 - u) * image(x, y + 1) + u * image(x + 1, y + 1));
}

/// How far the image strays from one value on the way between two corners, over its spread beside
/// the way: small along an edge of a square, about one across squares.
double straying(const Image<float>& image, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                double spread) {
  const float level = 0.5F * (bilinear(image, from) + bilinear(image, to));
  double sum = 0;
  constexpr std::array<double, 6> kPlaces = {0.15, 0.28, 0.41, 0.59, 0.72, 0.85};
  for (const double t : kPlaces)
    sum += std::pow(bilinear(image, from + t * (to - from)) - level, 2);
  return std::sqrt(sum / kPlaces.size()) / spread;
}

double spread_around(const Image<float>& image, const Eigen::Vector2d& centre, int radius) {
  const int cx = static_cast<int>(std::lround(centre.x())),
            cy = static_cast<int>(std::lround(centre.y()));
  double n = 0, sum = 0, squares = 0;
  for (int y = cy - radius; y <= cy + radius; ++y) {
    for (int x = cx - radius; x <= cx + radius; ++x) {
      if (!image.contains(x, y)) continue;
      n += 1, sum += image(x, y), squares += image(x, y) * image(x, y);
    }
  }
  return std::sqrt(std::max(1e-12, squares / n - sum * sum / (n * n)));
}

/// Lattice under construction: a square table with its origin in the middle.
class Lattice {
 public:
  explicit Lattice(int max_extent)
      : max_extent_(max_extent),
        side_(2 * max_extent + 1),
        cells_(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_), -1) {}

  int at(int column, int row) const {
    if (std::abs(column) > max_extent_ || std::abs(row) > max_extent_) return -1;
    return cells_[index(column, row)];
  }
  void set(int column, int row, int saddle) {
    cells_[index(column, row)] = saddle;
    places_.push_back({column, row});
    low_ = {std::min(low_[0], column), std::min(low_[1], row)};
    high_ = {std::max(high_[0], column), std::max(high_[1], row)};
  }
  bool fits(int column, int row) const {
    return std::max(high_[0], column) - std::min(low_[0], column) < max_extent_ &&
           std::max(high_[1], row) - std::min(low_[1], row) < max_extent_;
  }
  const std::vector<std::array<int, 2>>& places() const { return places_; }

 private:
  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>((row + max_extent_) * side_ + column + max_extent_);
  }
  int max_extent_, side_;
  std::vector<int> cells_;
  std::vector<std::array<int, 2>> places_;
  std::array<int, 2> low_{0, 0}, high_{0, 0};
};

struct LocalAffine {
  Eigen::Vector2d origin;  ///< predicted pixel of the place asked for
  Eigen::Matrix2d steps;   ///< columns: one step along column and row
};

/// Affine map fitted to the known corners within two steps of a place.
std::optional<LocalAffine> local_affine(const Lattice& lattice, const SaddleIndex& saddles,
                                        int column, int row) {
  Eigen::Matrix3d ata = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 3, 2> atb = Eigen::Matrix<double, 3, 2>::Zero();
  for (int dr = -2; dr <= 2; ++dr) {
    for (int dc = -2; dc <= 2; ++dc) {
      const int i = lattice.at(column + dc, row + dr);
      if (i < 0) continue;
      const double weight = 1.0 / (dr * dr + dc * dc);
      const Eigen::Vector3d a(1, dc, dr);
      ata += weight * a * a.transpose();
      atb += weight * a * saddles[i].pixel_px.transpose();
    }
  }
  const Eigen::FullPivLU<Eigen::Matrix3d> lu(ata);
  if (lu.rcond() < 1e-4) return std::nullopt;  // on a line
  const Eigen::Matrix<double, 3, 2> x = lu.solve(atb);
  LocalAffine affine;
  affine.origin = x.row(0).transpose();
  affine.steps << x.row(1).transpose(), x.row(2).transpose();
  return affine;
}

/// The free saddle nearest to a predicted place, of the expected kind and within 0.3 of a step.
int match(const SaddleIndex& saddles, const std::vector<std::uint8_t>& taken,
          const LocalAffine& affine, const Saddle& seed, double sign) {
  constexpr double kTolerance = 0.3, kLikeness = 0.3;
  if (std::abs(affine.steps.determinant()) < 0.5) return -1;
  const Eigen::Matrix2d inverse = affine.steps.inverse();
  const double radius = kTolerance * (affine.steps.col(0).norm() + affine.steps.col(1).norm());
  int best = -1;
  double best_error = kTolerance;
  saddles.near(affine.origin, radius, [&](int i) {
    if (taken[static_cast<std::size_t>(i)] != 0) return;
    const double error = (inverse * (saddles[i].pixel_px - affine.origin)).norm();
    if (error >= best_error || sign * likeness(saddles[i], seed) < kLikeness) return;
    best = i;
    best_error = error;
  });
  return best;
}

/// Saddles of the other kind that an edge joins to the seed, nearest first.
std::vector<int> edge_neighbours(const Image<float>& image, const SaddleIndex& saddles, int seed,
                                 double reach_px) {
  constexpr std::size_t kMost = 48;
  constexpr double kLikeness = -0.6, kStraying = 0.35;
  const Eigen::Vector2d at = saddles[seed].pixel_px;
  std::vector<std::pair<double, int>> near;
  saddles.near(at, reach_px, [&](int i) {
    if (i != seed) near.emplace_back((saddles[i].pixel_px - at).norm(), i);
  });
  std::sort(near.begin(), near.end());
  if (near.size() > kMost) near.resize(kMost);
  std::vector<int> result;
  for (const auto& [distance, i] : near) {
    if (distance < 1.2 || likeness(saddles[i], saddles[seed]) > kLikeness) continue;
    const double spread = spread_around(image, at, static_cast<int>(std::ceil(distance)));
    if (straying(image, at, saddles[i].pixel_px, spread) < kStraying) result.push_back(i);
  }
  return result;
}

/// Four corners of a cell at saddle `seed`, or false.
bool seed_cell(const Image<float>& image, const SaddleIndex& saddles,
               std::vector<std::uint8_t>& taken, int seed, double reach_px, Lattice& lattice) {
  constexpr double kSine = 0.12;  // least between the two edges of a cell
  const std::vector<int> ends = edge_neighbours(image, saddles, seed, reach_px);
  const Eigen::Vector2d at = saddles[seed].pixel_px;
  int tried = 0;
  for (std::size_t a = 0; a < ends.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      Eigen::Vector2d u = saddles[ends[a]].pixel_px - at, v = saddles[ends[b]].pixel_px - at;
      const double cross = u.x() * v.y() - u.y() * v.x();
      if (std::abs(cross) < kSine * u.norm() * v.norm()) continue;
      if (++tried > 6) return false;
      int right = ends[a], up = ends[b];
      // Right-handed as seen from the printed side: in the image, whose y points down, the turn is
      // negative.
      if (cross > 0) std::swap(u, v), std::swap(right, up);
      LocalAffine affine;
      affine.steps << u, v;
      affine.origin = at + u + v;
      const int across = match(saddles, taken, affine, saddles[seed], 1);
      if (across < 0 || across == seed) continue;
      for (const int i : {seed, right, up, across}) taken[static_cast<std::size_t>(i)] = 1;
      lattice.set(0, 0, seed);
      lattice.set(1, 0, right);
      lattice.set(0, 1, up);
      lattice.set(1, 1, across);
      return true;
    }
  }
  return false;
}

void grow(const SaddleIndex& saddles, std::vector<std::uint8_t>& taken, const Saddle& seed,
          Lattice& lattice) {
  constexpr std::array<std::array<int, 2>, 4> kSides = {{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
  bool added = true;
  while (added) {
    added = false;
    for (std::size_t k = 0; k < lattice.places().size(); ++k) {
      for (const auto& side : kSides) {
        const int column = lattice.places()[k][0] + side[0], row = lattice.places()[k][1] + side[1];
        if (!lattice.fits(column, row) || lattice.at(column, row) >= 0) continue;
        const std::optional<LocalAffine> affine = local_affine(lattice, saddles, column, row);
        if (!affine) continue;
        const double parity = (column + row) % 2 == 0 ? 1 : -1;
        const int found = match(saddles, taken, *affine, seed, parity);
        if (found < 0) continue;
        taken[static_cast<std::size_t>(found)] = 1;
        lattice.set(column, row, found);
        added = true;
      }
    }
  }
}

}  // namespace

std::vector<Saddle> find_saddles(const Image<float>& image, double smoothing_px, double minimum) {
  const int width = image.width(), height = image.height();
  std::vector<Saddle> saddles;
  if (width < 5 || height < 5) return saddles;
  const cv::Mat source(height, width, CV_32F, const_cast<float*>(image.data()));
  cv::Mat f;
  const int size = 2 * static_cast<int>(std::ceil(3 * smoothing_px)) + 1;
  cv::GaussianBlur(source, f, cv::Size(size, size), smoothing_px, smoothing_px,
                   cv::BORDER_REPLICATE);
  cv::Mat response(height, width, CV_32F, cv::Scalar(0));
  const auto second = [&](int x, int y) {
    const float* up = f.ptr<float>(y - 1) + x;
    const float* mid = f.ptr<float>(y) + x;
    const float* down = f.ptr<float>(y + 1) + x;
    return std::array<float, 3>{mid[1] - 2 * mid[0] + mid[-1], down[0] - 2 * mid[0] + up[0],
                                0.25F * (down[1] - down[-1] - up[1] + up[-1])};
  };
  for (int y = 1; y < height - 1; ++y) {
    float* out = response.ptr<float>(y);
    for (int x = 1; x < width - 1; ++x) {
      const auto [xx, yy, xy] = second(x, y);
      out[x] = xy * xy - xx * yy;
    }
  }
  const float threshold = static_cast<float>(minimum * minimum);
  for (int y = 2; y < height - 2; ++y) {
    const float* r = response.ptr<float>(y);
    for (int x = 2; x < width - 2; ++x) {
      const float v = r[x];
      if (v < threshold || v < r[x - 1] || v <= r[x + 1]) continue;
      const float* a = response.ptr<float>(y - 1) + x;
      const float* b = response.ptr<float>(y + 1) + x;
      if (v < a[-1] || v < a[0] || v < a[1] || v <= b[-1] || v <= b[0] || v <= b[1]) continue;
      const auto [xx, yy, xy] = second(x, y);
      Saddle s;
      s.hessian << xx, xy, xy, yy;
      const Eigen::Vector2d gradient(0.5 * (f.at<float>(y, x + 1) - f.at<float>(y, x - 1)),
                                     0.5 * (f.at<float>(y + 1, x) - f.at<float>(y - 1, x)));
      const Eigen::Vector2d step = -s.hessian.inverse() * gradient;
      if (!(step.cwiseAbs().maxCoeff() < 1.0)) continue;  // an edge's end, not a crossing
      s.pixel_px = Eigen::Vector2d(x, y) + step;
      s.strength = std::sqrt(v);
      saddles.push_back(s);
    }
  }
  std::stable_sort(saddles.begin(), saddles.end(),
                   [](const Saddle& a, const Saddle& b) { return a.strength > b.strength; });
  return saddles;
}

std::vector<LatticeCorner> grow_lattice(const Image<float>& image,
                                        const std::vector<Saddle>& saddles, int max_extent,
                                        double reach_share) {
  constexpr int kMaxTries = 200;
  const SaddleIndex index(saddles, image.width(), image.height());
  const double reach_px = reach_share * image.width();
  const std::size_t enough = static_cast<std::size_t>(max_extent * max_extent / 2);
  std::vector<std::uint8_t> tried(saddles.size(), 0);
  std::vector<LatticeCorner> best;
  int tries = 0;
  for (std::size_t seed = 0; seed < saddles.size() && tries < kMaxTries && best.size() < enough;
       ++seed) {
    if (tried[seed] != 0) continue;
    ++tries;
    Lattice lattice(max_extent);
    std::vector<std::uint8_t> taken(saddles.size(), 0);
    if (!seed_cell(image, index, taken, static_cast<int>(seed), reach_px, lattice)) continue;
    const std::optional<LocalAffine> start = local_affine(lattice, index, 2, 2);
    if (!start) continue;
    const double seed_mixed = start->steps.col(0).dot(saddles[seed].hessian * start->steps.col(1));
    grow(index, taken, saddles[seed], lattice);
    if (lattice.places().size() > 12) {
      for (std::size_t i = 0; i < taken.size(); ++i) tried[i] |= taken[i];
    }
    if (lattice.places().size() <= best.size()) continue;
    best.clear();
    for (const auto& [column, row] : lattice.places()) {
      const Saddle& s = index[lattice.at(column, row)];
      // The image is convex towards the brighter squares: a negative mixed derivative means dark
      // ahead.
      const bool dark = ((column + row) % 2 == 0 ? seed_mixed : -seed_mixed) < 0;
      best.push_back({column, row, s.pixel_px, dark});
    }
  }
  return best;
}

}  // namespace cousin
