#include "perception/mvs/patch_score.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "perception/mvs/reference_depth.h"

namespace cousin {
namespace {

/// Difference of chroma at which a pixel counts little. Luma has no say: its edges are the texture
/// that is matched, on the board above all, while chroma tells a coloured object from the grey
/// board.
constexpr float kChromaSigma = 0.06F;
/// A window in which fewer pixels than this are like the middle one is on the rim of something.
constexpr float kLeastSamples = 7;
/// Share of the contrast's variance that views of different sharpness do not have in common.
constexpr float kUnlikeness = 0.001F;

}  // namespace

PatchScorer::PatchScorer(const std::vector<MvsView>& views, int reference,
                         const std::vector<int>& neighbours, int window_px)
    : view_(views[static_cast<std::size_t>(reference)]), radius_(window_px / 2) {
  for (const int i : neighbours) {
    const MvsView& other = views[static_cast<std::size_t>(i)];
    neighbours_.push_back({warp_between(view_, other), &other.pinhole_luma});
  }
  counted_ = counted_neighbours(static_cast<int>(neighbours.size()));
  ray_step_ = 1.0F / view_.focal_px.x();
  taps_ = (window_px * window_px + kLanes - 1) / kLanes * kLanes;
  const float sigma = std::max(1.0F, 0.5F * static_cast<float>(window_px));
  for (int dy = -radius_; dy <= radius_; ++dy) {
    for (int dx = -radius_; dx <= radius_; ++dx) {
      const float r2 = static_cast<float>(dx * dx + dy * dy);
      distance_weight_.push_back(-0.5F * r2 / (sigma * sigma));
    }
  }
}

void PatchScorer::move_to(int x, int y) {
  const float centre_b = view_.chroma_b(x, y), centre_r = view_.chroma_r(x, y);
  centre_x_ = view_.ray_x(x, y);
  centre_y_ = view_.ray_y(x, y);
  std::size_t tap = 0;
  for (int dy = -radius_; dy <= radius_; ++dy) {
    for (int dx = -radius_; dx <= radius_; ++dx, ++tap) {
      const float b = (view_.chroma_b(x + dx, y + dy) - centre_b) / kChromaSigma;
      const float r = (view_.chroma_r(x + dx, y + dy) - centre_r) / kChromaSigma;
      const float ray_x = view_.ray_x(x + dx, y + dy), ray_y = view_.ray_y(x + dx, y + dy);
      const bool known = std::isfinite(ray_x);
      ray_x_[tap] = known ? ray_x : centre_x_;
      ray_y_[tap] = known ? ray_y : centre_y_;
      value_[tap] = view_.luma(x + dx, y + dy);
      detail_[tap] = view_.detail(x + dx, y + dy);
      likeness_[tap] = known ? -0.5F * (b * b + r * r) : -100.0F;
    }
  }
  // A pixel counts as little as its least like neighbour: pixels on a rim mix both sides.
  tap = 0;
  for (int dy = -radius_; dy <= radius_; ++dy) {
    for (int dx = -radius_; dx <= radius_; ++dx, ++tap) {
      const std::size_t side = static_cast<std::size_t>(2 * radius_ + 1);
      float least = likeness_[tap];
      if (dx > -radius_) least = std::min(least, likeness_[tap - 1]);
      if (dx < radius_) least = std::min(least, likeness_[tap + 1]);
      if (dy > -radius_) least = std::min(least, likeness_[tap - side]);
      if (dy < radius_) least = std::min(least, likeness_[tap + side]);
      weight_[tap] = std::exp(distance_weight_[tap] + std::max(least, -20.0F));
    }
  }
  for (; tap < static_cast<std::size_t>(taps_); ++tap) {
    ray_x_[tap] = centre_x_;
    ray_y_[tap] = centre_y_;
    value_[tap] = 0;
    detail_[tap] = 0;
    weight_[tap] = 0;
  }
  float sum = 0, squares = 0, s1 = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(taps_); ++i) {
    dx_[i] = ray_x_[i] - centre_x_;
    dy_[i] = ray_y_[i] - centre_y_;
    sum += weight_[i];
    squares += weight_[i] * weight_[i];
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(taps_); ++i) {
    weight_[i] /= sum;
    s1 += weight_[i] * value_[i];
  }
  effective_samples_ = sum * sum / squares;
  mean_ = s1;
  // Values and details about their means, values without the part that more or less blur explains.
  const float detail_mean = weighted_sum(detail_);
  for (std::size_t i = 0; i < static_cast<std::size_t>(taps_); ++i) {
    value_[i] -= mean_;
    detail_[i] -= detail_mean;
  }
  inverse_detail_ = 1 / (weighted_dot(detail_, detail_) + kNoiseVariance);
  const float share = weighted_dot(value_, detail_) * inverse_detail_;
  for (std::size_t i = 0; i < static_cast<std::size_t>(taps_); ++i) value_[i] -= share * detail_[i];
  variance_ = effective_samples_ < kLeastSamples ? 0 : weighted_dot(value_, value_);
}

