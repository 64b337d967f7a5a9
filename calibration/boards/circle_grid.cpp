#include "calibration/boards/circle_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>
#include <vector>

#include "calibration/boards/partial_circles.h"

namespace cousin {
namespace {

/// Dark blobs of a size that a grid's discs can have in the image.
cv::Ptr<cv::FeatureDetector> blob_detector(const Image<std::uint8_t>& image) {
  cv::SimpleBlobDetector::Params params;
  params.minArea = 12;
  params.maxArea = 0.05F * static_cast<float>(image.width()) * static_cast<float>(image.height());
  params.minDistBetweenBlobs = 4;
  params.minRepeatability = 2;
  params.minThreshold = 20;
  params.maxThreshold = 235;
  params.thresholdStep = 15;
  return cv::SimpleBlobDetector::create(params);
}

struct Blobs {
  std::vector<cv::Point2f> centres;
  double radius_px = 0;
};

Blobs find_blobs(const cv::Mat& image, const cv::Ptr<cv::FeatureDetector>& detector) {
  std::vector<cv::KeyPoint> points;
  detector->detect(image, points);
  Blobs blobs;
  std::vector<float> sizes;
  for (const cv::KeyPoint& p : points) {
    blobs.centres.push_back(p.pt);
    sizes.push_back(p.size);
  }
  if (sizes.empty()) return blobs;
  std::nth_element(sizes.begin(), sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2),
                   sizes.end());
  blobs.radius_px = 0.5 * static_cast<double>(sizes[sizes.size() / 2]);
  return blobs;
}

/// One of the four ways to count a lattice of rows: from either end, along either way.
FoundPixels counted(const TargetGrid& grid, const std::vector<cv::Point2f>& centres, bool rows_back,
                    bool columns_back) {
  FoundPixels found(grid.points().size());
  for (const TargetPoint& p : grid.points()) {
    const int row = rows_back ? grid.rows() - 1 - p.row : p.row;
    const int column = columns_back ? grid.columns() - 1 - p.column : p.column;
    const cv::Point2f& c = centres[static_cast<std::size_t>(row * grid.columns() + column)];
    found[static_cast<std::size_t>(p.id)] =
        Eigen::Vector2d(static_cast<double>(c.x), static_cast<double>(c.y));
  }
  return found;
}

/// How many of the places one step beyond the grid's outer discs hold a disc too, and of how many.
struct Beyond {
  int held = 0, places = 0;
};

Beyond discs_beyond(const TargetGrid& grid, const std::vector<cv::Point2f>& blobs,
                    const FoundPixels& found) {
  Beyond beyond;
  const auto look = [&](int index, int inner) {
    if (index < 0 || inner < 0) return;
    const Eigen::Vector2d edge = *found[static_cast<std::size_t>(index)];
    const Eigen::Vector2d step = edge - *found[static_cast<std::size_t>(inner)];
    ++beyond.places;
    beyond.held += std::any_of(blobs.begin(), blobs.end(), [&](const cv::Point2f& b) {
      const Eigen::Vector2d at(static_cast<double>(b.x), static_cast<double>(b.y));
      return (at - edge - step).norm() < 0.25 * step.norm();
    });
  };
  for (int r = 0; r < grid.rows(); ++r) {
    look(grid.at(0, r), grid.at(1, r));
    look(grid.at(grid.columns() - 1, r), grid.at(grid.columns() - 2, r));
  }
  const int step = grid.target().kind == TargetKind::asymmetric_circles ? 2 : 1;
  for (int c = 0; c < grid.columns(); ++c) {
    look(grid.at(c, 0), grid.at(c, step));
    look(grid.at(c, grid.rows() - 1), grid.at(c, grid.rows() - 1 - step));
  }
  return beyond;
}

double mean_y(const TargetGrid& grid, const FoundPixels& found, int row) {
  double sum = 0;
  for (int c = 0; c < grid.columns(); ++c)
    sum += found[static_cast<std::size_t>(grid.at(c, row))]->y();
  return sum / grid.columns();
}

/// Takes the part of the grid that a lattice of the blobs is; else says why not, unless hardly any
/// lattice is there.
void place_part(const Image<std::uint8_t>& image, const TargetGrid& grid, const Blobs& blobs,
                CircleGrid& result) {
  std::vector<Eigen::Vector2d> discs;
  for (const cv::Point2f& c : blobs.centres)
    discs.emplace_back(static_cast<double>(c.x), static_cast<double>(c.y));
  PartialCircles part = place_partial_circles(image, discs, grid);
  if (part.status == TargetStatus::not_seen) return;
  result.status = part.status;
  result.reason = std::move(part.reason);
  result.found = std::move(part.found);
}

/// OpenCV's search, by clusters first. @returns whether it found a lattice
bool find_lattice(const cv::Mat& image, const TargetGrid& grid,
                  const cv::Ptr<cv::FeatureDetector>& detector, std::vector<cv::Point2f>& centres) {
  const bool staggered = grid.target().kind == TargetKind::asymmetric_circles;
  const int flags = (staggered ? cv::CALIB_CB_ASYMMETRIC_GRID : cv::CALIB_CB_SYMMETRIC_GRID) |
                    cv::CALIB_CB_CLUSTERING;
  const cv::Size size(grid.columns(), grid.rows());
  return cv::findCirclesGrid(image, size, centres, flags, detector) ||
         cv::findCirclesGrid(image, size, centres, flags & ~cv::CALIB_CB_CLUSTERING, detector);
}

/// Ways to count a lattice that show the grid's face: staggered rows allow one way only; of even
/// rows two do.
std::vector<FoundPixels> ways_with_face(const TargetGrid& grid,
                                        const std::vector<cv::Point2f>& centres) {
  const bool staggered = grid.target().kind == TargetKind::asymmetric_circles;
  std::vector<FoundPixels> ways;
  for (const bool rows_back : {false, true}) {
    for (const bool columns_back : {false, true}) {
      if (staggered && (rows_back || columns_back)) continue;
      FoundPixels way = counted(grid, centres, rows_back, columns_back);
      if (is_face_seen(grid, way)) ways.push_back(std::move(way));
    }
  }
  return ways;
}

/// The way whose last row is farthest below its first in the image.
const FoundPixels& most_upright(const TargetGrid& grid, const std::vector<FoundPixels>& ways) {
  return *std::max_element(ways.begin(), ways.end(),
                           [&](const FoundPixels& a, const FoundPixels& b) {
                             return mean_y(grid, a, grid.rows() - 1) - mean_y(grid, a, 0) <
                                    mean_y(grid, b, grid.rows() - 1) - mean_y(grid, b, 0);
                           });
}

}  // namespace

