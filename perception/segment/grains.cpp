#include "perception/segment/grains.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <stdexcept>
#include <string>

#include "sim/config/limits.h"
#include "sim/imaging/color.h"

namespace cousin {
namespace {

constexpr int kMargin_px = 8;       ///< of ground around a blob
constexpr int kLeastArea_px = 100;  ///< smaller blobs are scratches and dust
constexpr int kGroundDistance = 4;  ///< pixels between a blob and what counts as ground around it

double median(std::vector<float>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// A blob's box, with a margin, and where it came from.
struct Blob {
  cv::Rect window;
  int label = 0;
  bool at_border = false;
};

/// A blob with its outline at sub-pixel precision.
struct Outline {
  std::vector<cv::Point2f> points_px;  ///< crossings between neighbouring pixels, no order
  std::vector<cv::Point> contour_px;   ///< outer pixels in order
  cv::RotatedRect rectangle;
  double length_px = 0, width_px = 0, angle_rad = 0;
  double area_px = 0;
};

/// Mean of the three linear channels, blurred.
cv::Mat1f linear_light(const Image<Rgb8>& image, double smoothing_px) {
  std::array<float, 256> linear{};
  for (int code = 0; code < 256; ++code) {
    linear[static_cast<std::size_t>(code)] = linear_from_srgb8(static_cast<std::uint8_t>(code)) / 3;
  }
  cv::Mat1f light(image.height(), image.width());
  for (int y = 0; y < image.height(); ++y) {
    std::transform(image.row(y).begin(), image.row(y).end(), light[y],
                   [&](const Rgb8& c) { return linear[c.r] + linear[c.g] + linear[c.b]; });
  }
  if (smoothing_px > 0) cv::GaussianBlur(light, light, {}, smoothing_px);
  return light;
}

std::vector<Blob> find_blobs(const cv::Mat1f& light, cv::Mat1i& labels) {
  cv::Mat1b codes(light.size());
  for (int y = 0; y < light.rows; ++y) {
    std::transform(light[y], light[y] + light.cols, codes[y],
                   [](float v) { return srgb8_from_linear(v); });
  }
  cv::Mat1b mask;
  cv::threshold(codes, mask, 0, 255, cv::THRESH_BINARY | cv::THRESH_OTSU);
  cv::Mat1i stats;
  cv::Mat1d centres;
  const int count = cv::connectedComponentsWithStats(mask, labels, stats, centres, 8, CV_32S);
  const cv::Rect whole(0, 0, light.cols, light.rows);
  std::vector<Blob> blobs;
  for (int i = 1; i < count; ++i) {
    if (stats(i, cv::CC_STAT_AREA) < kLeastArea_px) continue;
    const cv::Rect box(stats(i, cv::CC_STAT_LEFT), stats(i, cv::CC_STAT_TOP),
                       stats(i, cv::CC_STAT_WIDTH), stats(i, cv::CC_STAT_HEIGHT));
    const cv::Rect wide(box.x - kMargin_px, box.y - kMargin_px, box.width + 2 * kMargin_px,
                        box.height + 2 * kMargin_px);
    blobs.push_back({wide & whole, i, (wide & whole) != wide});
  }
  return blobs;
}

/// Half way between the ground near the blob and the blob's median.
std::optional<double> half_level(const cv::Mat1f& light, const cv::Mat1i& labels, int label) {
  cv::Mat1b any = labels != 0;
  cv::dilate(any, any,
             cv::getStructuringElement(cv::MORPH_RECT,
                                       {2 * kGroundDistance + 1, 2 * kGroundDistance + 1}));
  std::vector<float> inside, ground;
  for (int y = 0; y < light.rows; ++y) {
    for (int x = 0; x < light.cols; ++x) {
      if (labels(y, x) == label) inside.push_back(light(y, x));
      if (any(y, x) == 0) ground.push_back(light(y, x));
    }
  }
  if (inside.empty() || ground.empty()) return std::nullopt;
  return 0.5 * (median(inside) + median(ground));
}

/// The parts of the blob above `level`; grains that touch by a shaded edge come apart here.
std::vector<cv::Mat1b> parts_above(const cv::Mat1f& light, const cv::Mat1i& labels, int label,
                                   double level) {
  cv::Mat1b above(light.size());
  for (int y = 0; y < light.rows; ++y) {
    for (int x = 0; x < light.cols; ++x) {
      above(y, x) = light(y, x) >= level && (labels(y, x) == 0 || labels(y, x) == label) ? 255 : 0;
    }
  }
  cv::Mat1i names, stats;
  cv::Mat1d centres;
  const int count = cv::connectedComponentsWithStats(above, names, stats, centres, 8, CV_32S);
  std::vector<cv::Mat1b> parts;
  for (int i = 1; i < count; ++i) {
    if (stats(i, cv::CC_STAT_AREA) < kLeastArea_px) continue;
    const cv::Mat1b part = names == i;
    if (cv::countNonZero(part & (labels == label)) > 0) parts.push_back(part);
  }
  return parts;
}

std::vector<cv::Point2f> level_crossings(const cv::Mat1f& light, const cv::Mat1b& part,
                                         double level) {
  std::vector<cv::Point2f> points;
  const auto cross = [&](int x0, int y0, int x1, int y1) {
    if ((part(y0, x0) != 0) == (part(y1, x1) != 0)) return;
    const double a = light(y0, x0), b = light(y1, x1);
    const auto t = static_cast<float>(std::clamp(a == b ? 0.5 : (level - a) / (b - a), 0.0, 1.0));
    points.emplace_back(static_cast<float>(x0) + t * static_cast<float>(x1 - x0),
                        static_cast<float>(y0) + t * static_cast<float>(y1 - y0));
  };
  for (int y = 0; y < part.rows; ++y) {
    for (int x = 0; x < part.cols; ++x) {
      if (x + 1 < part.cols) cross(x, y, x + 1, y);
      if (y + 1 < part.rows) cross(x, y, x, y + 1);
    }
  }
  return points;
}

std::optional<Outline> outline_of(const cv::Mat1f& light, const cv::Mat1b& part, double level) {
  Outline outline;
  outline.points_px = level_crossings(light, part, level);
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(part, contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  if (contours.empty() || outline.points_px.size() < 8) return std::nullopt;
  outline.contour_px = contours.front();
  outline.area_px = cv::contourArea(outline.contour_px);
  outline.rectangle = cv::minAreaRect(outline.points_px);
  const cv::Size2f size = outline.rectangle.size;
  double angle = outline.rectangle.angle * std::numbers::pi / 180;
  if (size.height > size.width) angle += std::numbers::pi / 2;
  outline.length_px = std::max(size.width, size.height);
  outline.width_px = std::min(size.width, size.height);
  outline.angle_rad = std::remainder(angle, std::numbers::pi);
  return outline;
}

std::vector<Outline> trace(const cv::Mat1f& light, const cv::Mat1i& labels, const Blob& blob) {
  const cv::Mat1f near = light(blob.window);
  const cv::Mat1i names = labels(blob.window);
  std::vector<Outline> outlines;
  const auto level = half_level(near, names, blob.label);
  if (!level) return outlines;
  for (const cv::Mat1b& part : parts_above(near, names, blob.label, *level)) {
    if (auto outline = outline_of(near, part, *level)) outlines.push_back(std::move(*outline));
  }
  return outlines;
}

Eigen::Vector2d centre_px(const Blob& blob, const Outline& outline) {
  return {outline.rectangle.center.x + blob.window.x, outline.rectangle.center.y + blob.window.y};
}

/// Median over lines a pixel apart of the distance between the two ends, the outer tenths left out.
double length_by_lines_px(const Outline& outline) {
  const Eigen::Vector2d along(std::cos(outline.angle_rad), std::sin(outline.angle_rad));
  const auto lines = static_cast<std::size_t>(std::floor(outline.width_px)) + 1;
  std::vector<std::array<double, 2>> ends(lines, {1e9, -1e9});
  for (const cv::Point2f& p : outline.points_px) {
    const Eigen::Vector2d d(p.x - outline.rectangle.center.x, p.y - outline.rectangle.center.y);
    const double across = along.x() * d.y() - along.y() * d.x() + 0.5 * outline.width_px;
    auto& line =
        ends[static_cast<std::size_t>(std::clamp(across, 0.0, static_cast<double>(lines - 1)))];
    line = {std::min(line[0], along.dot(d)), std::max(line[1], along.dot(d))};
  }
  std::vector<float> lengths;
  for (std::size_t i = lines / 10; i < lines - lines / 10; ++i) {
    const double length = ends[i][1] - ends[i][0];
    if (length > 0.5 * outline.length_px) lengths.push_back(static_cast<float>(length));
  }
  return lengths.empty() ? outline.length_px : median(lengths);
}

bool is_strip(const Outline& outline, const GrainConfig& config, const Image<Rgb8>& image) {
  const double share = outline.area_px / (outline.length_px * outline.width_px);
  const double least_px = 0.05 * std::max(image.width(), image.height());
  return outline.length_px > least_px &&
         outline.length_px > config.strip_aspect * outline.width_px && share > 0.8;
}

/// Whether a dent or missing area tells of several grains.
bool is_dented(const Outline& outline, const GrainConfig& config) {
  std::vector<int> hull;
  cv::convexHull(outline.contour_px, hull);
  std::vector<cv::Point> hull_px;
  for (const int i : hull) hull_px.push_back(outline.contour_px[static_cast<std::size_t>(i)]);
  if (outline.area_px < config.least_solidity * cv::contourArea(hull_px)) return true;
  std::sort(hull.begin(), hull.end());
  if (hull.size() < 4) return false;
  std::vector<cv::Vec4i> dents;
  cv::convexityDefects(outline.contour_px, hull, dents);
  return std::any_of(dents.begin(), dents.end(), [&](const cv::Vec4i& dent) {
    return dent[3] / 256.0 > config.most_dent * outline.width_px + 1;  // a pixel for the staircase
  });
}

/// Mean of the strips within 2 % of the longest, which comes first.
double usual_length_px(const std::vector<Strip>& strips) {
  double sum_px = 0;
  int counted = 0;
  for (const Strip& strip : strips) {
    if (strip.length_px < 0.98 * strips.front().length_px) continue;
    sum_px += strip.length_px;
    ++counted;
  }
  return sum_px / counted;
}

struct Traced {
  Blob blob;
  Outline outline;
};

/// Single grains, grains that touch, fragments and others; needs the scale.
void sort_into(GrainPhoto& photo, const std::vector<Traced>& blobs, const GrainConfig& config) {
  std::vector<const Traced*> single;
  std::vector<float> areas_px;
  for (const Traced& traced : blobs) {
    const double length_m = traced.outline.length_px * photo.m_per_px;
    if (traced.blob.at_border) {
      photo.other_px.push_back(centre_px(traced.blob, traced.outline));
    } else if (length_m < config.least_length_m) {
      photo.fragments += length_m >= 0.001 ? 1 : 0;
    } else if (length_m > config.most_length_m || is_dented(traced.outline, config)) {
      photo.touching_px.push_back(centre_px(traced.blob, traced.outline));
    } else {
      single.push_back(&traced);
      areas_px.push_back(static_cast<float>(traced.outline.area_px));
    }
  }
  if (single.empty()) return;
  const double most_px = config.most_area * median(areas_px);
  for (const Traced* traced : single) {
    const Outline& outline = traced->outline;
    const Eigen::Vector2d centre = centre_px(traced->blob, outline);
    if (outline.area_px > most_px) {
      photo.touching_px.push_back(centre);
    } else {
      photo.grains.push_back({centre, outline.angle_rad, outline.length_px * photo.m_per_px,
                              outline.width_px * photo.m_per_px});
    }
  }
}

}  // namespace

Fields fields(GrainConfig& c) {
  return {{"strip_length_m", &c.strip_length_m, "length a strip stands for", 1e-3, 10},
          {"strip_aspect", &c.strip_aspect, "least length over width of a strip", 2, 100},
          {"least_length_m", &c.least_length_m, "shortest grain", 1e-4, 1},
          {"most_length_m", &c.most_length_m, "longest grain", 1e-4, 1},
          {"most_dent", &c.most_dent, "deepest dent of one grain, over its width", 0.01, 1},
          {"least_solidity", &c.least_solidity, "least area over that of the hull", 0.1, 1},
          {"most_area", &c.most_area, "largest area of one grain, over the median", 1, 10},
          {"smoothing_px", &c.smoothing_px, "blur against noise", 0, 10}};
}

void validate(const GrainConfig& config) {
  GrainConfig copy = config;
  check_limits(fields(copy), "grains");
  if (!(config.least_length_m < config.most_length_m))
    throw std::invalid_argument(
        "grains: least_length_m = " + std::to_string(config.least_length_m) +
        " is not below most_length_m = " + std::to_string(config.most_length_m));
}

GrainPhoto measure_grains(const Image<Rgb8>& image, const GrainConfig& config) {
  validate(config);
  GrainPhoto photo;
  if (image.empty()) return photo;
  const cv::Mat1f light = linear_light(image, config.smoothing_px);
  cv::Mat1i labels;
  std::vector<Traced> rest;
  for (const Blob& blob : find_blobs(light, labels)) {
    for (Outline& outline : trace(light, labels, blob)) {
      if (!blob.at_border && is_strip(outline, config, image)) {
        photo.strips.push_back({centre_px(blob, outline), outline.angle_rad,
                                length_by_lines_px(outline), outline.width_px});
      } else {
        rest.push_back({blob, std::move(outline)});
      }
    }
  }
  if (photo.strips.empty()) return photo;
  std::sort(photo.strips.begin(), photo.strips.end(),
            [](const Strip& a, const Strip& b) { return a.length_px > b.length_px; });
  photo.m_per_px = config.strip_length_m / usual_length_px(photo.strips);
  sort_into(photo, rest, config);
  photo.status = photo.grains.empty() ? GrainStatus::no_grains : GrainStatus::ok;
  return photo;
}

}  // namespace cousin
