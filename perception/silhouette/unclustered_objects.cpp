#include "perception/silhouette/unclustered_objects.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

namespace cousin {
namespace {

constexpr double kCell_m = 0.0005;
constexpr double kInset_m = 0.002;  ///< of the plate's edge, where the screen shines through
constexpr std::size_t kMostViews = 24;
constexpr double kMinSaturation = 0.3;  ///< of what is not board; paper and ink are grey
constexpr double kMinValue = 40;        ///< of 255: darker pixels have noise for a colour
constexpr double kMinVotes = 0.75;      ///< of the views that see a cell
constexpr int kMinSeen = 2;             ///< views of a cell, where there are as many
constexpr double kMinArea_m2 = 5e-6;    ///< of a foot: less is dust, or the edge of a print
constexpr int kStep = 2;                ///< cells that link the parts of a foot
constexpr double kReach_m = 0.0015;     ///< of a cluster's points around its foot
constexpr double kKnownShare = 0.25;    ///< of a foot that lies below a cluster
constexpr float kStands_m = 0.0005F;    ///< points higher than this are not the board

/// The plate in square cells, row by row.
struct Cells {
  int side = 0;
  double origin_m = 0;

  explicit Cells(const SeedBoard& board) {
    side = std::max(0, static_cast<int>((board.plate_m - 2 * kInset_m) / kCell_m));
    origin_m = -0.5 * side * kCell_m;
  }
  std::size_t count() const {
    return static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
  }
  Eigen::Vector2d centre_m(std::size_t cell) const {
    const auto row = static_cast<double>(cell / static_cast<std::size_t>(side));
    const auto column = static_cast<double>(cell % static_cast<std::size_t>(side));
    return {origin_m + (column + 0.5) * kCell_m, origin_m + (row + 0.5) * kCell_m};
  }
  std::optional<std::pair<int, int>> at(double x_m, double y_m) const {
    const double column = std::floor((x_m - origin_m) / kCell_m);
    const double row = std::floor((y_m - origin_m) / kCell_m);
    if (!(column >= 0 && row >= 0 && column < side && row < side)) return std::nullopt;
    return std::pair(static_cast<int>(column), static_cast<int>(row));
  }
  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(side) +
           static_cast<std::size_t>(column);
  }
};

enum class Look : std::uint8_t { unseen, board, object };

/// The posed views that have a picture, spread evenly over them.
std::vector<std::size_t> chosen_views(const Capture& capture, const Poses& poses) {
  std::vector<std::size_t> posed;
  for (std::size_t f = 0; f < std::min(poses.size(), capture.frames.size()); ++f) {
    if (poses[f].status != PoseStatus::ok || capture.frames[f].sensors.empty()) continue;
    const Image<Rgb8>& image = capture.frames[f].sensors[0].color;
    const Camera& camera = poses[f].camera;
    if (image.width() == camera.width_px && image.height() == camera.height_px && image.width() > 0)
      posed.push_back(f);
  }
  if (posed.size() <= kMostViews) return posed;
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < kMostViews; ++i)
    chosen.push_back(posed[i * posed.size() / kMostViews]);
  return chosen;
}

/// Each cell's colour in a view; nothing where it is outside the picture.
std::vector<std::optional<Rgb8>> colors_of(const Image<Rgb8>& image, const FramePose& pose,
                                           const Cells& cells) {
  const Lens lens(pose.camera);
  std::vector<std::optional<Rgb8>> colors(cells.count());
  for (std::size_t c = 0; c < colors.size(); ++c) {
    const Eigen::Vector2d at_m = cells.centre_m(c);
    const auto pixel =
        lens.project(pose.camera_from_world * Eigen::Vector3d(at_m.x(), at_m.y(), 0));
    if (!pixel || !pixel->allFinite()) continue;
    const auto x = static_cast<long long>(std::llround(pixel->x()));
    const auto y = static_cast<long long>(std::llround(pixel->y()));
    if (x < 0 || y < 0 || x >= image.width() || y >= image.height()) continue;
    colors[c] = image(static_cast<int>(x), static_cast<int>(y));
  }
  return colors;
}

/// Factors that make the paper grey; nothing where no paper is seen.
std::optional<std::array<double, 3>> white_balance(const std::vector<std::optional<Rgb8>>& colors,
                                                   const SeedBoard& board, const Cells& cells) {
  std::array<std::vector<std::uint8_t>, 3> paper;
  for (std::size_t c = 0; c < colors.size(); ++c) {
    const Eigen::Vector2d at_m = cells.centre_m(c);
    if (!colors[c] || is_black(board, at_m.x(), at_m.y())) continue;
    paper[0].push_back(colors[c]->r);
    paper[1].push_back(colors[c]->g);
    paper[2].push_back(colors[c]->b);
  }
  std::array<double, 3> factors{};
  for (std::size_t k = 0; k < 3; ++k) {
    if (paper[k].empty()) return std::nullopt;
    const auto middle = paper[k].begin() + static_cast<std::ptrdiff_t>(paper[k].size() / 2);
    std::nth_element(paper[k].begin(), middle, paper[k].end());
    if (*middle == 0) return std::nullopt;
    factors[k] = 255.0 / *middle;
  }
  const double least = *std::min_element(factors.begin(), factors.end());
  for (double& factor : factors) factor /= least;
  return factors;
}

bool is_object(Rgb8 color, const std::array<double, 3>& balance, const GreenConfig& green) {
  if (is_green(color, green)) return false;
  const double r = color.r * balance[0], g = color.g * balance[1], b = color.b * balance[2];
  const double high = std::max({r, g, b}), low = std::min({r, g, b});
  return high >= kMinValue && high - low >= kMinSaturation * high;
}