CircleGrid find_circle_grid(const Image<std::uint8_t>& image, const TargetGrid& grid) {
  CircleGrid result;
  const bool staggered = grid.target().kind == TargetKind::asymmetric_circles;
  const cv::Mat source(image.height(), image.width(), CV_8U,
                       const_cast<std::uint8_t*>(image.data()));
  const auto detector = blob_detector(image);
  const Blobs blobs = find_blobs(source, detector);
  result.radius_px = blobs.radius_px;
  const std::size_t needed = grid.points().size();
  if (blobs.centres.size() < needed) {
    const bool some = blobs.centres.size() >= 0.3 * static_cast<double>(needed);
    result.status = some ? TargetStatus::too_few_points : TargetStatus::not_seen;
    result.reason = std::to_string(blobs.centres.size()) + " dark discs are seen; the grid has " +
                    std::to_string(needed);
    place_part(image, grid, blobs, result);
    return result;
  }
  const bool symmetric = is_half_turn_symmetric(grid);
  if (staggered && symmetric) {
    // cv::findCirclesGrid counts an even number of staggered rows from the wrong end.
    result.reason = "no lattice of dark discs is seen";
    place_part(image, grid, blobs, result);
    return result;
  }
  std::vector<cv::Point2f> centres;
  if (!find_lattice(source, grid, detector, centres) || centres.size() != needed) {
    result.status = TargetStatus::wrong_target;
    result.reason = std::to_string(blobs.centres.size()) +
                    " dark discs are seen, which make no grid of " +
                    std::to_string(grid.columns()) + " x " + std::to_string(grid.rows());
    place_part(image, grid, blobs, result);
    return result;
  }
  const std::vector<FoundPixels> ways = ways_with_face(grid, centres);
  if (ways.empty()) {
    result.status = TargetStatus::disordered;
    result.reason = "the grid is seen from behind: the image is mirrored";
    return result;
  }
  const FoundPixels& best = most_upright(grid, ways);
  const Beyond beyond = discs_beyond(grid, blobs.centres, best);
  if (4 * beyond.held > beyond.places) {
    result.status = TargetStatus::wrong_target;
    result.reason = "discs go on beyond a grid of " + std::to_string(grid.columns()) + " x " +
                    std::to_string(grid.rows());
    return result;
  }
  result.found = best;
  result.status = symmetric ? TargetStatus::half_turn_unknown : TargetStatus::ok;
  if (symmetric) result.reason = "this grid of discs looks the same after half a turn";
  return result;
}

}  // namespace cousin
