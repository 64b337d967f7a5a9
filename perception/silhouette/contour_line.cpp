#include "perception/silhouette/contour_line.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace cousin {
namespace {

/// A crossing lies on the edge from pixel (x, y) to its right (0) or lower (1) neighbour.
using GridEdge = std::array<int, 3>;

double signed_area(const std::vector<Eigen::Vector2d>& line) {
  double sum = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Eigen::Vector2d& a = line[i];
    const Eigen::Vector2d& b = line[(i + 1) % line.size()];
    sum += 0.5 * (a.x() * b.y() - a.y() * b.x());
  }
  return sum;
}

std::vector<Eigen::Vector2d> resample(const std::vector<Eigen::Vector2d>& line, int count,
                                      double length) {
  std::vector<Eigen::Vector2d> result;
  const double step = length / count;
  double done = 0, next = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Eigen::Vector2d edge = line[(i + 1) % line.size()] - line[i];
    const double edge_length = edge.norm();
    while (static_cast<int>(result.size()) < count && next < done + edge_length) {
      result.push_back(line[i] + edge * ((next - done) / edge_length));
      next += step;
    }
    done += edge_length;
  }
  return result;
}

}  // namespace

std::vector<Eigen::Vector2d> trace_mask(const Image<std::uint8_t>& mask) {
  const cv::Mat source(mask.height(), mask.width(), CV_8U, const_cast<std::uint8_t*>(mask.data()));
  cv::Mat level;
  source.convertTo(level, CV_32F, 1.0 / 255);
  cv::GaussianBlur(level, level, cv::Size(5, 5), 0.7, 0.7, cv::BORDER_CONSTANT);
  // Half a level is never met exactly, so that no cell is ambiguous at its corners.
  constexpr float kLevel = 0.50001F;
  const auto inside = [&](int x, int y) { return level.at<float>(y, x) > kLevel; };
  const auto crossing = [&](const GridEdge& e) -> Eigen::Vector2d {
    const int x = e[0], y = e[1], x2 = x + (e[2] == 0 ? 1 : 0), y2 = y + (e[2] == 1 ? 1 : 0);
    const float a = level.at<float>(y, x), b = level.at<float>(y2, x2);
    const double s = (kLevel - a) / (b - a);
    return {x + s * (x2 - x), y + s * (y2 - y)};
  };

  // In each cell, from the edge where the line enters to the edge where it leaves, the object on a
  // fixed side.
  std::map<GridEdge, GridEdge> next;
  for (int y = 0; y + 1 < mask.height(); ++y) {
    for (int x = 0; x + 1 < mask.width(); ++x) {
      const std::array<bool, 4> corner = {inside(x, y), inside(x + 1, y), inside(x + 1, y + 1),
                                          inside(x, y + 1)};
      const std::array<GridEdge, 4> edge = {{{x, y, 0}, {x + 1, y, 1}, {x, y + 1, 0}, {x, y, 1}}};
      for (std::size_t i = 0; i < 4; ++i) {
        if (!(!corner[i] && corner[(i + 1) % 4])) continue;
        // Enters through edge i, from outside to inside; leaves through the next edge that goes
        // inside to outside.
        for (std::size_t j = 1; j < 4; ++j) {
          const std::size_t k = (i + j) % 4;
          if (corner[k] && !corner[(k + 1) % 4]) {
            next[edge[i]] = edge[k];
            break;
          }
        }
      }
    }
  }
  std::vector<Eigen::Vector2d> best;
  while (!next.empty()) {
    std::vector<Eigen::Vector2d> line;
    auto at = next.begin();
    const GridEdge first = at->first;
    bool closed = false;
    while (at != next.end()) {
      line.push_back(crossing(at->first));
      const GridEdge to = at->second;
      next.erase(at);
      closed = to == first;
      at = next.find(to);
    }
    if (closed && line.size() > best.size()) best = std::move(line);
  }
  return best;
}

std::vector<ContourVertex> smooth_contour(const std::vector<Eigen::Vector2d>& line_px,
                                          double sigma_px) {
  double length = 0;
  for (std::size_t i = 0; i < line_px.size(); ++i)
    length += (line_px[(i + 1) % line_px.size()] - line_px[i]).norm();
  if (line_px.size() < 6 || !(length >= 8)) return {};
  const int count = static_cast<int>(std::lround(length));
  const double step = length / count;
  const std::vector<Eigen::Vector2d> points = resample(line_px, count, length);
  if (static_cast<int>(points.size()) != count) return {};

  const auto wrap = [&](int i) { return static_cast<std::size_t>(((i % count) + count) % count); };
  const int reach = std::min(count / 2 - 1, static_cast<int>(std::ceil(3 * sigma_px / step)));
  std::vector<Eigen::Vector2d> smooth(points.size());
  for (int i = 0; i < count; ++i) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    double weights = 0;
    for (int k = -reach; k <= reach; ++k) {
      const double weight =
          sigma_px > 0 ? std::exp(-0.5 * k * k * step * step / (sigma_px * sigma_px)) : (k == 0);
      sum += weight * points[wrap(i + k)];
      weights += weight;
    }
    smooth[static_cast<std::size_t>(i)] = sum / weights;
  }
  const double side = signed_area(smooth) > 0 ? 1 : -1;
  std::vector<ContourVertex> contour;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d before = smooth[wrap(i - 2)], here = smooth[wrap(i)],
                          after = smooth[wrap(i + 2)];
    const Eigen::Vector2d tangent = (after - before).normalized();
    // The circle through three points: curvature = 4 area / product of the sides.
    const Eigen::Vector2d a = here - before, b = after - here;
    const double product = a.norm() * b.norm() * (after - before).norm();
    const double curvature = product > 0 ? 2 * (a.x() * b.y() - a.y() * b.x()) / product : 0;
    contour.push_back({here, side * Eigen::Vector2d(tangent.y(), -tangent.x()), side * curvature});
  }
  return contour;
}

}  // namespace cousin
