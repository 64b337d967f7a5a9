#include "perception/silhouette/object_window.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "sim/imaging/color.h"

namespace cousin {
namespace {

constexpr int kRing_px =
    12;  ///< of board about the searched region, where paper and ink are measured
constexpr int kLeastPixels = 12;   ///< of a kind, for its median colour
constexpr float kOnPlate = 0.02F;  ///< squares inside the plate's edge

/// Linear value of each 8-bit code.
const std::array<float, 256>& linear_table() {
  static const std::array<float, 256> table = [] {
    std::array<float, 256> t{};
    for (int code = 0; code < 256; ++code) {
      t[static_cast<std::size_t>(code)] = linear_from_srgb8(static_cast<std::uint8_t>(code));
    }
    return t;
  }();
  return table;
}

/// Median of each channel; nothing below kLeastPixels.
std::optional<Eigen::Vector3f> median_color(std::vector<Eigen::Vector3f>& colors) {
  if (colors.size() < kLeastPixels) return std::nullopt;
  Eigen::Vector3f median;
  for (int channel = 0; channel < 3; ++channel) {
    const auto middle = colors.begin() + static_cast<std::ptrdiff_t>(colors.size() / 2);
    std::nth_element(colors.begin(), middle, colors.end(),
                     [&](const auto& a, const auto& b) { return a[channel] < b[channel]; });
    median[channel] = (*middle)[channel];
  }
  return median;
}

std::vector<cv::Point> hull_in(const std::vector<Eigen::Vector2f>& pixels_px, const PixelBox& box) {
  std::vector<cv::Point> points, hull;
  for (const Eigen::Vector2f& pixel : pixels_px) {
    points.emplace_back(static_cast<int>(std::lround(pixel.x())) - box.x,
                        static_cast<int>(std::lround(pixel.y())) - box.y);
  }
  if (!points.empty()) cv::convexHull(points, hull);
  return hull;
}

Image<float> distance_to(const std::vector<std::vector<cv::Point>>& hulls, const PixelBox& box) {
  cv::Mat outside(box.height, box.width, CV_8U, cv::Scalar(255));
  for (const auto& hull : hulls) {
    if (!hull.empty()) cv::fillConvexPoly(outside, hull, cv::Scalar(0));
  }
  Image<float> distance(box.width, box.height, 1e6F);
  if (cv::countNonZero(outside) == box.width * box.height) return distance;
  cv::Mat result(box.height, box.width, CV_32F, distance.data());
  cv::distanceTransform(outside, result, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  return distance;
}

std::optional<PixelBox> box_around(const std::vector<Eigen::Vector2f>& pixels_px,
                                   const Camera& camera, int grow_px) {
  if (pixels_px.empty()) return std::nullopt;
  Eigen::Vector2f low = pixels_px[0], high = pixels_px[0];
  for (const Eigen::Vector2f& pixel : pixels_px) {
    low = low.cwiseMin(pixel);
    high = high.cwiseMax(pixel);
  }
  const auto clamped = [](float value, int size) {
    return static_cast<int>(
        std::clamp(std::lround(value), -1000000L, static_cast<long>(size) + 1000000L));
  };
  const int x0 = std::max(0, clamped(low.x(), camera.width_px) - grow_px);
  const int y0 = std::max(0, clamped(low.y(), camera.height_px) - grow_px);
  const int x1 = std::min(camera.width_px - 1, clamped(high.x(), camera.width_px) + grow_px);
  const int y1 = std::min(camera.height_px - 1, clamped(high.y(), camera.height_px) + grow_px);
  const PixelBox box{x0, y0, x1 - x0 + 1, y1 - y0 + 1};
  if (box.width < 8 || box.height < 8) return std::nullopt;
  return box;
}

/// Paper, ink and object colour as medians; nothing where paper is not seen.
bool measure_colors(ObjectWindow& window, double margin_px) {
  std::vector<Eigen::Vector3f> paper, ink, object;
  const cv::Mat inside_distance = [&] {
    cv::Mat inside(window.box.height, window.box.width, CV_8U);
    for (int y = 0; y < window.box.height; ++y) {
      for (int x = 0; x < window.box.width; ++x)
        inside.at<std::uint8_t>(y, x) = window.to_object_px(x, y) <= 0 ? 255 : 0;
    }
    cv::Mat distance;
    cv::distanceTransform(inside, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE);
    return distance;
  }();
  const auto margin = static_cast<float>(margin_px);
  for (int y = 0; y < window.box.height; ++y) {
    for (int x = 0; x < window.box.width; ++x) {
      const Eigen::Vector3f& color = window.color(x, y);
      if (inside_distance.at<float>(y, x) > 2) object.push_back(color);
      const bool bare = window.to_object_px(x, y) > margin && window.to_others_px(x, y) > margin;
      if (!bare || window.on_plate(x, y) == 0) continue;
      if (window.white(x, y) > 0.98F) paper.push_back(color);
      if (window.white(x, y) < 0.02F) ink.push_back(color);
    }
  }
  const auto paper_color = median_color(paper), object_color = median_color(object);
  if (!paper_color || !object_color) return false;
  window.paper = *paper_color;
  window.object = *object_color;
  // Toner reflects a twentieth of what paper does, where none is seen about the object.
  window.ink = median_color(ink).value_or(0.06F * *paper_color);
  return true;
}

}  // namespace

std::optional<ObjectWindow> open_window(const ViewClusters& view, std::size_t instance,
                                        const BoardPattern& pattern, const OutlineConfig& config) {
  const Camera& camera = view.pose.camera;
  const int grow_px = static_cast<int>(std::ceil(config.margin_px)) + kRing_px;
  const auto box = box_around(view.pixels_px[instance], camera, grow_px);
  if (!box) return std::nullopt;
  ObjectWindow window;
  window.box = *box;

  const Pose& pose = view.pose.camera_from_world;
  Eigen::Matrix3d normalized_from_board = pose.rotation.toRotationMatrix();
  normalized_from_board.col(2) = pose.translation_m;
  LensMap lens(camera);
  const BoardTemplate bare = render_board(pattern, lens, *box, normalized_from_board,
                                          config.blur_sigma_px, TemplateQuality::coarse);
  window.white = bare.white;
  window.color = Image<Eigen::Vector3f>(box->width, box->height);
  window.on_plate = Image<std::uint8_t>(box->width, box->height, 0);
  const auto& linear = linear_table();
  for (int y = 0; y < box->height; ++y) {
    for (int x = 0; x < box->width; ++x) {
      const Rgb8& code = (*view.image)(box->x + x, box->y + y);
      window.color(x, y) = {linear[code.r], linear[code.g], linear[code.b]};
      const Eigen::Vector2f& square = bare.in_squares(x, y);
      if (square.allFinite() && pattern.on_plate(square.x(), square.y(), kOnPlate))
        window.on_plate(x, y) = 1;
    }
  }

  std::vector<std::vector<cv::Point>> others;
  for (std::size_t i = 0; i < view.pixels_px.size(); ++i) {
    if (i != instance) others.push_back(hull_in(view.pixels_px[i], *box));
  }
  window.to_object_px = distance_to({hull_in(view.pixels_px[instance], *box)}, *box);
  window.to_others_px = distance_to(others, *box);
  if (!measure_colors(window, config.margin_px)) return std::nullopt;
  return window;
}

namespace {

/// Whether a pixel shows more of the object than of the board behind it.
bool shows_object(const ObjectWindow& window, int x, int y) {
  const Eigen::Vector3f& color = window.color(x, y);
  const Eigen::Vector3f& object = window.object;
  if (window.on_plate(x, y) == 0) {
    // Nothing is known of what lies beyond the plate: the object's hue decides, to within 14
    // degrees.
    return color.dot(object) > 0.97F * color.norm() * object.norm();
  }
  // color = a object + w board, least squares; w is held near 1 - a where the board is dark.
  const Eigen::Vector3f board = window.board_at(x, y);
  const float hold = 0.02F * window.paper.squaredNorm();
  const float aa = object.squaredNorm() + hold, ww = board.squaredNorm() + hold,
              aw = object.dot(board) + hold;
  const float ca = object.dot(color) + hold, cw = board.dot(color) + hold;
  const float determinant = aa * ww - aw * aw;
  if (!(determinant > 0)) return false;
  const float a = (ca * ww - cw * aw) / determinant, w = (cw * aa - ca * aw) / determinant;
  const float from_object = std::max(0.0F, a) * object.norm(),
              from_board = std::max(0.0F, w) * board.norm();
  // Shaded paper that a pale object throws its light on lies between both. Outside the cluster, the
  // more it is outside, the surer the object must be.
  const float least = std::min(1.5F, 0.7F + 0.3F * window.to_object_px(x, y));
  return a > 0.12F && from_object > least * from_board;
}

}  // namespace

Image<std::uint8_t> rough_mask(const ObjectWindow& window, const OutlineConfig& config) {
  const int width = window.box.width, height = window.box.height;
  cv::Mat mask(height, width, CV_8U, cv::Scalar(0));
  const auto margin = static_cast<float>(config.margin_px);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float own = window.to_object_px(x, y);
      if (own > margin || own > window.to_others_px(x, y)) continue;
      if (shows_object(window, x, y)) mask.at<std::uint8_t>(y, x) = 255;
    }
  }
  cv::Mat labels, sizes, centres;
  const int count = cv::connectedComponentsWithStats(mask, labels, sizes, centres, 4);
  int best = 0, best_size = 0;
  std::vector<int> overlap(static_cast<std::size_t>(count), 0);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (window.to_object_px(x, y) <= 0) ++overlap[static_cast<std::size_t>(labels.at<int>(y, x))];
    }
  }
  for (int label = 1; label < count; ++label) {
    if (overlap[static_cast<std::size_t>(label)] > best_size) {
      best = label;
      best_size = overlap[static_cast<std::size_t>(label)];
    }
  }
  Image<std::uint8_t> result(width, height, 0);
  if (best == 0) return result;
  // Holes (highlights) are what the outside does not reach.
  cv::Mat piece = labels == best, outside;
  cv::copyMakeBorder(piece, outside, 1, 1, 1, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
  cv::floodFill(outside, cv::Point(0, 0), cv::Scalar(128));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x)
      result(x, y) = outside.at<std::uint8_t>(y + 1, x + 1) == 128 ? 0 : 255;
  }
  return result;
}

}  // namespace cousin