/// What a view shows in each cell.
std::vector<Look> looks_of(const Image<Rgb8>& image, const FramePose& pose, const SeedBoard& board,
                           const Cells& cells, const GreenConfig& green) {
  std::vector<Look> looks(cells.count(), Look::unseen);
  const auto colors = colors_of(image, pose, cells);
  const auto balance = white_balance(colors, board, cells);
  if (!balance) return looks;
  for (std::size_t c = 0; c < looks.size(); ++c) {
    if (colors[c]) looks[c] = is_object(*colors[c], *balance, green) ? Look::object : Look::board;
  }
  return looks;
}

/// Cells that show an object in most of the views that see them.
std::vector<bool> occupied_cells(const std::vector<std::vector<Look>>& views, const Cells& cells) {
  std::vector<bool> occupied(cells.count());
  const int least = std::min(kMinSeen, static_cast<int>(views.size()));
  for (std::size_t c = 0; c < occupied.size(); ++c) {
    int seen = 0, shows = 0;
    for (const std::vector<Look>& looks : views) {
      seen += looks[c] != Look::unseen ? 1 : 0;
      shows += looks[c] == Look::object ? 1 : 0;
    }
    occupied[c] = seen >= least && shows >= kMinVotes * seen && shows > 0;
  }
  return occupied;
}

/// Cells that are linked, group by group, in the order of their first cell.
std::vector<std::vector<std::size_t>> feet(std::vector<bool> occupied, const Cells& cells) {
  std::vector<std::vector<std::size_t>> all;
  for (std::size_t first = 0; first < occupied.size(); ++first) {
    if (!occupied[first]) continue;
    std::vector<std::size_t> foot = {first};
    occupied[first] = false;
    for (std::size_t i = 0; i < foot.size(); ++i) {
      const int column = static_cast<int>(foot[i] % static_cast<std::size_t>(cells.side));
      const int row = static_cast<int>(foot[i] / static_cast<std::size_t>(cells.side));
      for (int y = std::max(0, row - kStep); y <= std::min(cells.side - 1, row + kStep); ++y) {
        for (int x = std::max(0, column - kStep); x <= std::min(cells.side - 1, column + kStep);
             ++x) {
          const std::size_t near = cells.index(x, y);
          if (!occupied[near]) continue;
          occupied[near] = false;
          foot.push_back(near);
        }
      }
    }
    if (static_cast<double>(foot.size()) * kCell_m * kCell_m >= kMinArea_m2)
      all.push_back(std::move(foot));
  }
  return all;
}

/// Cells below a cluster's points, and around them.
std::vector<bool> clustered_cells(const Clusters& clusters, const Cells& cells) {
  std::vector<bool> below(cells.count());
  const int reach = static_cast<int>(std::ceil(kReach_m / kCell_m));
  for (std::size_t i = 0; i < clusters.cloud.size(); ++i) {
    if (clusters.instance[i] < 0) continue;
    const Eigen::Vector3f& p = clusters.cloud[i].position_m;
    const auto at = cells.at(p.x(), p.y());
    if (!at) continue;
    for (int y = std::max(0, at->second - reach); y <= std::min(cells.side - 1, at->second + reach);
         ++y) {
      for (int x = std::max(0, at->first - reach); x <= std::min(cells.side - 1, at->first + reach);
           ++x)
        below[cells.index(x, y)] = true;
    }
  }
  return below;
}

/// Points of the cloud that stand on each cell.
std::vector<int> standing_points(const Clusters& clusters, const Cells& cells) {
  std::vector<int> points(cells.count());
  for (const CloudPoint& point : clusters.cloud) {
    if (point.position_m.z() < kStands_m) continue;
    const auto at = cells.at(point.position_m.x(), point.position_m.y());
    if (at) ++points[cells.index(at->first, at->second)];
  }
  return points;
}

}  // namespace

std::vector<UnclusteredObject> unclustered_objects(const Capture& capture, const Poses& poses,
                                                   const SeedBoard& board, const Clusters& clusters,
                                                   const GreenConfig& green) {
  const Cells cells(board);
  const std::vector<std::size_t> chosen = chosen_views(capture, poses);
  if (chosen.empty() || cells.count() == 0) return {};
  std::vector<std::vector<Look>> views(chosen.size());
  tbb::parallel_for(std::size_t{0}, chosen.size(), [&](std::size_t v) {
    const std::size_t f = chosen[v];
    views[v] = looks_of(capture.frames[f].sensors[0].color, poses[f], board, cells, green);
  });
  const std::vector<bool> clustered = clustered_cells(clusters, cells);
  const std::vector<int> points = standing_points(clusters, cells);
  std::vector<UnclusteredObject> objects;
  for (const std::vector<std::size_t>& foot : feet(occupied_cells(views, cells), cells)) {
    const auto known =
        std::count_if(foot.begin(), foot.end(), [&](std::size_t cell) { return clustered[cell]; });
    const auto size = static_cast<double>(foot.size());
    if (static_cast<double>(known) >= kKnownShare * size) continue;
    UnclusteredObject object;
    object.area_m2 = size * kCell_m * kCell_m;
    for (const std::size_t cell : foot) {
      object.centre_m += cells.centre_m(cell) / size;
      object.points += points[cell];
    }
    for (const std::vector<Look>& looks : views) {
      const auto shown = std::count_if(
          foot.begin(), foot.end(), [&](std::size_t cell) { return looks[cell] == Look::object; });
      object.views += 2 * static_cast<double>(shown) >= size ? 1 : 0;
    }
    objects.push_back(object);
  }
  return objects;
}

}  // namespace cousin
