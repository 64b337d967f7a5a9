#include "tests/perception/stereo/drawn_pair.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "perception/stereo/stereo_pair.h"
#include "sim/types/rng.h"

namespace cousin {
namespace {

constexpr int kLattice = 128;

/// Smooth random brightness over the plane: bumps of three sizes.
class DrawnTexture {
 public:
  explicit DrawnTexture(const DrawnPiece& piece) : piece_(piece) {
    Rng rng = Rng(piece.texture).fork("drawn_texture");
    nodes_.resize(static_cast<std::size_t>(kLattice) * kLattice);
    for (float& node : nodes_) node = static_cast<float>(normal(rng));
  }
  double operator()(double x, double y) const {
    if (piece_.period_px > 0) x -= piece_.period_px * std::floor(x / piece_.period_px);
    double sum = 0;
    for (const double size : {1.0, 2.7, 7.9}) {
      const double u = x / (size * piece_.grain_px) + 3.3 * size,
                   v = y / (size * piece_.grain_px) + 1.7 * size;
      sum += bump(u, v);
    }
    return piece_.brightness + piece_.contrast * 0.8 * sum;
  }

 private:
  double node(int i, int j) const {
    return nodes_[static_cast<std::size_t>(j & (kLattice - 1)) * kLattice +
                  static_cast<std::size_t>(i & (kLattice - 1))];
  }
  double bump(double u, double v) const {
    const int i = static_cast<int>(std::floor(u)), j = static_cast<int>(std::floor(v));
    const auto smooth = [](double t) { return t * t * (3 - 2 * t); };
    const double a = smooth(u - i), b = smooth(v - j);
    return (1 - b) * ((1 - a) * node(i, j) + a * node(i + 1, j)) +
           b * ((1 - a) * node(i, j + 1) + a * node(i + 1, j + 1));
  }
  const DrawnPiece& piece_;
  std::vector<float> nodes_;
};

double disparity_of(const DrawnPiece& piece, double x, double y) {
  return piece.at_px + piece.per_x * x + piece.per_y * y;
}

bool covers(const DrawnPiece& piece, double x, double y) {
  const double dx = x - piece.middle_x, dy = y - piece.middle_y;
  const double c = std::cos(piece.turn_rad), s = std::sin(piece.turn_rad);
  const double u = (c * dx + s * dy) / piece.radius_x, v = (c * dy - s * dx) / piece.radius_y;
  return u * u + v * v <= 1;
}

/// What a place of an image shows.
struct Seen {
  std::size_t piece = 0;
  double left_x = 0, disparity_px = -1e9;
};

Seen seen_left(const std::vector<DrawnPiece>& pieces, double x, double y) {
  Seen best;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const double d = disparity_of(pieces[i], x, y);
    if (d > best.disparity_px && covers(pieces[i], x, y)) best = {i, x, d};
  }
  return best;
}

Seen seen_right(const std::vector<DrawnPiece>& pieces, double x, double y) {
  Seen best;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const DrawnPiece& piece = pieces[i];
    const double left_x = (x + piece.at_px + piece.per_y * y) / (1 - piece.per_x);
    if (left_x - x > best.disparity_px && covers(piece, left_x, y)) best = {i, left_x, left_x - x};
  }
  return best;
}

std::uint8_t as_code(double value) {
  return static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L));
}

}  // namespace

DrawnPair draw_pair(const std::vector<DrawnPiece>& pieces, const DrawnPairConfig& config) {
  std::vector<DrawnTexture> textures(pieces.begin(), pieces.end());
  const int width = config.width_px, height = config.height_px;
  DrawnPair pair{Image<std::uint8_t>(width, height), Image<std::uint8_t>(width, height),
                 Image<float>(width, height), Image<std::uint8_t>(width, height)};
  const Rng noise = Rng(config.seed).fork("drawn_noise");
  for (int y = 0; y < height; ++y) {
    Rng rng = noise.fork(static_cast<std::uint64_t>(y));
    for (int x = 0; x < width; ++x) {
      double left = 0, right = 0;
      for (const double dy : {-1.0 / 3, 0.0, 1.0 / 3}) {
        for (const double dx : {-1.0 / 3, 0.0, 1.0 / 3}) {
          const Seen a = seen_left(pieces, x + dx, y + dy);
          left += textures[a.piece](a.left_x, y + dy) / 9;
          const double down = y + dy - config.right_down_px;
          const Seen b = seen_right(pieces, x + dx, down);
          right += textures[b.piece](b.left_x, down) / 9;
        }
      }
      pair.left(x, y) = as_code(left + config.noise * normal(rng));
      pair.right(x, y) = as_code(config.right_gain * right + config.noise * normal(rng));
      const Seen own = seen_left(pieces, x, y);
      const double there_x = x - own.disparity_px;
      const bool is_visible =
          there_x >= 0 && there_x <= width - 1 && seen_right(pieces, there_x, y).piece == own.piece;
      pair.disparity_px(x, y) = static_cast<float>(own.disparity_px);
      pair.visible(x, y) = is_visible ? 255 : 0;
    }
  }
  return pair;
}

std::vector<DrawnPiece> drawn_clutter(std::uint64_t seed, const DrawnPairConfig& config) {
  Rng rng = Rng(seed).fork("drawn_clutter");
  std::vector<DrawnPiece> pieces = {{.at_px = uniform(rng, 4, 12),
                                     .per_x = uniform(rng, -0.02, 0.02),
                                     .per_y = uniform(rng, 0, 0.05),
                                     .texture = rng()}};
  for (int i = 0; i < 40; ++i) {
    DrawnPiece piece;
    piece.middle_x = uniform(rng, 0, config.width_px);
    piece.middle_y = uniform(rng, 0, config.height_px);
    piece.radius_x = std::exp(uniform(rng, std::log(4), std::log(60)));
    piece.radius_y = std::exp(uniform(rng, std::log(2), std::log(30)));
    piece.turn_rad = uniform(rng, 0, std::numbers::pi);
    piece.per_x = 0.15 * normal(rng);
    piece.per_y = 0.15 * normal(rng);
    piece.per_x = std::clamp(piece.per_x, -0.4, 0.4);
    piece.at_px =
        uniform(rng, 12, 60) - piece.per_x * piece.middle_x - piece.per_y * piece.middle_y;
    piece.texture = rng();
    piece.contrast = std::exp(uniform(rng, std::log(6), std::log(60)));
    piece.grain_px = uniform(rng, 1.2, 4);
    piece.brightness = uniform(rng, 60, 180);
    pieces.push_back(piece);
  }
  return pieces;
}

Capture capture_of(const DrawnPair& pair, double baseline_m) {
  return capture_of_pair(pair.left, pair.right, pair.left.width(), baseline_m);
}

}  // namespace cousin
