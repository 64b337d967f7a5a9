#include "benchmarks/suites/calibration/study_run.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <utility>

#include "benchmarks/suites/calibration/board_photographs.h"
#include "benchmarks/suites/calibration/calibration_errors.h"
#include "benchmarks/suites/calibration/opencv_corners.h"
#include "benchmarks/suites/calibration/reprojection.h"
#include "calibration/solve/calibration_uncertainty.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

constexpr std::array<StudyMetric, 11> kMetrics = {
    {{"projection.rms", "px", "projection error, RMS over the image (px)", 1},
     {"projection.worst", "px", "", 1},
     {"projection.predicted", "px", "", 1},
     {"fruit.position", "m", "sideways error of a fruit at 0.5 m (mm)", 1e3},
     {"seed.length", "m", "error of a seed's length of 10 mm (µm)", 1e6},
     {"reprojection.rms_coordinate", "px", "", 1},
     {"reprojection.rms_point", "px", "", 1},
     {"reprojection.tutorial", "px", "", 1},
     {"focal.error", "1", "", 1},
     {"centre.error", "px", "", 1},
     {"p1.error", "1", "", 1}}};

/// The corners of one sensor's photographs.
struct FoundCorners {
  std::vector<TargetView> ours, opencv;  ///< by photograph; the latter empty unless asked for
  double ours_s = 0, opencv_s = 0;       ///< of all, wall
};

/// What a group's photographs come to.
struct Photographed {
  std::vector<FoundCorners> sensors;
  std::vector<Camera> true_lenses;  ///< of the photographs
  Camera nominal;
  Camera reported;  ///< by the device, of the first photograph
  CalibrationTarget target;
};

bool asks_for_opencv(const StudyGroup& group) {
  return std::any_of(group.points.begin(), group.points.end(), [](const StudyPoint& point) {
    return std::any_of(point.methods.begin(), point.methods.end(), [](const StudyMethod& method) {
      return method.finder == CornerFinder::opencv;
    });
  });
}

template <class Find>
double find_all(const std::vector<Image<Rgb8>>& pictures, std::vector<TargetView>& views,
                const Find& find) {
  views.resize(pictures.size());
  const StageClock clock("find");
  tbb::parallel_for(std::size_t{0}, pictures.size(), [&](std::size_t i) {
    views[i] = find(pictures[i]);
    views[i].frame = static_cast<int>(i);
  });
  return clock.finish().wall_s;
}

Photographed photograph(const StudyGroup& group, std::uint64_t seed) {
  std::vector<std::string> sets = group.sets;
  sets.push_back("views=" + std::to_string(group.views));
  const BoardPhotographs board(sets, seed, {.sensors = group.sensors});
  Photographed result;
  result.target = board.target();
  const auto n = static_cast<std::size_t>(group.views);
  std::vector<std::vector<Image<Rgb8>>> pictures(group.sensors.size());
  for (std::size_t s = 0; s < pictures.size(); ++s)
    pictures[s].resize(static_cast<std::size_t>(group.sensor_views[s]));
  tbb::parallel_for(std::size_t{0}, n, [&](std::size_t i) {
    const auto sensors = static_cast<std::size_t>(
        std::count_if(group.sensor_views.begin(), group.sensor_views.end(),
                      [&](int views) { return static_cast<std::size_t>(views) > i; }));
    std::vector<Frame> frames = board.take_each(static_cast<int>(i), sensors);
    for (std::size_t s = 0; s < sensors; ++s)
      pictures[s][i] = std::move(frames[s].sensors.at(0).color);
    if (i == 0) result.reported = frames.front().sensors.at(0).reported;
  });
  for (std::size_t i = 0; i < n; ++i)
    result.true_lenses.push_back(board.truth().front().views.at(i).camera);
  result.nominal = result.true_lenses.front();
  for (const std::vector<Image<Rgb8>>& of_sensor : pictures) {
    FoundCorners& found = result.sensors.emplace_back();
    found.ours_s = find_all(of_sensor, found.ours, [&](const Image<Rgb8>& picture) {
      return find_target(light_of(picture), result.target);
    });
    if (!asks_for_opencv(group)) continue;
    found.opencv_s = find_all(of_sensor, found.opencv, [&](const Image<Rgb8>& picture) {
      return find_corners_by_opencv(picture, result.target);
    });
  }
  return result;
}

/// The camera's size and the model; nothing that only the truth knows.
Camera unknown_lens(const Camera& like, LensModel model) {
  Camera camera;
  camera.model = model;
  camera.width_px = like.width_px;
  camera.height_px = like.height_px;
  if (model == LensModel::splined_stereographic) {
    camera.spline.order = 3;
    camera.spline.columns = 11;
    camera.spline.rows = 8;
    camera.spline.fov_x_rad = 1.7;
  }
  return camera;
}

/// Mean square of the errors over some of the views' lenses: one where they are the same, as many
/// as five where the camera focuses anew each time.
CalibrationErrors errors_over(const std::vector<Camera>& lenses,
                              const std::function<Camera(const Camera&)>& at_work,
                              const Camera& estimate) {
  std::vector<Camera> some;
  for (std::size_t i = 0; i < lenses.size(); i += std::max<std::size_t>(1, lenses.size() / 5)) {
    if (some.empty() || !(some.back() == lenses[i])) some.push_back(lenses[i]);
  }
  CalibrationErrors sum;
  for (const Camera& lens : some) {
    const CalibrationErrors e = calibration_errors(at_work ? at_work(lens) : lens, estimate);
    sum.projection_px += e.projection_px * e.projection_px;
    sum.projection_worst_px = std::max(sum.projection_worst_px, e.projection_worst_px);
    sum.fruit_m += e.fruit_m * e.fruit_m;
    sum.seed_m += e.seed_m * e.seed_m;
  }
  const auto n = static_cast<double>(some.size());
  sum.projection_px = std::sqrt(sum.projection_px / n);
  sum.fruit_m = std::sqrt(sum.fruit_m / n);
  sum.seed_m = std::sqrt(sum.seed_m / n);
  return sum;
}