/// Looks up the neighbour's image where each tap's ray meets the patch. With slopes, (d_x, d_y) is
/// how far that point moves for a change of inverse depth by one.
template <bool kSlopes>
void PatchScorer::place(const Neighbour& neighbour, const SurfacePatch& patch, LookUp& look_up,
                        float* d_x, float* d_y) const {
  const Eigen::Matrix3f& a = neighbour.warp.from_ray;
  const Eigen::Vector3f& b = neighbour.warp.from_inverse_depth;
  const float a00 = a(0, 0), a01 = a(0, 1), a02 = a(0, 2), b0 = b(0);
  const float a10 = a(1, 0), a11 = a(1, 1), a12 = a(1, 2), b1 = b(1);
  const float a20 = a(2, 0), a21 = a(2, 1), a22 = a(2, 2), b2 = b(2);
  const SurfacePatch p = patch;
  for (std::size_t k = 0; k < static_cast<std::size_t>(taps_); ++k) {
    const float w = p.inverse_depth +
                    dx_[k] * (p.slope_x + 0.5F * p.bend_xx * dx_[k] + p.bend_xy * dy_[k]) +
                    dy_[k] * (p.slope_y + 0.5F * p.bend_yy * dy_[k]);
    const float z = a20 * ray_x_[k] + a21 * ray_y_[k] + a22 + b2 * w;
    const float in_front = z > 0 ? 1.0F / z : std::numeric_limits<float>::quiet_NaN();
    const float x = (a00 * ray_x_[k] + a01 * ray_y_[k] + a02 + b0 * w) * in_front;
    const float y = (a10 * ray_x_[k] + a11 * ray_y_[k] + a12 + b1 * w) * in_front;
    look_up.x[k] = x;
    look_up.y[k] = y;
    if constexpr (kSlopes) {
      d_x[k] = z > 0 ? (b0 - x * b2) * in_front : 0.0F;
      d_y[k] = z > 0 ? (b1 - y * b2) * in_front : 0.0F;
    }
  }
  look_up.run<kSlopes>(*neighbour.image, static_cast<std::size_t>(taps_));
}

float PatchScorer::correlation(const Neighbour& neighbour, const SurfacePatch& patch) const {
  LookUp look_up;
  place<false>(neighbour, patch, look_up, nullptr, nullptr);
  const Taps& seen = look_up.value;
  std::array<float, kLanes> l1{}, l2{}, l3{}, l4{};
  for (std::size_t block = 0; block < static_cast<std::size_t>(taps_); block += kLanes) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const float w = weight_[block + lane] * seen[block + lane];
      l1[lane] += w;
      l2[lane] += w * seen[block + lane];
      l3[lane] += w * value_[block + lane];
      l4[lane] += w * detail_[block + lane];
    }
  }
  float s1 = 0, s2 = 0, s3 = 0, s4 = 0;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    s1 += l1[lane];
    s2 += l2[lane];
    s3 += l3[lane];
    s4 += l4[lane];
  }
  // The reference's values have no mean and no detail; the neighbour's variance is freed of both
  // here.
  const float variance = std::max(0.0F, s2 - s1 * s1 - s4 * s4 * inverse_detail_);
  return s3 / std::sqrt((variance + kNoiseVariance) * (variance_ + kNoiseVariance));
}

float PatchScorer::score(const SurfacePatch& patch) const {
  std::array<float, kMostNeighbours> scores;
  const std::size_t count = std::min<std::size_t>(neighbours_.size(), kMostNeighbours);
  for (std::size_t i = 0; i < count; ++i) scores[i] = correlation(neighbours_[i], patch);
  std::sort(scores.begin(), scores.begin() + static_cast<std::ptrdiff_t>(count), std::greater<>());
  float sum = 0;
  for (int i = 0; i < counted_; ++i) sum += scores[static_cast<std::size_t>(i)];
  return sum / static_cast<float>(counted_);
}

float PatchScorer::weighted_sum(const Taps& a) const {
  std::array<float, kLanes> sums{};
  for (std::size_t block = 0; block < static_cast<std::size_t>(taps_); block += kLanes) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      sums[lane] += weight_[block + lane] * a[block + lane];
    }
  }
  float sum = 0;
  for (const float s : sums) sum += s;
  return sum;
}

float PatchScorer::weighted_dot(const Taps& a, const Taps& b) const {
  std::array<float, kLanes> sums{};
  for (std::size_t block = 0; block < static_cast<std::size_t>(taps_); block += kLanes) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      sums[lane] += weight_[block + lane] * a[block + lane] * b[block + lane];
    }
  }
  float sum = 0;
  for (const float s : sums) sum += s;
  return sum;
}

/// Of (inverse depth, slopes times one pixel's ray step).
struct PatchScorer::NormalEquations {
  Eigen::Matrix3f matrix = Eigen::Matrix3f::Zero();
  Eigen::Vector3f right = Eigen::Vector3f::Zero();
};

