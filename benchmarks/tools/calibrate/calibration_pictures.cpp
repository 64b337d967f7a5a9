#include "benchmarks/tools/calibrate/calibration_pictures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "sim/imaging/image_io.h"

namespace cousin {
namespace {

constexpr int kWidth = 640;  ///< of a picture
constexpr int kColumns = 16, kRows = 12;

/// A canvas of the camera's shape; OpenCV draws, in red, green, blue.
struct Canvas {
  cv::Mat image;
  double scale = 1;  ///< canvas pixels in one of the camera's

  Canvas(const Camera& camera, const cv::Scalar& ground) {
    scale = static_cast<double>(kWidth) / camera.width_px;
    image = cv::Mat(std::max(1, static_cast<int>(std::lround(camera.height_px * scale))), kWidth,
                    CV_8UC3, ground);
  }
  /// OpenCV's sixteenths of a pixel.
  cv::Point at(const Eigen::Vector2d& pixel_px) const {
    const Eigen::Vector2d p =
        (scale * (pixel_px + Eigen::Vector2d::Constant(0.5)) - Eigen::Vector2d::Constant(0.5))
            .cwiseMax(-1000)
            .cwiseMin(5000);
    return {static_cast<int>(std::lround(16 * p.x())), static_cast<int>(std::lround(16 * p.y()))};
  }
  void dot(const Eigen::Vector2d& pixel_px, int sixteenths, const cv::Scalar& color) {
    cv::circle(image, at(pixel_px), sixteenths, color, cv::FILLED, cv::LINE_AA, 4);
  }
  void line(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const cv::Scalar& color) {
    cv::line(image, at(from), at(to), color, 1, cv::LINE_AA, 4);
  }
  Image<Rgb8> result() const {
    Image<Rgb8> out(image.cols, image.rows);
    for (int y = 0; y < image.rows; ++y) {
      for (int x = 0; x < image.cols; ++x) {
        const cv::Vec3b& c = image.at<cv::Vec3b>(y, x);
        out(x, y) = {c[0], c[1], c[2]};
      }
    }
    return out;
  }
};

/// Blue over green to yellow, for 0..1: readable without red and green.
cv::Scalar shade(double share) {
  static constexpr std::array<std::array<double, 3>, 5> kStops = {
      {{68, 1, 84}, {59, 82, 139}, {33, 145, 140}, {94, 201, 98}, {253, 231, 37}}};
  const double t = 4 * std::clamp(share, 0.0, 1.0);
  const auto i = std::min<std::size_t>(3, static_cast<std::size_t>(t));
  const double u = t - static_cast<double>(i);
  cv::Scalar color;
  for (std::size_t k = 0; k < 3; ++k)
    color[static_cast<int>(k)] = (1 - u) * kStops[i][k] + u * kStops[i + 1][k];
  return color;
}

const Camera& lens_of(const CalibrationRun& run, int camera) {
  return run.result.cameras[static_cast<std::size_t>(camera)];
}

void draw_sample(const CalibrationRun& run, Canvas& canvas) {
  if (run.sample.empty()) return;
  const cv::Mat sample(run.sample.height(), run.sample.width(), CV_8UC3,
                       const_cast<Rgb8*>(run.sample.data()));
  cv::Mat small;
  cv::resize(sample, small, canvas.image.size(), 0, 0, cv::INTER_AREA);
  canvas.image = 0.45 * small + 0.35 * canvas.image;
}

void draw_next(const CalibrationRun& run, int camera, Canvas& canvas) {
  const auto& next = run.verdicts[static_cast<std::size_t>(camera)].next;
  if (!next) return;
  const Eigen::Vector2d half = 0.5 * print_size_m(run.photos.target);
  constexpr int kSteps = 24;
  const auto seen = [&](double x, double y) {
    return project(lens_of(run, camera),
                   next->camera_from_target * Eigen::Vector3d(x * half.x(), y * half.y(), 0));
  };
  const std::array<Eigen::Vector2d, 5> corners = {{{-1, 1}, {1, 1}, {1, -1}, {-1, -1}, {-1, 1}}};
  for (std::size_t side = 0; side < 4; ++side) {
    for (int i = 0; i < kSteps; ++i) {
      const auto place = [&](int k) -> Eigen::Vector2d {
        const double t = static_cast<double>(k) / kSteps;
        return (1 - t) * corners[side] + t * corners[side + 1];
      };
      const Eigen::Vector2d a = place(i), b = place(i + 1);
      const auto p = seen(a.x(), a.y()), q = seen(b.x(), b.y());
      if (p && q)
        cv::line(canvas.image, canvas.at(*p), canvas.at(*q), {60, 130, 255}, 2, cv::LINE_AA, 4);
    }
  }
}

struct Cell {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double squares = 0;
  int count = 0;
};

}  // namespace

Image<Rgb8> sample_picture(const CalibrationPhotos& photos, const std::vector<TargetView>& views) {
  for (std::size_t i = 0; i < views.size(); ++i) {
    const CalibrationPhoto& photo = photos.photos[i];
    if (photo.camera != 0 || !is_usable(views[i])) continue;
    if (!photo.is_linear_grey) {
      return read_color(photo.file);
    }
    const Image<std::uint8_t> grey = read_png8(photo.file);
    Image<Rgb8> sample(grey.width(), grey.height());
    for (std::size_t k = 0; k < grey.size(); ++k) {
      const std::uint8_t v = grey.data()[k];
      sample.data()[k] = {v, v, v};
    }
    return sample;
  }
  return {};
}

Image<Rgb8> coverage_picture(const CalibrationRun& run, int camera) {
  Canvas canvas(lens_of(run, camera), {235, 235, 235});
  if (camera == 0) draw_sample(run, canvas);
  for (const CalibrationResidual& r : run.result.residuals) {
    const TargetView& view = run.input.views[static_cast<std::size_t>(r.view)];
    if (view.camera != camera) continue;
    for (const TargetObservation& o : view.points) {
      if (o.id != r.id) continue;
      canvas.dot(o.pixel_px, 40, r.rejected ? cv::Scalar(230, 60, 40) : cv::Scalar(40, 190, 70));
    }
  }
  draw_next(run, camera, canvas);
  return canvas.result();
}

ResidualPicture residual_picture(const CalibrationRun& run, int camera) {
  const Camera& lens = lens_of(run, camera);
  Canvas canvas(lens, {200, 200, 200});
  std::vector<Cell> cells(kColumns * kRows);
  for (const CalibrationResidual& r : run.result.residuals) {
    const TargetView& view = run.input.views[static_cast<std::size_t>(r.view)];
    if (view.camera != camera || r.rejected) continue;
    for (const TargetObservation& o : view.points) {
      if (o.id != r.id) continue;
      const int c =
          std::clamp(static_cast<int>(o.pixel_px.x() / lens.width_px * kColumns), 0, kColumns - 1);
      const int row =
          std::clamp(static_cast<int>(o.pixel_px.y() / lens.height_px * kRows), 0, kRows - 1);
      Cell& cell = cells[static_cast<std::size_t>(row * kColumns + c)];
      cell.sum += r.residual_px;
      cell.squares += r.residual_px.squaredNorm();
      ++cell.count;
    }
  }
  const double predicted_px =
      std::max(1e-6, run.verdicts[static_cast<std::size_t>(camera)].predicted_px);
  const Eigen::Vector2d size(static_cast<double>(lens.width_px) / kColumns,
                             static_cast<double>(lens.height_px) / kRows);
  double longest = 0;
  for (const Cell& cell : cells) {
    if (cell.count > 0) longest = std::max(longest, cell.sum.norm() / cell.count);
  }
  ResidualPicture picture;
  picture.pixels_per_px = longest > 0 ? 0.8 * size.minCoeff() / longest : 1;
  for (int pass = 0; pass < 2; ++pass) {
    for (int row = 0; row < kRows; ++row) {
      for (int c = 0; c < kColumns; ++c) {
        const Cell& cell = cells[static_cast<std::size_t>(row * kColumns + c)];
        if (cell.count == 0) continue;
        const Eigen::Vector2d low(c * size.x(), row * size.y());
        const Eigen::Vector2d middle = low + 0.5 * size;
        if (pass == 0) {
          const cv::Point a = canvas.at(low), b = canvas.at(low + size);
          cv::rectangle(canvas.image, a, b,
                        shade(std::sqrt(cell.squares / (2 * cell.count)) / (3 * predicted_px)),
                        cv::FILLED, cv::LINE_8, 4);
        } else {
          canvas.line(middle, middle + picture.pixels_per_px * cell.sum / cell.count,
                      {255, 255, 255});
          canvas.dot(middle, 24, {255, 255, 255});
        }
      }
    }
  }
  picture.image = canvas.result();
  return picture;
}

UncertaintyPicture uncertainty_picture(const CalibrationRun& run, int camera) {
  const UncertaintyMap& map = run.verdicts[static_cast<std::size_t>(camera)].uncertainty;
  UncertaintyPicture picture;
  if (map.columns < 2 || map.rows < 2) return picture;
  cv::Mat worst(map.rows, map.columns, CV_64F);
  picture.least_px = 1e300;
  for (int r = 0; r < map.rows; ++r) {
    for (int c = 0; c < map.columns; ++c) {
      const Eigen::Matrix2d& covariance =
          map.covariance_px2[static_cast<std::size_t>(r * map.columns + c)];
      const double value = covariance.allFinite() ? worst_deviation_px(covariance) : std::nan("");
      worst.at<double>(r, c) = value;
      if (std::isnan(value)) continue;
      picture.least_px = std::min(picture.least_px, value);
      picture.most_px = std::max(picture.most_px, value);
    }
  }
  Canvas canvas(lens_of(run, camera), {200, 200, 200});
  const double least = std::max(1e-12, picture.least_px);
  const double span = std::max(1e-6, std::log(picture.most_px / least));
  for (int y = 0; y < canvas.image.rows; ++y) {
    for (int x = 0; x < canvas.image.cols; ++x) {
      // Bilinear between the map's pixels, which span the image.
      const double u = x * (map.columns - 1.0) / (canvas.image.cols - 1);
      const double v = y * (map.rows - 1.0) / (canvas.image.rows - 1);
      const int i = std::min(map.columns - 2, static_cast<int>(u));
      const int j = std::min(map.rows - 2, static_cast<int>(v));
      const double s = u - i, t = v - j;
      const double value =
          (1 - t) * ((1 - s) * worst.at<double>(j, i) + s * worst.at<double>(j, i + 1)) +
          t * ((1 - s) * worst.at<double>(j + 1, i) + s * worst.at<double>(j + 1, i + 1));
      if (std::isnan(value)) continue;
      const cv::Scalar color = shade(std::log(value / least) / span);
      canvas.image.at<cv::Vec3b>(y, x) = {static_cast<unsigned char>(color[0]),
                                          static_cast<unsigned char>(color[1]),
                                          static_cast<unsigned char>(color[2])};
    }
  }
  picture.image = canvas.result();
  return picture;
}

DepthPicture depth_picture(const CalibrationRun& run) {
  DepthPicture picture;
  if (!run.depth || run.photos.depths.empty()) return picture;
  const Camera& lens = lens_of(run, run.photos.depths.front().camera);
  std::vector<std::vector<double>> cells(kColumns * kRows);
  for (const DepthView& view : run.depth_views) {
    for (const DepthSample& s : view.samples) {
      const int c = std::clamp(static_cast<int>((s.pixel_px.x() + 0.5) / lens.width_px * kColumns),
                               0, kColumns - 1);
      const int row = std::clamp(static_cast<int>((s.pixel_px.y() + 0.5) / lens.height_px * kRows),
                                 0, kRows - 1);
      const double share = run.config.depth.distance_m / s.true_m;
      cells[static_cast<std::size_t>(row * kColumns + c)].push_back((s.measured_m - s.true_m) *
                                                                    share * share);
    }
  }
  for (std::vector<double>& cell : cells) {
    if (cell.empty()) continue;
    const auto middle = cell.begin() + static_cast<std::ptrdiff_t>(cell.size() / 2);
    std::nth_element(cell.begin(), middle, cell.end());
    cell = {*middle};
    picture.most_m = std::max(picture.most_m, std::abs(cell.front()));
  }
  Canvas canvas(lens, {200, 200, 200});
  const Eigen::Vector2d size(static_cast<double>(lens.width_px) / kColumns,
                             static_cast<double>(lens.height_px) / kRows);
  for (int row = 0; row < kRows; ++row) {
    for (int c = 0; c < kColumns; ++c) {
      const std::vector<double>& cell = cells[static_cast<std::size_t>(row * kColumns + c)];
      if (cell.empty()) continue;
      const Eigen::Vector2d low(c * size.x(), row * size.y());
      cv::rectangle(canvas.image, canvas.at(low), canvas.at(low + size),
                    shade(0.5 + 0.5 * cell.front() / std::max(1e-9, picture.most_m)), cv::FILLED,
                    cv::LINE_8, 4);
    }
  }
  picture.image = canvas.result();
  return picture;
}

}  // namespace cousin