/// The device's own lens, as a result of no time and no corners.
CalibrationResult factory_result(const Camera& reported) {
  CalibrationResult result;
  result.status = CalibrationStatus::ok;
  result.cameras = {reported};
  return result;
}

/// RMS over the image of the deviation that the calibration predicts of its own projection.
double predicted_px(const CalibrationResult& found) {
  if (found.covariance.size() == 0) return ScoreRow::kNone;
  return rms_deviation_px(projection_uncertainty(found, 0));
}

/// The first photographs' corners as a method takes them.
struct MethodCorners {
  std::vector<TargetView> views;
  std::vector<Camera> true_lenses;
  double seconds = 0;  ///< of finding them
};
MethodCorners corners_of(const StudyPoint& point, const StudyMethod& method,
                         const FoundCorners& found, const Photographed& seen, const Rng& rng) {
  const bool by_opencv = method.finder == CornerFinder::opencv;
  const std::vector<TargetView>& all = by_opencv ? found.opencv : found.ours;
  const int n = method.views > 0 ? std::min(method.views, point.views) : point.views;
  MethodCorners corners;
  corners.views.assign(all.begin(), all.begin() + n);
  corners.true_lenses.assign(seen.true_lenses.begin(), seen.true_lenses.begin() + n);
  corners.seconds =
      (by_opencv ? found.opencv_s : found.ours_s) * n / static_cast<double>(all.size());
  spoil(corners.views, point.outlier_share, rng.fork("outliers"));
  return corners;
}

std::vector<ScoreRow> run_method(const StudyPoint& point, const StudyMethod& method,
                                 const MethodCorners& corners, const Photographed& seen, int run,
                                 std::uint64_t seed) {
  const StageClock clock("solve");
  const CalibrationResult found =
      method.is_factory ? factory_result(seen.reported)
                        : calibrate(calibration_input(seen.target, corners.views,
                                                      {unknown_lens(seen.nominal, method.model)}),
                                    method.solve);
  ScoreRow base;
  base.suite = "calibration";
  base.scene = point.axis;
  base.case_name = point.name() + " run " + std::to_string(run);
  base.method = method.name;
  base.seed = seed;
  base.n = found.observations;
  if (!method.is_factory) base.wall_s = corners.seconds + clock.finish().wall_s;
  const bool is_solved = found.status == CalibrationStatus::ok;
  base.status = is_solved                                      ? ScoreStatus::ok
                : found.status == CalibrationStatus::not_built ? ScoreStatus::not_built
                                                               : ScoreStatus::not_solved;
  const bool has_numbers = is_solved || found.status == CalibrationStatus::not_determined;
  std::array<double, kMetrics.size()> values;
  values.fill(ScoreRow::kNone);
  if (has_numbers && !found.cameras.empty()) {
    const Camera& lens = found.cameras.front();
    const std::function<Camera(const Camera&)> at_work = method.is_fresh ? nullptr : point.at_work;
    const CalibrationErrors errors = errors_over(corners.true_lenses, at_work, lens);
    const Camera truth = at_work ? at_work(seen.nominal) : seen.nominal;
    const ReprojectionErrors reprojection = reprojection_errors(found);
    const bool has_p1 = truth.model == LensModel::opencv5 &&
                        (lens.model == LensModel::opencv5 || lens.model == LensModel::opencv8);
    values = {errors.projection_px,
              errors.projection_worst_px,
              predicted_px(found),
              errors.fruit_m,
              errors.seed_m,
              reprojection.rms_coordinate_px,
              reprojection.rms_point_px,
              reprojection.tutorial_px,
              lens.fx_px / truth.fx_px - 1,
              std::hypot(lens.cx_px - truth.cx_px, lens.cy_px - truth.cy_px),
              has_p1 ? lens.distortion[2] - truth.distortion[2] : ScoreRow::kNone};
  }
  std::vector<ScoreRow> rows;
  for (std::size_t m = 0; m < kMetrics.size(); ++m) {
    ScoreRow row = base;
    row.metric = kMetrics[m].name;
    row.unit = kMetrics[m].unit;
    row.value = values[m];
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace

std::span<const StudyMetric> study_metrics() { return kMetrics; }

std::vector<ScoreRow> run_group(const StudyGroup& group, int run, std::uint64_t seed) {
  const std::uint64_t of_run =
      Rng(seed).fork("calibration study").fork(static_cast<std::uint64_t>(run))();
  const Photographed seen = photograph(group, of_run);
  std::vector<ScoreRow> all;
  for (std::size_t p = 0; p < group.points.size(); ++p) {
    const StudyPoint& point = group.points[p];
    const FoundCorners& found = seen.sensors[group.sensor_of_point[p]];
    for (const StudyMethod& method : point.methods) {
      const std::vector<ScoreRow> rows = run_method(
          point, method, corners_of(point, method, found, seen, Rng(of_run)), seen, run, seed);
      all.insert(all.end(), rows.begin(), rows.end());
    }
  }
  return all;
}

}  // namespace cousin
