#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "perception/mvs/patch_score.h"
#include "perception/mvs/reference_depth.h"
#include "sim/types/no_value.h"
#include "sim/types/rng.h"

namespace cousin {
namespace {

/// The first pass is believed where a window of this radius lies in one swept plane.
constexpr int kFlatRadius = 7;
constexpr int kSweeps = 4;
constexpr float kStartScore = 0.2F;
/// A new slope must gain this much: under a lone edge all slopes score alike, and noise would
/// choose.
constexpr float kSlopeMargin = 0.005F;
/// Matching windows with less variance than this, in squared codes, show noise only.
constexpr float kLeastTexture = 2 * kNoiseVariance;
/// Depth errors that the score's shape does not see: lens and pose errors, in pixels of disparity.
constexpr float kSystematicPx = 0.05F;
/// Neighbouring pixels' residuals are correlated and the reference's noise is shared by all
/// neighbours, so there are fewer independent samples than pixels.
constexpr float kSigmaScale = 1.5F;
/// Prior of the slopes relative to inverse depth, where a wide plane was found and elsewhere.
constexpr float kFlatSlopeSigma = 0.03F;
constexpr float kFreeSlopeSigma = 1.0F;
/// Prior of the bends, 1/m: a seed's smallest radius of curvature is about a millimetre.
constexpr double kBendSigma = 500;
constexpr int kBentRounds = 2;

SurfacePatch patch_at(const ReferenceDepth& depth, int x, int y) {
  return {depth.inverse_depth(x, y), depth.slope_x(x, y), depth.slope_y(x, y)};
}

void store(const SurfacePatch& plane, float score, int x, int y, ReferenceDepth& depth) {
  depth.inverse_depth(x, y) = plane.inverse_depth;
  depth.slope_x(x, y) = plane.slope_x;
  depth.slope_y(x, y) = plane.slope_y;
  depth.score(x, y) = score;
}

/// Pixels that the first pass leaves uncertain: textured, with some score, and not inside a wide
/// swept plane.
Image<std::uint8_t> pixels_to_refine(const MvsView& view, const ReferenceDepth& depth, int radius,
                                     float min_score) {
  const int w = view.rect.width, h = view.rect.height;
  // Relative change of inverse depth that one pixel of the swept plane explains, plus a tenth of a
  // pixel of disparity.
  const auto agree = [&](int x, int y, int x2, int y2) {
    const SurfacePatch p = patch_at(depth, x, y);
    const float predicted = p.inverse_depth + p.slope_x * (view.ray_x(x2, y2) - view.ray_x(x, y)) +
                            p.slope_y * (view.ray_y(x2, y2) - view.ray_y(x, y));
    return std::abs(depth.inverse_depth(x2, y2) / predicted - 1) < 0.0012F;
  };
  const float start_score = std::min(kStartScore, min_score);
  Image<std::uint8_t> refine(w, h, 0);
  for (int y = radius; y < h - radius; ++y) {
    for (int x = radius; x < w - radius; ++x) {
      if (!std::isfinite(depth.inverse_depth(x, y)) || depth.score(x, y) < start_score) continue;
      int seen = 0, same = 0;
      for (int dy = -kFlatRadius; dy <= kFlatRadius; dy += kFlatRadius) {
        for (int dx = -kFlatRadius; dx <= kFlatRadius; dx += kFlatRadius) {
          const int x2 = x + dx, y2 = y + dy;
          if (x2 < 0 || y2 < 0 || x2 >= w || y2 >= h || depth.score(x2, y2) < min_score) continue;
          ++seen;
          same += agree(x, y, x2, y2) ? 1 : 0;
        }
      }
      const bool flat = depth.score(x, y) >= min_score && seen >= 5 && same >= seen - 1;
      refine(x, y) = flat ? 0 : 1;
    }
  }
  return refine;
}

/// Keeps the better of the current and a proposed plane.
struct Best {
  SurfacePatch plane;
  float score;
  void offer(const PatchScorer& scorer, const SurfacePatch& candidate, float margin = 0) {
    if (!(candidate.inverse_depth > 0)) return;
    const float s = scorer.score(candidate);
    if (s > score + margin) {
      plane = candidate;
      score = s;
    }
  }
};

/// A neighbour pixel's plane carried to this pixel.
SurfacePatch carried(const MvsView& view, const ReferenceDepth& depth, int from_x, int from_y,
                     int x, int y) {
  SurfacePatch p = patch_at(depth, from_x, from_y);
  p.inverse_depth += p.slope_x * (view.ray_x(x, y) - view.ray_x(from_x, from_y)) +
                     p.slope_y * (view.ray_y(x, y) - view.ray_y(from_x, from_y));
  return p;
}

SurfacePatch perturbed(const SurfacePatch& plane, float depth_step, float slope_step, Rng& rng) {
  const auto within = [&](float limit) { return static_cast<float>(uniform(rng, -limit, limit)); };
  return {plane.inverse_depth + within(depth_step), plane.slope_x + within(slope_step),
          plane.slope_y + within(slope_step)};
}

/// One pass over the image, forwards or backwards.
void propagate(const MvsView& view, const Image<std::uint8_t>& refine, int radius, int pass,
               const Rng& rng, PatchScorer& scorer, ReferenceDepth& depth) {
  const int w = view.rect.width, h = view.rect.height;
  const bool forward = pass % 2 == 0;
  const int step = forward ? -1 : 1;  // where the pixels lie that this pass has already improved
  const float shrink = std::pow(0.5F, static_cast<float>(pass));
  for (int row = radius; row < h - radius; ++row) {
    const int y = forward ? row : h - 1 - row;
    for (int column = radius; column < w - radius; ++column) {
      const int x = forward ? column : w - 1 - column;
      if (refine(x, y) == 0) continue;
      scorer.move_to(x, y);
      if (scorer.texture() < kLeastTexture) {
        depth.inverse_depth(x, y) = kNone;
        depth.score(x, y) = -1;
        continue;
      }
      Best best{patch_at(depth, x, y), -1};
      if (std::isfinite(best.plane.inverse_depth)) best.score = scorer.score(best.plane);
      for (const std::array<int, 2>& d : {std::array{step, 0}, std::array{0, step}}) {
        if (std::isfinite(depth.inverse_depth(x + d[0], y + d[1]))) {
          best.offer(scorer, carried(view, depth, x + d[0], y + d[1], x, y));
        }
      }
      if (!(best.score > -1)) continue;
      // Depth within a pixel of disparity; slopes within about 45 degrees of turn, then ever less.
      Rng draws = rng.fork(static_cast<std::uint64_t>(y) * 65536U + static_cast<std::uint64_t>(x));
      const float one_px = 1.0F / scorer.disparity_per_inverse_depth(best.plane.inverse_depth);
      const float slope = best.plane.inverse_depth;
      const SurfacePatch facing{best.plane.inverse_depth, 0, 0};
      if (pass == 0) best.offer(scorer, facing, kSlopeMargin);
      best.offer(scorer, perturbed(best.plane, one_px * shrink, 0, draws));
      best.offer(scorer, perturbed(best.plane, 0.5F * one_px * shrink, slope * shrink, draws),
                 kSlopeMargin);
      best.offer(scorer,
                 perturbed(best.plane, 0.25F * one_px * shrink, 0.5F * slope * shrink, draws),
                 kSlopeMargin);
      store(best.plane, best.score, x, y, depth);
    }
  }
}

/// Depth and slopes by Gauss-Newton, with their standard deviation.
void settle(const PatchScorer& scorer, const SurfacePatch& start, float slope_sigma, int iterations,
            int x, int y, ReferenceDepth& depth) {
  const PatchScorer::Fit fit = scorer.fit(start, slope_sigma, iterations);
  if (!fit.ok) {
    depth.inverse_depth(x, y) = kNone;
    return;
  }
  const float score = scorer.score(fit.patch);
  const float per_px = 1.0F / scorer.disparity_per_inverse_depth(fit.patch.inverse_depth);
  const float sigma = std::hypot(kSigmaScale * fit.sigma, kSystematicPx * per_px);
  store(fit.patch, score, x, y, depth);
  depth.sigma_m(x, y) = sigma / (fit.patch.inverse_depth * fit.patch.inverse_depth);
}

/// Bends of the surface around a pixel: a quadric through the inverse depths of the window,
/// weighted by colour and certainty, without what lies off it. Weakly held at zero.
SurfacePatch with_bends(const MvsView& view, const ReferenceDepth& depth, const PatchScorer& scorer,
                        int radius, int x, int y) {
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  SurfacePatch patch = patch_at(depth, x, y);
  const double step = scorer.ray_step();
  const double bend_sigma = kBendSigma * step * step;
  Vector6 quadric = Vector6::Zero();
  for (int round = 0; round < 2; ++round) {
    Matrix6 matrix = Matrix6::Zero();
    Vector6 right = Vector6::Zero();
    for (int i = 3; i < 6; ++i) matrix(i, i) = 1 / (bend_sigma * bend_sigma);
    const float* weight = scorer.weights();
    const double most = *std::max_element(weight, weight + (2 * radius + 1) * (2 * radius + 1));
    for (int dy = -radius; dy <= radius; ++dy) {
      for (int dx = -radius; dx <= radius; ++dx, ++weight) {
        const float other = depth.inverse_depth(x + dx, y + dy);
        if (!std::isfinite(other) || *weight < 0.05 * most) continue;
        const double u = (view.ray_x(x + dx, y + dy) - view.ray_x(x, y)) / step;
        const double v = (view.ray_y(x + dx, y + dy) - view.ray_y(x, y)) / step;
        const double value = other - patch.inverse_depth;
        const Vector6 row{1, u, v, 0.5 * u * u, u * v, 0.5 * v * v};
        const double sigma =
            std::max(1e-12, static_cast<double>(depth.sigma_m(x + dx, y + dy)) * other * other);
        const double off = (value - row.dot(quadric)) / (3 * sigma);
        const double trust = round == 0 ? 1 : 1 / (1 + off * off);  // Cauchy
        const double w = *weight / most * trust / (sigma * sigma);
        if (!(w > 0)) continue;
        matrix += w * row * row.transpose();
        right += w * value * row;
      }
    }
    if (!(matrix(0, 0) > 0)) return patch;
    matrix.diagonal().head<3>() *= 1 + 1e-9;
    quadric = matrix.ldlt().solve(right);
    if (!quadric.allFinite()) return patch;
  }
  patch.slope_x = static_cast<float>(quadric[1] / step);
  patch.slope_y = static_cast<float>(quadric[2] / step);
  patch.inverse_depth += static_cast<float>(quadric[0]);
  patch.bend_xx = static_cast<float>(quadric[3] / (step * step));
  patch.bend_xy = static_cast<float>(quadric[4] / (step * step));
  patch.bend_yy = static_cast<float>(quadric[5] / (step * step));
  return patch;
}

bool inside(const SweepVolume& volume, const Eigen::Vector3d& p) {
  return (p.array() >= volume.low_m.array()).all() && (p.array() <= volume.high_m.array()).all();
}

}  // namespace

void refine_slanted(const std::vector<MvsView>& views, int reference,
                    const std::vector<int>& neighbours, const SweepVolume& volume,
                    const MvsConfig& config, ReferenceDepth& depth) {
  const MvsView& view = views[static_cast<std::size_t>(reference)];
  const int radius = config.window_px / 2;
  const int w = view.rect.width, h = view.rect.height;
  const float min_score = static_cast<float>(config.min_score);
  const Image<std::uint8_t> refine = pixels_to_refine(view, depth, radius, min_score);
  PatchScorer scorer(views, reference, neighbours, config.window_px);
  const Rng rng = Rng(0).fork("mvs").fork(static_cast<std::uint64_t>(view.index));
  for (int pass = 0; pass < kSweeps; ++pass) {
    propagate(view, refine, radius, pass, rng.fork(static_cast<std::uint64_t>(pass)), scorer,
              depth);
  }

  // Flat windows everywhere; then, where the surface is not a swept plane, windows bent like the
  // depths found.
  const auto each = [&](const auto& visit) {
    for (int y = 0; y < h; ++y) {
      for (int x = 0; x < w; ++x) {
        const bool in_window = x >= radius && y >= radius && x < w - radius && y < h - radius;
        if (!in_window || !(depth.score(x, y) >= min_score)) depth.inverse_depth(x, y) = kNone;
        if (std::isfinite(depth.inverse_depth(x, y))) visit(x, y);
      }
    }
  };
  each([&](int x, int y) {
    scorer.move_to(x, y);
    if (scorer.texture() < kLeastTexture) {
      depth.inverse_depth(x, y) = kNone;
    } else {
      const bool flat = refine(x, y) == 0;
      settle(scorer, patch_at(depth, x, y), flat ? kFlatSlopeSigma : kFreeSlopeSigma, flat ? 1 : 2,
             x, y, depth);
    }
  });
  for (int round = 0; round < kBentRounds; ++round) {
    const ReferenceDepth before = depth;
    each([&](int x, int y) {
      if (refine(x, y) == 0) return;
      scorer.move_to(x, y);
      settle(scorer, with_bends(view, before, scorer, radius, x, y), kFreeSlopeSigma, 2, x, y,
             depth);
    });
  }

  const Pose world_from_camera = inverse(view.camera_from_world);
  each([&](int x, int y) {
    const Eigen::Vector3d ray(view.ray_x(x, y), view.ray_y(x, y), 1);
    const Eigen::Vector3d point = ray / static_cast<double>(depth.inverse_depth(x, y));
    if (!(depth.sigma_m(x, y) <= config.consistency_depth * point.z()) ||
        !inside(volume, world_from_camera * point)) {
      depth.inverse_depth(x, y) = kNone;
    }
  });
}

}  // namespace cousin