void PatchScorer::add_equations(const Neighbour& neighbour, const SurfacePatch& patch,
                                NormalEquations& sum) const {
  const auto taps = static_cast<std::size_t>(taps_);
  LookUp look_up;
  alignas(32) Taps residual;
  alignas(32) std::array<Taps, 3> jacobian;
  place<true>(neighbour, patch, look_up, jacobian[1].data(), jacobian[2].data());
  Taps& seen = look_up.value;
  for (std::size_t i = 0; i < taps; ++i) {
    jacobian[0][i] = look_up.d_x[i] * jacobian[1][i] + look_up.d_y[i] * jacobian[2][i];
  }
  const float mean = weighted_sum(seen), share = weighted_dot(seen, detail_) * inverse_detail_;
  for (std::size_t i = 0; i < taps; ++i) seen[i] -= mean + share * detail_[i];
  const float variance = weighted_dot(seen, seen);
  const float gain =
      std::max(0.0F, weighted_dot(seen, value_)) / (variance + 0.1F * kNoiseVariance);
  for (std::size_t i = 0; i < taps; ++i) {
    residual[i] = value_[i] - gain * seen[i];
    jacobian[0][i] *= gain;
    jacobian[1][i] = jacobian[0][i] * dx_[i] / ray_step_;
    jacobian[2][i] = jacobian[0][i] * dy_[i] / ray_step_;
  }
  // What an offset, a change of blur or a gain could explain is not depth.
  for (Taps& column : jacobian) {
    const float offset = weighted_sum(column);
    const float blur = weighted_dot(column, detail_) * inverse_detail_;
    for (std::size_t i = 0; i < taps; ++i) column[i] -= offset + blur * detail_[i];
    const float along = weighted_dot(column, seen) / (variance + 0.1F * kNoiseVariance);
    for (std::size_t i = 0; i < taps; ++i) column[i] -= along * seen[i];
  }
  const float noise = weighted_dot(residual, residual) + kNoiseVariance * (1 + gain * gain) +
                      kUnlikeness * variance_;
  const float weight = effective_samples_ / noise;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    sum.right[row] += weight * weighted_dot(jacobian[i], residual);
    for (std::size_t j = i; j < 3; ++j) {
      const auto column = static_cast<Eigen::Index>(j);
      sum.matrix(row, column) += weight * weighted_dot(jacobian[i], jacobian[j]);
      sum.matrix(column, row) = sum.matrix(row, column);
    }
  }
}

PatchScorer::Fit PatchScorer::fit(const SurfacePatch& start, float slope_sigma,
                                  int iterations) const {
  std::array<std::pair<float, std::size_t>, kMostNeighbours> ranked;
  const std::size_t count = std::min<std::size_t>(neighbours_.size(), kMostNeighbours);
  for (std::size_t i = 0; i < count; ++i) ranked[i] = {-correlation(neighbours_[i], start), i};
  std::sort(ranked.begin(), ranked.begin() + static_cast<std::ptrdiff_t>(count));

  Fit fit{start};
  const float largest_step = 0.7F / disparity_per_inverse_depth(start.inverse_depth);
  const float sigma = slope_sigma * start.inverse_depth * ray_step_;
  for (int iteration = 0; iteration < iterations; ++iteration) {
    NormalEquations sum;
    for (std::size_t i = 0; i < static_cast<std::size_t>(counted_); ++i) {
      add_equations(neighbours_[ranked[i].second], fit.patch, sum);
    }
    const float prior = 1 / (sigma * sigma);
    sum.matrix(1, 1) += prior;
    sum.matrix(2, 2) += prior;
    sum.right[1] -= prior * (fit.patch.slope_x - start.slope_x) * ray_step_;
    sum.right[2] -= prior * (fit.patch.slope_y - start.slope_y) * ray_step_;
    const Eigen::Matrix3d information = sum.matrix.cast<double>();
    if (!(information(0, 0) > 0)) return fit;
    const Eigen::Matrix3d covariance = information.inverse();
    const Eigen::Vector3f step = (covariance * sum.right.cast<double>()).cast<float>();
    if (!step.allFinite() || !(covariance(0, 0) > 0)) return fit;
    const float shrink = std::min(1.0F, largest_step / std::max(std::abs(step[0]), 1e-20F));
    fit.patch.inverse_depth += shrink * step[0];
    fit.patch.slope_x += shrink * step[1] / ray_step_;
    fit.patch.slope_y += shrink * step[2] / ray_step_;
    fit.sigma = static_cast<float>(std::sqrt(covariance(0, 0)));
  }
  fit.ok = fit.patch.inverse_depth > 0;
  return fit;
}

float PatchScorer::disparity_per_inverse_depth(float inverse_depth) const {
  const Eigen::Vector3f ray(centre_x_, centre_y_, 1);
  float most = 0;
  for (const Neighbour& n : neighbours_) {
    const Eigen::Vector3f q = n.warp.from_ray * ray + n.warp.from_inverse_depth * inverse_depth;
    const Eigen::Vector3f& b = n.warp.from_inverse_depth;
    const Eigen::Vector2f d = (b.head<2>() - q.head<2>() * (b.z() / q.z())) / q.z();
    most = std::max(most, d.norm());
  }
  return most;
}

}  // namespace cousin
