#include "benchmarks/suites/calibration/detection_rows.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <opencv2/aruco.hpp>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "calibration/boards/target_detection.h"
#include "scenes/boards/boards_scene.h"
#include "sim/render/path_tracer.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

constexpr int kWidth = 400, kHeight = 300;
constexpr int kHalfWindow_px = 5;
constexpr double kBlur_px = 1, kNoise = 0.01;

/// A board alone under an even sky, without noise.
struct RenderedBoard {
  CalibrationTarget target;
  Image<float> light;  ///< blurred
  std::map<int, Eigen::Vector2d> true_px;
  double range = 0;  ///< white less black
};

Pose pose_of(double distance_m, int k) {
  const Eigen::Quaterniond facing(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()));
  const double axis = 0.9 + 1.3 * k;
  const Eigen::AngleAxisd tilt(0.15 + 0.2 * (k % 3),
                               Eigen::Vector3d(std::cos(axis), std::sin(axis), 0));
  return {Eigen::AngleAxisd(0.17 - 0.21 * k, Eigen::Vector3d::UnitZ()) * tilt * facing,
          {0.002 * k, -0.001 * k, distance_m}};
}

RenderedBoard render_board_alone(const std::string& name, const Pose& camera_from_board,
                                 int samples) {
  const BoardsSceneConfig config;
  RenderedBoard board;
  board.target = board_preset(name);
  Scene scene;
  scene.models.push_back(board_model(board.target, {}, config.body));
  scene.materials = board_materials(config.body);
  for (Material& material : scene.materials) material.ior = 1;  // nothing is mirrored
  Instance instance;
  instance.part_materials = {0, 1, 2};
  scene.instances.push_back(instance);
  scene.lights.emplace_back(Sky{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}});
  TrueView view;
  view.camera = {.width_px = kWidth,
                 .height_px = kHeight,
                 .fx_px = 560,
                 .fy_px = 560,
                 .cx_px = 0.5 * (kWidth - 1) - 0.3,
                 .cy_px = 0.5 * (kHeight - 1) + 0.4};
  view.camera_from_world = view.camera_from_world_end = camera_from_board;
  const RayScene rays(scene);
  const PathTracer tracer(rays, scene);
  const PathImage image = tracer.render(view, {.pixel_samples = samples, .max_bounces = 0}, Rng(1));
  cv::Mat green(kHeight, kWidth, CV_32F);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) green.at<float>(y, x) = image.radiance(x, y).g;
  }
  cv::GaussianBlur(green, green, {0, 0}, kBlur_px);
  board.light = Image<float>(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) board.light(x, y) = green.at<float>(y, x);
  }
  board.range = config.body.paper_albedo[1] - config.body.ink_albedo[1];
  for (const TargetPoint& p : target_points(board.target)) {
    const auto at = project(view.camera, camera_from_board * on_board_m(board.target, {}, p.at_m));
    if (at) board.true_px[p.id] = *at;
  }
  return board;
}

Image<float> with_noise(const RenderedBoard& board, Rng rng) {
  Image<float> noisy = board.light;
  for (float& v : noisy) v += static_cast<float>(kNoise * board.range * normal(rng));
  return noisy;
}

/// Fisher's information of a shift of the window's content, all else known.
Eigen::Matrix2d window_information(const RenderedBoard& board, const Eigen::Vector2d& at) {
  const int cx = static_cast<int>(std::lround(at.x())), cy = static_cast<int>(std::lround(at.y()));
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  for (int y = cy - kHalfWindow_px; y <= cy + kHalfWindow_px; ++y) {
    for (int x = cx - kHalfWindow_px; x <= cx + kHalfWindow_px; ++x) {
      if (!board.light.contains(x - 1, y - 1) || !board.light.contains(x + 1, y + 1)) continue;
      const auto at_pixel = [&](int i, int j) { return static_cast<double>(board.light(i, j)); };
      const Eigen::Vector2d g(0.5 * (at_pixel(x + 1, y) - at_pixel(x - 1, y)),
                              0.5 * (at_pixel(x, y + 1) - at_pixel(x, y - 1)));
      sum += g * g.transpose();
    }
  }
  return sum / (kNoise * kNoise * board.range * board.range);
}

struct Tally {
  Eigen::Vector2d sum_px = Eigen::Vector2d::Zero();
  double over_bound = 0;  ///< squares of whitened coordinates
  int inside_95 = 0, points = 0;
  int expected = 0, found = 0;  ///< of those whose window is in the picture
};

bool is_window_seen(const RenderedBoard& board, const Eigen::Vector2d& at_px) {
  return (at_px.array() >= kHalfWindow_px).all() &&
         at_px.x() <= board.light.width() - 1 - kHalfWindow_px &&
         at_px.y() <= board.light.height() - 1 - kHalfWindow_px;
}

void add(Tally& tally, const RenderedBoard& board, const TargetView& view) {
  constexpr double kChi95 = 5.991;  // of two degrees
  for (const auto& [id, at_px] : board.true_px) tally.expected += is_window_seen(board, at_px);
  for (const TargetObservation& o : view.points) {
    const Eigen::Vector2d off = o.pixel_px - board.true_px.at(o.id);
    tally.sum_px += off;
    tally.over_bound += off.dot(window_information(board, board.true_px.at(o.id)) * off);
    tally.inside_95 += off.dot(o.covariance_px2.inverse() * off) < kChi95;
    tally.found += is_window_seen(board, board.true_px.at(o.id));
    ++tally.points;
  }
}

