#include "benchmarks/suites/real/cones_stereo.h"

#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <string>

#include "benchmarks/report/pictures.h"
#include "perception/stereo/stereo_depth.h"
#include "perception/stereo/stereo_pair.h"
#include "sim/imaging/image_io.h"
#include "sim/types/no_value.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

constexpr const char* kScene = "cones";
constexpr int kRange_px = 64;         ///< as the set says
constexpr double kBaseline_m = 0.16;  ///< nobody says it: only disparities are scored

/// Everything that is known of the pair.
struct Cones {
  Image<std::uint8_t> left, right;
  Image<float> disparity_px;  ///< NaN = not known
  Image<std::uint8_t> visible;
};

cv::Mat read_matrix(const fs::path& file, int type) {
  cv::Mat matrix = cv::imread(file.string(), cv::IMREAD_UNCHANGED);
  if (matrix.empty()) throw std::runtime_error(file.string() + ": is no picture that OpenCV reads");
  if (matrix.channels() == 3 && CV_MAT_CN(type) == 1) cv::extractChannel(matrix, matrix, 0);
  if (matrix.type() != type)
    throw std::runtime_error(file.string() + ": pixels are of another type than expected");
  return matrix;
}

template <class T>
Image<T> read_grey(const fs::path& file, int type) {
  const cv::Mat matrix = read_matrix(file, type);
  Image<T> image(matrix.cols, matrix.rows);
  for (int y = 0; y < matrix.rows; ++y) {
    for (int x = 0; x < matrix.cols; ++x) image(x, y) = matrix.at<T>(y, x);
  }
  return image;
}

Cones read_cones(const fs::path& folder) {
  Cones cones{read_grey<std::uint8_t>(folder / "Cones_LEFT.tif", CV_8UC1),
              read_grey<std::uint8_t>(folder / "Cones_RIGHT.tif", CV_8UC1),
              read_grey<float>(folder / "Cones_LEFT_GT.tif", CV_32FC1),
              read_grey<std::uint8_t>(folder / "Occlusion_LEFT.png", CV_8UC1)};
  for (float& d : cones.disparity_px) {
    if (!(d > 0)) d = kNone;
  }
  const auto same = [&](const auto& image) {
    return image.width() == cones.left.width() && image.height() == cones.left.height();
  };
  if (!same(cones.right) || !same(cones.disparity_px) || !same(cones.visible))
    throw std::runtime_error(folder.string() + ": its images differ in size");
  return cones;
}

struct Errors {
  std::int64_t there = 0, measured = 0, off_1_px = 0, off_2_px = 0, with_sigma = 0, within = 0;
  double sum_px = 0;

  void add(double true_px, double found_px, double sigma_px) {
    ++there;
    if (std::isnan(found_px)) return;
    ++measured;
    const double off_px = std::abs(found_px - true_px);
    sum_px += off_px;
    off_1_px += off_px > 1;
    off_2_px += off_px > 2;
    if (!(sigma_px > 0)) return;
    ++with_sigma;
    within += off_px <= 1.96 * sigma_px;
  }
};

void add_rows(const Errors& errors, const std::string& name, const std::string& method,
              RealPart& part) {
  const auto add = [&](const char* metric, double value, const char* unit, std::int64_t n) {
    part.rows.push_back(real_row(kScene, name, method, metric, value, unit, n));
  };
  const auto share = [](std::int64_t a, std::int64_t b) {
    return static_cast<double>(a) / static_cast<double>(b);
  };
  add("disparity.unmatched", 1 - share(errors.measured, errors.there), "1", errors.there);
  add("disparity.bad_1_px", share(errors.off_1_px, errors.measured), "1", errors.measured);
  add("disparity.bad_2_px", share(errors.off_2_px, errors.measured), "1", errors.measured);
  add("disparity.mean_error", errors.sum_px / static_cast<double>(errors.measured), "px",
      errors.measured);
  if (errors.with_sigma > 0)
    add("disparity.coverage_95", share(errors.within, errors.with_sigma), "1", errors.with_sigma);
}

