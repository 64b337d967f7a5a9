#include "calibration/boards/print_match.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace cousin {
namespace {

constexpr float kInset = 0.2F;  ///< squares; keeps the green screen out

constexpr double kTukey = 4.685;  ///< seeds and shadows are outliers
constexpr int kUnknowns = 10;     ///< offset, contrast, contrast times the homography's change
constexpr std::size_t kFewPixels = 200;

Image<float> blurred(const Image<float>& image, double sigma_px) {
  Image<float> result(image.width(), image.height());
  const cv::Mat from(image.height(), image.width(), CV_32F, const_cast<float*>(image.data()));
  cv::Mat to(image.height(), image.width(), CV_32F, result.data());
  cv::GaussianBlur(from, to, {0, 0}, sigma_px, sigma_px, cv::BORDER_REPLICATE);
  return result;
}

/// A pixel's row: signal = offset + contrast white - contrast slope . motion, where the motion of a
/// point of the plate is linear in eight changes of the homography.
struct Row {
  std::array<double, kUnknowns> terms;
  double signal;
};

std::vector<Row> rows_of(const Image<float>& linear, const BoardPattern& pattern,
                         const BoardTemplate& t) {
  const float half = 0.5F * static_cast<float>(pattern.squares());
  constexpr double kMostPixels = 50000;  // of a box; more are visited sparsely
  const int stride =
      std::max(1, static_cast<int>(std::sqrt(1.0 * t.box.width * t.box.height / kMostPixels)));
  std::vector<Row> rows;
  for (int y = 1; y + 1 < t.box.height; y += stride) {
    for (int x = 1; x + 1 < t.box.width; x += stride) {
      const Eigen::Vector2f p = t.in_squares(x, y);
      if (!pattern.on_plate(p.x(), p.y(), kInset)) continue;
      Eigen::Matrix2f squares_per_pixel;
      squares_per_pixel << 0.5F * (t.in_squares(x + 1, y) - t.in_squares(x - 1, y)),
          0.5F * (t.in_squares(x, y + 1) - t.in_squares(x, y - 1));
      // d(white)/d(plate), the plate in units of half the checkerboard.
      const Eigen::Vector2f slope =
          half * squares_per_pixel.inverse().transpose() * gradient(t, x, y);
      if (!slope.allFinite()) continue;
      const double u = p.x() / half - 1, v = p.y() / half - 1;
      const double gu = slope.x(), gv = slope.y(), radial = -(gu * u + gv * v);
      rows.push_back({{1, t.white(x, y), -gu, -gu * u, -gu * v, -gv, -gv * u, -gv * v, -radial * u,
                       -radial * v},
                      linear(t.box.x + x, t.box.y + y)});
    }
  }
  return rows;
}

}  // namespace

double correlation(const Image<float>& linear, const BoardPattern& pattern,
                   const BoardTemplate& t) {
  double n = 0, sa = 0, sb = 0, saa = 0, sbb = 0, sab = 0;
  for (int y = 0; y < t.box.height; ++y) {
    for (int x = 0; x < t.box.width; ++x) {
      const Eigen::Vector2f p = t.in_squares(x, y);
      if (!pattern.on_plate(p.x(), p.y(), kInset)) continue;
      const double a = t.white(x, y), b = linear(t.box.x + x, t.box.y + y);
      n += 1, sa += a, sb += b, saa += a * a, sbb += b * b, sab += a * b;
    }
  }
  const double va = saa - sa * sa / n, vb = sbb - sb * sb / n;
  if (n < 50 || !(va > 0) || !(vb > 0)) return -1;
  return (sab - sa * sb / n) / std::sqrt(va * vb);
}

double preference(const Image<float>& linear, const BoardPattern& pattern, const BoardTemplate& a,
                  const BoardTemplate& b) {
  double n = 0, sd = 0, si = 0, sdd = 0, sii = 0, sdi = 0;
  for (int y = 0; y < a.box.height; ++y) {
    for (int x = 0; x < a.box.width; ++x) {
      const int u = x + a.box.x - b.box.x, v = y + a.box.y - b.box.y;
      if (!b.white.contains(u, v)) continue;
      const Eigen::Vector2f p = a.in_squares(x, y), q = b.in_squares(u, v);
      if (!pattern.on_plate(p.x(), p.y(), kInset) || !pattern.on_plate(q.x(), q.y(), kInset))
        continue;
      const double d = a.white(x, y) - b.white(u, v), i = linear(a.box.x + x, a.box.y + y);
      if (std::abs(d) < 0.2) continue;
      n += 1, sd += d, si += i, sdd += d * d, sii += i * i, sdi += d * i;
    }
  }
  const double vd = sdd - sd * sd / n, vi = sii - si * si / n;
  if (n < 20 || !(vd > 0) || !(vi > 0)) return 0;
  return (sdi - sd * si / n) / std::sqrt(vd * vi);
}