ScoreRow row_of(const std::string& board, const char* method, std::uint64_t seed) {
  ScoreRow row;
  row.suite = "calibration";
  row.scene = "detection on rendered boards";
  row.case_name = board;
  row.method = method;
  row.seed = seed;
  return row;
}

ScoreRow held(ScoreRow row, const char* metric, const char* unit, double value, double limit,
              bool is_upper) {
  char text[40];
  std::snprintf(text, sizeof text, is_upper ? " (at most %g)" : " (at least %g)", limit);
  row.metric = std::string(metric) + text;
  row.unit = unit;
  row.value = value;
  return limited(row, is_upper ? at_most(limit) : at_least(limit));
}

void kind_rows(std::vector<ScoreRow>& rows, const std::string& name, double distance_m,
               std::uint64_t seed, bool quick) {
  const int poses = quick ? 1 : 3, draws = quick ? 6 : 20, samples = quick ? 144 : 400;
  Tally tally;
  double seconds = 0;
  for (int k = 0; k < poses; ++k) {
    const RenderedBoard board = render_board_alone(name, pose_of(distance_m, k), samples);
    for (int draw = 0; draw < draws; ++draw) {
      const Image<float> image = with_noise(board, Rng(seed)
                                                       .fork("detection")
                                                       .fork(static_cast<std::uint64_t>(k))
                                                       .fork(static_cast<std::uint64_t>(draw)));
      const StageClock clock("find");
      const TargetView view = find_target(image, board.target);
      seconds += clock.finish().wall_s;
      add(tally, board, view);
    }
  }
  ScoreRow row = row_of(name, "ours", seed);
  row.n = tally.points;
  row.wall_s = seconds / (poses * draws);
  rows.push_back(held(row, "share of points found", "1",
                      tally.found / static_cast<double>(tally.expected), 0.9, false));
  if (tally.points == 0) return;
  rows.push_back(held(row, "bias", "px", (tally.sum_px / tally.points).norm(), 0.01, true));
  const bool has_discs = name.find("circles") != name.npos;
  if (!has_discs) {
    rows.push_back(held(row, "deviation over the bound of 11 x 11 pixels", "1",
                        std::sqrt(tally.over_bound / (2 * tally.points)), 1.5, true));
  }
  row.metric = "within the predicted 95 % ellipse";
  row.unit = "1";
  row.value = tally.inside_95 / static_cast<double>(tally.points);
  rows.push_back(row);
}

/// The exhibit: where OpenCV's ChArUco corners lie.
void charuco_rows(std::vector<ScoreRow>& rows, std::uint64_t seed, bool quick) {
  const RenderedBoard board = render_board_alone("charuco_a4", pose_of(0.4, 1), quick ? 144 : 400);
  cv::Mat image(kHeight, kWidth, CV_8U);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      image.at<unsigned char>(y, x) = cv::saturate_cast<unsigned char>(255 * board.light(x, y));
    }
  }
  const CalibrationTarget& t = board.target;
  const auto dictionary = cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_50);
  const auto design =
      cv::aruco::CharucoBoard::create(t.columns, t.rows, static_cast<float>(t.pitch_m),
                                      static_cast<float>(t.mark_share * t.pitch_m), dictionary);
  std::vector<std::vector<cv::Point2f>> markers;
  std::vector<int> ids, corner_ids;
  std::vector<cv::Point2f> corners;
  cv::aruco::detectMarkers(image, dictionary, markers, ids);
  if (!ids.empty())
    cv::aruco::interpolateCornersCharuco(markers, ids, image, design, corners, corner_ids);
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    mean += (Eigen::Vector2d(static_cast<double>(corners[i].x), static_cast<double>(corners[i].y)) -
             board.true_px.at(corner_ids[i])) /
            static_cast<double>(corners.size());
  }
  ScoreRow row = row_of("charuco_a4, no noise", "OpenCV 4.6 interpolateCornersCharuco", seed);
  row.n = static_cast<std::int64_t>(corners.size());
  row.unit = "px";
  if (corners.empty()) {
    row.metric = "no corner was found";
    row.status = ScoreStatus::not_solved;
    rows.push_back(row);
    return;
  }
  row.metric = "mean offset in x";
  row.value = mean.x();
  rows.push_back(row);
  row.metric = "mean offset in y";
  row.value = mean.y();
  rows.push_back(row);
}

}  // namespace

std::vector<ScoreRow> detection_rows(std::uint64_t seed, bool quick) {
  std::vector<ScoreRow> rows;
  struct Board {
    const char* name;
    double distance_m;
  };
  for (const Board& board :
       {Board{"chessboard_a4", 0.46}, Board{"charuco_a4", 0.42}, Board{"aprilgrid_a4", 0.32},
        Board{"circles_a4", 0.48}, Board{"acircles_a4", 0.5}})
    kind_rows(rows, board.name, board.distance_m, seed, quick);
  charuco_rows(rows, seed, quick);
  return rows;
}

}  // namespace cousin