/// Scores one method. @return its depths
Image<float> score(const Cones& cones, const Capture& capture, PairMatcher matcher,
                   RealPart& part) {
  StereoDepthConfig config;
  config.pair.matcher = matcher;
  config.pair.range_px = kRange_px;
  config.calibration_px = 0.01;  // it is rectified already
  const std::string method(to_string(matcher));
  const StageClock clock(method);
  StereoMeasure measured = measure_stereo(capture, 0, config);
  const double wall_s = clock.finish().wall_s;
  if (measured.depth.depth_m.empty()) {
    part.rows.push_back(not_solved_row(kScene, method, measured.findings.why_none));
    return {};
  }
  const double fb = capture.rig[0].camera.fx_px * kBaseline_m;
  Errors visible, all;
  for (std::size_t i = 0; i < cones.disparity_px.size(); ++i) {
    const auto true_px = static_cast<double>(cones.disparity_px.data()[i]);
    if (std::isnan(true_px)) continue;
    const auto z_m = static_cast<double>(measured.depth.depth_m.data()[i]);
    const double sigma_px =
        measured.depth.sigma_m.empty()
            ? 0
            : fb / (z_m * z_m) * static_cast<double>(measured.depth.sigma_m.data()[i]);
    all.add(true_px, fb / z_m, sigma_px);
    if (cones.visible.data()[i] != 0) visible.add(true_px, fb / z_m, sigma_px);
  }
  add_rows(visible, "visible", method, part);
  add_rows(all, "all", method, part);
  ScoreRow seconds = real_row(kScene, "all", method, "seconds.depth", wall_s, "s", 1);
  seconds.wall_s = wall_s;
  part.rows.push_back(std::move(seconds));
  return std::move(measured.depth.depth_m);
}

Image<Rgb8> in_grey(const Image<std::uint8_t>& image) {
  Image<Rgb8> grey(image.width(), image.height());
  for (std::size_t i = 0; i < image.size(); ++i)
    grey.data()[i] = {image.data()[i], image.data()[i], image.data()[i]};
  return grey;
}

/// Depths where disparities are known.
Image<float> true_depths(const Cones& cones, const Capture& capture) {
  const auto fb = static_cast<float>(capture.rig[0].camera.fx_px * kBaseline_m);
  Image<float> depth_m(cones.left.width(), cones.left.height());
  for (std::size_t i = 0; i < depth_m.size(); ++i)
    depth_m.data()[i] = fb / cones.disparity_px.data()[i];
  return depth_m;
}

}  // namespace

RealPart cones_stereo(const fs::path& real_data, const fs::path& out, bool /*quick*/) {
  RealPart part;
  const fs::path folder = real_data / "stereo/middlebury2003_cones_pandora";
  if (!fs::exists(folder)) {
    part.rows.push_back(not_solved_row(kScene, "all", folder.string() + " is absent"));
    return part;
  }
  const Cones cones = read_cones(folder);
  const Capture capture = capture_of_pair(cones.left, cones.right, cones.left.width(), kBaseline_m);
  std::vector<Image<Rgb8>> pictures = {in_grey(cones.left),
                                       depth_in_color(true_depths(cones, capture))};
  for (const PairMatcher matcher : {PairMatcher::ours, PairMatcher::opencv}) {
    const Image<float> depth_m = score(cones, capture, matcher, part);
    if (!depth_m.empty()) pictures.push_back(depth_in_color(depth_m));
  }
  const Image<Rgb8> all = side_by_side(pictures);
  fs::create_directories(out);
  write_png(out / "cones.png", all);
  part.images.push_back({"Middlebury's cones",
                         "The left image; its true depth; depth by ours and by OpenCV: near red, "
                         "far blue, none grey.",
                         encode_png(all)});
  return part;
}

}  // namespace cousin