Eigen::Matrix3d aligned_print(const Image<float>& linear, const BoardPattern& pattern,
                              LensMap& lens, const SeedBoard& board, const Eigen::Matrix3d& start) {
  constexpr std::array<double, 3> kBlursPx = {2, 1, 0};
  constexpr int kSteps = 5;
  constexpr double kLargest = 0.2;  // of half the board, in one step
  using Matrix = Eigen::Matrix<double, kUnknowns, kUnknowns>;
  using Vector = Eigen::Matrix<double, kUnknowns, 1>;
  const double half_m = 0.5 * pattern.squares() * pattern.square_m();
  const Eigen::Vector3d scale(half_m, half_m, 1);
  Eigen::Matrix3d h = start * scale.asDiagonal();
  for (const double blur_px : kBlursPx) {
    const Image<float> softer = blur_px > 0 ? blurred(linear, blur_px) : Image<float>();
    const Image<float>& image = blur_px > 0 ? softer : linear;
    for (int step = 0; step < kSteps; ++step) {
      const Eigen::Matrix3d from_board = h * scale.cwiseInverse().asDiagonal();
      const PixelBox box = plate_box(board, lens.camera(), from_board);
      if (box.empty()) return start;
      const std::vector<Row> rows =
          rows_of(image, pattern,
                  render_board(pattern, lens, box, from_board, std::hypot(blur_px, kStartBlurPx),
                               TemplateQuality::coarse));
      if (rows.size() < kFewPixels) return start;
      Vector x = Vector::Zero();
      std::vector<double> residual(rows.size(), 0.0);
      double limit = 0;
      for (int round = 0; round < 3; ++round) {
        Matrix information = Matrix::Zero();
        Vector right = Vector::Zero();
        for (std::size_t i = 0; i < rows.size(); ++i) {
          const double ratio = limit > 0 ? residual[i] / limit : 0;
          if (ratio * ratio >= 1) continue;
          const double weight = (1 - ratio * ratio) * (1 - ratio * ratio);
          const Eigen::Map<const Vector> terms(rows[i].terms.data());
          information.selfadjointView<Eigen::Lower>().rankUpdate(terms, weight);
          right += weight * rows[i].signal * terms;
        }
        information.diagonal().array() *= 1 + 1e-9;
        x = information.selfadjointView<Eigen::Lower>().ldlt().solve(right);
        std::vector<double> sizes;
        for (std::size_t i = 0; i < rows.size(); ++i) {
          residual[i] = rows[i].signal - Eigen::Map<const Vector>(rows[i].terms.data()).dot(x);
          sizes.push_back(std::abs(residual[i]));
        }
        const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
        std::nth_element(sizes.begin(), middle, sizes.end());
        limit = kTukey * 1.4826 * *middle;
      }
      if (!x.allFinite() || !(x[1] > 0)) return start;
      const Eigen::Matrix<double, 8, 1> change = x.tail<8>() / x[1];
      const double shrink = std::min(1.0, kLargest / std::max(1e-12, change.cwiseAbs().maxCoeff()));
      Eigen::Matrix3d motion = Eigen::Matrix3d::Identity();
      motion.row(0) += shrink * Eigen::RowVector3d(change[1], change[2], change[0]);
      motion.row(1) += shrink * Eigen::RowVector3d(change[4], change[5], change[3]);
      motion.row(2) += shrink * Eigen::RowVector3d(change[6], change[7], 0);
      h = h * motion;
      if (change.cwiseAbs().maxCoeff() < 1e-4) break;
    }
  }
  return h * scale.cwiseInverse().asDiagonal();
}

PrintMatch match_print(const Image<float>& linear, const BoardPattern& pattern, LensMap& lens,
                       const SeedBoard& board, const Eigen::Matrix3d& normalized_from_board,
                       double blur_px) {
  PrintMatch match;
  match.normalized_from_board = normalized_from_board;
  const PixelBox box = plate_box(board, lens.camera(), normalized_from_board);
  if (box.empty()) return match;
  match.print =
      render_board(pattern, lens, box, normalized_from_board, blur_px, TemplateQuality::coarse);
  match.score = correlation(linear, pattern, match.print);
  return match;
}

PrintMatch best_print(const Image<float>& linear, const BoardPattern& pattern, LensMap& lens,
                      const SeedBoard& board, const std::vector<Eigen::Matrix3d>& starts) {
  constexpr double kFirstBlurPx = 1.5;  // a start is off by a pixel or so
  double score = -1;
  Eigen::Matrix3d start = Eigen::Matrix3d::Identity();
  for (const Eigen::Matrix3d& candidate : starts) {
    const double here = match_print(linear, pattern, lens, board, candidate, kFirstBlurPx).score;
    if (here > score) score = here, start = candidate;
  }
  if (score <= -1) return {};
  PrintMatch as_started = match_print(linear, pattern, lens, board, start, kStartBlurPx);
  PrintMatch moved = match_print(linear, pattern, lens, board,
                                 aligned_print(linear, pattern, lens, board, start), kStartBlurPx);
  return moved.score >= as_started.score ? moved : as_started;
}

}  // namespace cousin
