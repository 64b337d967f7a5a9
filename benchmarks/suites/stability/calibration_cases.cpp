#include "benchmarks/suites/stability/calibration_cases.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "benchmarks/suites/calibration/corner_views.h"
#include "calibration/solve/calibration_uncertainty.h"

namespace cousin {
namespace {

using Rows = std::vector<StabilityRow>;
constexpr double kDegree = std::numbers::pi / 180;

CornerViewsConfig close_views() {
  CornerViewsConfig config;
  config.near_m = 0.2;
  config.far_m = 0.45;
  return config;
}

CornerViews views_of(const CornerViewsConfig& config, LensModel model = LensModel::opencv5) {
  return make_corner_views({study_camera(model)}, {Pose{}}, config, Rng(5));
}

bool names(const CalibrationResult& result, const char* parameter) {
  return std::find(result.not_determined.begin(), result.not_determined.end(), parameter) !=
         result.not_determined.end();
}

double says_open(const CalibrationResult& result) {
  return result.status == CalibrationStatus::not_determined && !result.not_determined.empty();
}

/// Largest error of the core over its deviation; 0 where the result says that it is open.
double core_error(const CornerViews& views, const CalibrationResult& result) {
  if (says_open(result) == 1) return 0;
  if (result.status != CalibrationStatus::ok) return std::numeric_limits<double>::infinity();
  const Camera& truth = views.cameras[0];
  const double core[] = {truth.fx_px, truth.fy_px, truth.cx_px, truth.cy_px};
  double largest = 0;
  for (int i = 0; i < 4; ++i) {
    const double sigma = deviation(result, result.parameters[static_cast<std::size_t>(i)]);
    largest = worse(largest, std::abs(result.values(i) - core[i]) / sigma);
  }
  return largest;
}

Rows undetermined() {
  Rows rows;
  CornerViewsConfig config;
  config.tilt_rad = 3 * kDegree;
  const CalibrationResult parallel = calibrate(views_of(config).input);
  rows.push_back(make_row("30 boards tilted by at most 3 degrees", "focal length said to be open",
                          "", 1, says_open(parallel) * names(parallel, "camera0.fx_px"), false));
  rows.push_back(make_row("30 boards tilted by at most 3 degrees", "RMS, which says nothing of it",
                          "px", 0.11, parallel.rms_px));
  config = close_views();
  config.frames = 1;
  rows.push_back(make_row("1 image", "said to be open", "", 1,
                          says_open(calibrate(views_of(config).input)), false));
  for (const int frames : {2, 3, 5}) {
    config.frames = frames;
    const CornerViews views = views_of(config);
    // Four numbers: the largest of so many normals is below 4 in 99.97 of 100 cases.
    rows.push_back(make_row(std::to_string(frames) + " images",
                            "core off over its deviation, 0 = said to be open", "", 4,
                            core_error(views, calibrate(views.input))));
  }
  Camera narrow = study_camera(LensModel::opencv5);
  narrow.fx_px = narrow.fy_px = 320 / std::tan(2.5 * kDegree);
  narrow.distortion = {};
  config = close_views();
  config.near_m = 5;
  config.far_m = 9;
  const CornerViews far = make_corner_views({narrow}, {Pose{}}, config, Rng(6));
  const CalibrationResult of_narrow = calibrate(far.input);
  rows.push_back(make_row("lens of 5 degrees", "principal point said to be open", "", 1,
                          says_open(of_narrow) * (names(of_narrow, "camera0.cx_px") ||
                                                  names(of_narrow, "camera0.cy_px")),
                          false));
  config = close_views();
  config.region = {0, 0, 0.25, 0.25};
  config.columns = 5;
  config.rows = 4;
  config.pitch_m = 0.02;
  config.near_m = 0.35;
  const CornerViews corner = views_of(config);
  const CalibrationResult in_corner = calibrate(corner.input);
  double ratio = 0;
  if (says_open(in_corner) == 0) {
    ratio = projection_difference(in_corner.cameras.at(0), corner.cameras[0]).rms_px /
            rms_deviation_px(projection_uncertainty(in_corner, 0));
  }
  rows.push_back(make_row("boards in one corner", "true error over predicted, 0 = said to be open",
                          "", 3, ratio));
  return rows;
}

double largest_difference(const CalibrationResult& a, const CalibrationResult& b) {
  if (a.status != CalibrationStatus::ok || b.status != CalibrationStatus::ok) return 1;
  double largest = 0;
  for (Eigen::Index i = 0; i < a.values.size(); ++i)
    largest =
        worse(largest, std::abs(a.values(i) - b.values(i)) / std::max(1.0, std::abs(a.values(i))));
  return largest;
}

Rows units_and_origins() {
  const CornerViews views = views_of(close_views());
  const CalibrationResult metres = calibrate(views.input);
  CalibrationInput millimetres = views.input, far = views.input;
  for (Eigen::Vector3d& p : millimetres.target_m) p *= 1000;
  for (Eigen::Vector3d& p : far.target_m) p = 1000 * p + Eigen::Vector3d(1e6, -1e6, 1e6);
  return {make_row("board in millimetres", "lens, largest relative change", "", 1e-9,
                   largest_difference(metres, calibrate(millimetres))),
          make_row("board 1e6 mm from its origin", "lens, largest relative change", "", 1e-9,
                   largest_difference(metres, calibrate(far)))};
}

Rows outliers() {
  CornerViewsConfig config = close_views();
  config.outlier_share = 0.3;
  config.outlier_px = 20;
  const CornerViews views = views_of(config);
  CalibrationConfig solve;
  solve.reject_sigmas = 5;
  const CalibrationResult result = calibrate(views.input, solve);
  double wrong = 0, rejected = 0, both = 0;
  for (const CalibrationResidual& r : result.residuals) {
    const auto v = static_cast<std::size_t>(r.view);
    std::size_t k = 0;
    while (views.input.views[v].points[k].id != r.id) ++k;
    wrong += views.outliers[v][k];
    rejected += r.rejected;
    both += views.outliers[v][k] && r.rejected;
  }
  return {make_row("30 % of corners off by up to 20 px", "outliers found", "", 0.97, both / wrong,
                   false),
          make_row("30 % of corners off by up to 20 px", "rejected rightly", "", 0.97,
                   both / rejected, false),
          make_row("30 % of corners off by up to 20 px", "core off over its deviation", "", 4,
                   result.status == CalibrationStatus::ok ? core_error(views, result) : 99)};
}

/// Many lenses of eight coefficients from few views of the middle: some of them fold in the image.
Rows folding() {
  int folded = 0, called_ok = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    CornerViewsConfig config = close_views();
    config.frames = 6;
    config.region = {0.4, 0.4, 0.6, 0.6};
    config.near_m = 0.4;
    config.far_m = 0.5;
    CornerViews views =
        make_corner_views({study_camera(LensModel::opencv5)}, {Pose{}}, config, Rng(seed));
    views.input.cameras[0].start.model = LensModel::opencv8;
    const CalibrationResult result = calibrate(views.input);
    if (result.cameras.empty()) continue;
    try {
      validate(result.cameras[0]);
    } catch (const std::invalid_argument&) {
      ++folded;
      called_ok += result.status == CalibrationStatus::ok;
    }
  }
  return {make_row("lenses from the image's middle", "of 10 fold inside the image", "",
                   std::numeric_limits<double>::quiet_NaN(), folded),
          make_row("lenses from the image's middle", "fold and are called good", "", 0, called_ok)};
}

Rows wrong_sizes() {
  CalibrationInput input = views_of(close_views()).input;
  input.views[4].points[0].pixel_px = {900, 200};
  const CalibrationResult result = calibrate(input);
  const bool told = result.status == CalibrationStatus::bad_input &&
                    result.reason.find("view 4") != std::string::npos;
  return {make_row("view of a larger image", "refused by its number", "", 1, told, false)};
}

}  // namespace

std::vector<StabilityRow> calibration_cases() {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  if (calibrate(views_of(close_views()).input).status == CalibrationStatus::not_built)
    return {make_row("calibrations", "not built in: Ceres (WITH_CERES=OFF)", "", nan, nan)};
  Rows rows = undetermined();
  for (const Rows& more : {units_and_origins(), outliers(), folding(), wrong_sizes()})
    rows.insert(rows.end(), more.begin(), more.end());
  return rows;
}

}  // namespace cousin
