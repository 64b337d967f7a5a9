#include "calibration/boards/target_grid.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "calibration/boards/homography.h"

namespace cousin {

TargetGrid::TargetGrid(const CalibrationTarget& target)
    : target_(target), points_(target_points(target)) {
  for (const TargetPoint& p : points_) {
    columns_ = std::max(columns_, p.column + 1);
    rows_ = std::max(rows_, p.row + 1);
  }
  index_.assign(static_cast<std::size_t>(columns_ * rows_), -1);
  for (std::size_t i = 0; i < points_.size(); ++i) {
    index_[static_cast<std::size_t>(points_[i].row * columns_ + points_[i].column)] =
        static_cast<int>(i);
  }
}

int TargetGrid::at(int column, int row) const {
  if (column < 0 || row < 0 || column >= columns_ || row >= rows_) return -1;
  return index_[static_cast<std::size_t>(row * columns_ + column)];
}

int count_found(const FoundPixels& found) {
  return static_cast<int>(
      std::count_if(found.begin(), found.end(), [](const auto& p) { return p.has_value(); }));
}

double step_px(const LocalMap& map, const CalibrationTarget& target) {
  const double step_m = target.kind == TargetKind::april_grid
                            ? std::min(1.0, target.mark_share) * target.pitch_m
                            : target.pitch_m;
  return step_m * std::min(map.px_per_m.col(0).norm(), map.px_per_m.col(1).norm());
}

std::optional<LocalMap> local_map(const TargetGrid& grid, const FoundPixels& found, int index) {
  const TargetPoint& middle = grid.points()[static_cast<std::size_t>(index)];
  const double pitch_m = grid.target().pitch_m;
  Eigen::Matrix3d ata = Eigen::Matrix3d::Zero();
  Eigen::Matrix<double, 3, 2> atb = Eigen::Matrix<double, 3, 2>::Zero();
  for (int dr = -2; dr <= 2; ++dr) {
    for (int dc = -2; dc <= 2; ++dc) {
      const int i = grid.at(middle.column + dc, middle.row + dr);
      if (i < 0 || i == index || !found[static_cast<std::size_t>(i)]) continue;
      const Eigen::Vector2d away =
          (grid.points()[static_cast<std::size_t>(i)].at_m - middle.at_m) / pitch_m;
      const double weight = 1 / away.squaredNorm();
      const Eigen::Vector3d a(1, away.x(), away.y());
      ata += weight * a * a.transpose();
      atb += weight * a * found[static_cast<std::size_t>(i)]->transpose();
    }
  }
  const Eigen::FullPivLU<Eigen::Matrix3d> lu(ata);
  if (lu.rcond() < 1e-4) return std::nullopt;
  const Eigen::Matrix<double, 3, 2> x = lu.solve(atb);
  LocalMap map;
  map.pixel_px = x.row(0).transpose();
  map.px_per_m = x.bottomRows<2>().transpose() / pitch_m;
  if (!map.px_per_m.allFinite()) return std::nullopt;
  return map;
}

int drop_strays(const TargetGrid& grid, FoundPixels& found, double max_share) {
  int dropped = 0;
  while (true) {
    double worst = max_share;
    int worst_index = -1;
    for (std::size_t i = 0; i < found.size(); ++i) {
      if (!found[i]) continue;
      const auto map = local_map(grid, found, static_cast<int>(i));
      if (!map) continue;
      const double share =
          (*found[i] - map->pixel_px).norm() / std::max(1e-9, step_px(*map, grid.target()));
      if (share > worst) worst = share, worst_index = static_cast<int>(i);
    }
    if (worst_index < 0) return dropped;
    found[static_cast<std::size_t>(worst_index)].reset();
    ++dropped;
  }
}

namespace {

/// How far a point lies from its neighbours' homography, in steps; nothing with few neighbours.
std::optional<double> misplacement(const TargetGrid& grid, const FoundPixels& found, int index) {
  constexpr int kReach = 3;
  constexpr std::size_t kLeast = 8;
  const auto i = static_cast<std::size_t>(index);
  const TargetPoint& middle = grid.points()[i];
  std::vector<PlanePoint> near;
  for (int dr = -kReach; dr <= kReach; ++dr) {
    for (int dc = -kReach; dc <= kReach; ++dc) {
      const int k = grid.at(middle.column + dc, middle.row + dr);
      if (k < 0 || k == index || !found[static_cast<std::size_t>(k)]) continue;
      near.push_back({grid.points()[static_cast<std::size_t>(k)].at_m,
                      *found[static_cast<std::size_t>(k)], 0.1});
    }
  }
  if (near.size() < kLeast) return std::nullopt;
  const auto map = local_map(grid, found, index);
  const HomographyFit fit = fit_homography(near);
  if (!map || !fit.ok) return std::nullopt;
  return (*found[i] - transfer(fit.normalized_from_plane, middle.at_m)).norm() /
         std::max(1e-9, step_px(*map, grid.target()));
}

}  // namespace

int drop_misplaced(const TargetGrid& grid, FoundPixels& found, double max_share) {
  for (int dropped = 0;; ++dropped) {
    double worst = max_share;
    int worst_index = -1;
    for (std::size_t i = 0; i < found.size(); ++i) {
      if (!found[i]) continue;
      const auto share = misplacement(grid, found, static_cast<int>(i));
      if (share && *share > worst) worst = *share, worst_index = static_cast<int>(i);
    }
    if (worst_index < 0) return dropped;
    found[static_cast<std::size_t>(worst_index)].reset();
  }
}

bool is_face_seen(const TargetGrid& grid, const FoundPixels& found) {
  int sides = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (!found[i]) continue;
    if (const auto map = local_map(grid, found, static_cast<int>(i)))
      sides += map->px_per_m.determinant() < 0 ? 1 : -1;
  }
  return sides > 0;
}

}  // namespace cousin
