// Detectors of other programs find each board in noise-free renders, and where the truth says.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <map>
#include <numbers>
#include <opencv2/aruco.hpp>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "scenes/boards/boards_scene.h"
#include "sim/render/path_tracer.h"

namespace cousin {
namespace {

constexpr int kWidth = 360, kHeight = 270;
constexpr double kFocal_px = 480;

/// A board alone under an even sky, which gives every point of a face the same light.
struct Shot {
  CalibrationTarget target;
  BoardFlaws flaws;
  TrueView view;
  cv::Mat linear;  ///< float
  std::map<int, Eigen::Vector2d> true_px;

  cv::Mat bytes() const {
    cv::Mat image;
    linear.convertTo(image, CV_8U, 255);
    return image;
  }
};

Shot shoot(const std::string& name, const Pose& camera_from_board, int samples,
           const BoardFlaws& flaws = {}) {
  BoardsSceneConfig config;
  Shot shot;
  shot.target = board_preset(name);
  shot.flaws = flaws;
  Scene scene;
  scene.models.push_back(board_model(shot.target, flaws, config.body));
  scene.materials = board_materials(config.body);
  for (Material& material : scene.materials) material.ior = 1;  // nothing is mirrored
  Instance board;
  board.part_materials = {0, 1, 2};
  scene.instances.push_back(board);
  scene.lights.emplace_back(Sky{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}});
  shot.view.camera = {.width_px = kWidth,
                      .height_px = kHeight,
                      .fx_px = kFocal_px,
                      .fy_px = kFocal_px,
                      .cx_px = 0.5 * (kWidth - 1) - 0.3,
                      .cy_px = 0.5 * (kHeight - 1) + 0.4};
  shot.view.camera_from_world = camera_from_board;
  shot.view.camera_from_world_end = camera_from_board;
  const RayScene rays(scene);
  const PathTracer tracer(rays, scene);
  const PathImage image =
      tracer.render(shot.view, {.pixel_samples = samples, .max_bounces = 0}, Rng(1));
  shot.linear = cv::Mat(kHeight, kWidth, CV_32F);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) shot.linear.at<float>(y, x) = image.radiance(x, y).g;
  }
  for (const TargetPoint& point : target_points(shot.target)) {
    shot.true_px[point.id] =
        project(shot.view.camera, camera_from_board * on_board_m(shot.target, flaws, point.at_m))
            .value();
  }
  return shot;
}

/// Facing the camera, then tilted and rolled.
Pose tilted(double distance_m, double tilt_rad) {
  const Eigen::Quaterniond facing(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()));
  const Eigen::AngleAxisd tilt(tilt_rad, Eigen::Vector3d(0.6, 0.8, 0));
  return {Eigen::AngleAxisd(0.13, Eigen::Vector3d::UnitZ()) * tilt * facing,
          {0.003, -0.002, distance_m}};
}

struct Offsets {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  double rms_px = 0;  ///< per coordinate
  int count = 0;
};

Offsets offsets(const Shot& shot, const std::map<int, cv::Point2f>& found) {
  Offsets result;
  for (const auto& [id, at] : found) {
    const Eigen::Vector2d error =
        Eigen::Vector2d(static_cast<double>(at.x), static_cast<double>(at.y)) - shot.true_px.at(id);
    result.mean += error;
    result.rms_px += error.squaredNorm();
    ++result.count;
  }
  result.mean /= result.count;
  result.rms_px = std::sqrt(result.rms_px / (2 * result.count));
  return result;
}

/// The point that all edges in a window pass through: least squares of gradient . (q - p) = 0,
/// the window's centre moving with the result.
Eigen::Vector2d saddle(const cv::Mat& image, Eigen::Vector2d q) {
  constexpr double kSigma = 2.2;
  const auto at = [&](int x, int y) { return static_cast<double>(image.at<float>(y, x)); };
  for (int step = 0; step < 50; ++step) {
    Eigen::Matrix2d a = Eigen::Matrix2d::Zero();
    Eigen::Vector2d b = Eigen::Vector2d::Zero();
    const int cx = static_cast<int>(std::lround(q.x())), cy = static_cast<int>(std::lround(q.y()));
    for (int y = cy - 7; y <= cy + 7; ++y) {
      for (int x = cx - 7; x <= cx + 7; ++x) {
        const Eigen::Vector2d p(x, y);
        const Eigen::Vector2d g(0.5 * (at(x + 1, y) - at(x - 1, y)),
                                0.5 * (at(x, y + 1) - at(x, y - 1)));
        const double weight = std::exp(-0.5 * (p - q).squaredNorm() / (kSigma * kSigma));
        a += weight * g * g.transpose();
        b += weight * g * (g.dot(p));
      }
    }
    const Eigen::Vector2d next = a.ldlt().solve(b);
    if ((next - q).norm() < 1e-7) return next;
    q = next;
  }
  return q;
}

/// Corners refined from near the truth, after a blur as a lens's: gradients of edges as sharp as a
/// pixel are aliased.
std::map<int, cv::Point2f> refined(const Shot& shot) {
  cv::Mat blurred;
  cv::GaussianBlur(shot.linear, blurred, {0, 0}, 1.4);
  std::map<int, cv::Point2f> found;
  for (const auto& [id, at] : shot.true_px) {
    const Eigen::Vector2d corner = saddle(blurred, at + Eigen::Vector2d(0.4, -0.3));
    found[id] = {static_cast<float>(corner.x()), static_cast<float>(corner.y())};
  }
  return found;
}

/// What an ideal camera sees of the flat chessboard: the share of white in each pixel, by a lattice
/// of rays met with the plane. Knows nothing of meshes.
cv::Mat ideal_chessboard(const Shot& shot) {
  constexpr int kSide = 12;
  const Pose board_from_camera = inverse(shot.view.camera_from_world);
  const Eigen::Matrix3d turn = board_from_camera.rotation.toRotationMatrix();
  const Eigen::Vector3d eye = board_from_camera.translation_m;
  const Camera& camera = shot.view.camera;
  const Eigen::Vector2d half = 0.5 * print_size_m(shot.target);
  cv::Mat image(kHeight, kWidth, CV_32F);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      int white = 0;
      for (int k = 0; k < kSide * kSide; ++k) {
        const double u = x - 0.5 + (k % kSide + 0.5) / kSide;
        const double v = y - 0.5 + (k / kSide + 0.5) / kSide;
        const Eigen::Vector3d d = turn * Eigen::Vector3d((u - camera.cx_px) / camera.fx_px,
                                                         (v - camera.cy_px) / camera.fy_px, 1);
        Eigen::Vector2d p = (eye - eye.z() / d.z() * d).head<2>();
        p.y() /= shot.flaws.stretch_y;
        p.x() = (p.x() - shot.flaws.shear * p.y()) / shot.flaws.stretch_x;
        const bool is_on = (p.cwiseAbs().array() < half.array()).all();
        const int column = static_cast<int>(std::floor((p.x() + half.x()) / shot.target.pitch_m));
        const int row = static_cast<int>(std::floor((half.y() - p.y()) / shot.target.pitch_m));
        white += !(is_on && (column + row) % 2 == 0);
      }
      image.at<float>(y, x) = static_cast<float>(white) / (kSide * kSide);
    }
  }
  return image;
}

TEST(BoardDetection, ChessboardCornersLieWhereTheTruthSays) {
  const BoardFlaws flaws{.stretch_x = 1.004, .stretch_y = 0.998, .shear = 0.002};
  Shot shot = shoot("chessboard_a4", tilted(0.45, 0.35), 144, flaws);
  const std::map<int, cv::Point2f> seen = refined(shot);
  EXPECT_LT(offsets(shot, seen).mean.norm(), 0.01);
  // The finder errs by 0.02 px on edges that are not blurred by a lens, and does so alike on both.
  Shot ideal = shot;
  ideal.linear = ideal_chessboard(shot);
  for (const auto& [id, at] : refined(ideal))
    shot.true_px[id] = {static_cast<double>(at.x), static_cast<double>(at.y)};
  const Offsets o = offsets(shot, seen);
  EXPECT_EQ(o.count, 54);
  // 144 samples of a pixel place each of the dozen edge pixels of a window to about 0.01 px.
  EXPECT_LT(o.mean.norm(), 0.003);
  EXPECT_LT(o.rms_px, 0.01);
}

TEST(BoardDetection, FindsTheChessboardInItsOrder) {
  const Shot shot = shoot("chessboard_a4", tilted(0.45, 0.5), 16);
  std::vector<cv::Point2f> corners;
  ASSERT_TRUE(cv::findChessboardCorners(shot.bytes(), {9, 6}, corners));
  std::map<int, cv::Point2f> found;
  for (std::size_t i = 0; i < corners.size(); ++i) found[static_cast<int>(i)] = corners[i];
  EXPECT_LT(offsets(shot, found).rms_px, 0.3);  // unrefined, on bytes
}

TEST(BoardDetection, FindsEveryCharucoCornerByItsNumber) {
  const Shot shot = shoot("charuco_a4", tilted(0.42, 0.4), 16);
  const auto dictionary = cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_50);
  const auto board = cv::aruco::CharucoBoard::create(11, 8, 0.022F, 0.01606F, dictionary);
  std::vector<std::vector<cv::Point2f>> markers;
  std::vector<int> ids;
  cv::aruco::detectMarkers(shot.bytes(), dictionary, markers, ids);
  EXPECT_GE(ids.size(), 40U);
  std::vector<cv::Point2f> corners;
  std::vector<int> corner_ids;
  cv::aruco::interpolateCornersCharuco(markers, ids, shot.bytes(), board, corners, corner_ids);
  std::map<int, cv::Point2f> found;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    // OpenCV 4.6 counts these from the corner of the upper left pixel.
    found[corner_ids[i]] = corners[i] - cv::Point2f(0.5F, 0.5F);
  }
  EXPECT_GE(found.size(), 65U);
  EXPECT_LT(offsets(shot, found).rms_px, 0.1);
}

TEST(BoardDetection, FindsTagsOfTheAprilGridByKalibrsNumbers) {
  const Shot shot = shoot("aprilgrid_a4", tilted(0.32, 0.3), 16);
  const auto dictionary = cv::aruco::getPredefinedDictionary(cv::aruco::DICT_APRILTAG_36h11);
  const auto parameters = cv::aruco::DetectorParameters::create();
  parameters->markerBorderBits = 2;
  std::vector<std::vector<cv::Point2f>> tags;
  std::vector<int> ids;
  cv::aruco::detectMarkers(shot.bytes(), dictionary, tags, ids, parameters);
  EXPECT_GE(ids.size(), 30U);
  std::map<int, cv::Point2f> found;
  for (std::size_t k = 0; k < ids.size(); ++k) {
    ASSERT_LT(ids[k], 36);
    // OpenCV's upper left corner is, upright as Kalibr prints it, the lower right.
    const int first = ids[k] / 6 * 2 * 12 + ids[k] % 6 * 2;
    const int ours[4] = {first + 1, first, first + 12, first + 13};
    for (int c = 0; c < 4; ++c) found[ours[c]] = tags[k][static_cast<std::size_t>(c)];
  }
  EXPECT_LT(offsets(shot, found).rms_px, 2);  // unrefined corners; a wrong turn is 30 px
}

TEST(BoardDetection, FindsBothKindsOfCirclesInTheirOrder) {
  for (const auto& [name, size, flag] :
       {std::tuple{"circles_a4", cv::Size(8, 6), cv::CALIB_CB_SYMMETRIC_GRID},
        {"acircles_a4", cv::Size(4, 11), cv::CALIB_CB_ASYMMETRIC_GRID}}) {
    const Shot shot = shoot(name, tilted(0.5, 0.3), 16);
    std::vector<cv::Point2f> centres;
    ASSERT_TRUE(cv::findCirclesGrid(shot.bytes(), size, centres, flag)) << name;
    std::map<int, cv::Point2f> found;
    for (std::size_t i = 0; i < centres.size(); ++i) found[static_cast<int>(i)] = centres[i];
    EXPECT_LT(offsets(shot, found).rms_px, 0.3) << name;  // an ellipse's middle is not the disc's
  }
}

/// Centroid of what a disc covers in the picture, by its projected outline.
Eigen::Vector2d outline_centroid(const Shot& shot, const Eigen::Vector2d& middle_m) {
  constexpr int kSides = 720;
  const double radius_m = shot.target.mark_share * shot.target.pitch_m;
  std::vector<Eigen::Vector2d> ring;
  for (int k = 0; k < kSides; ++k) {
    const double a = 2 * std::numbers::pi * k / kSides;
    const Eigen::Vector2d at = middle_m + radius_m * Eigen::Vector2d(std::cos(a), std::sin(a));
    ring.push_back(project(shot.view.camera,
                           shot.view.camera_from_world * on_board_m(shot.target, shot.flaws, at))
                       .value());
  }
  double area = 0;
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();
  for (int k = 0; k < kSides; ++k) {
    const auto &a = ring[static_cast<std::size_t>(k)],
               &b = ring[static_cast<std::size_t>((k + 1) % kSides)];
    const double twice = a.x() * b.y() - a.y() * b.x();
    area += twice;
    moment += twice * (a + b) / 3;
  }
  return moment / area;
}

TEST(BoardDetection, DiscsCoverWhatAProjectedCircleCovers) {
  const Shot shot = shoot("circles_a4", tilted(0.5, 0.5), 144);
  double worst = 0;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  const std::vector<TargetPoint> points = target_points(shot.target);
  for (const TargetPoint& point : points) {
    const Eigen::Vector2d expected = outline_centroid(shot, point.at_m);
    const int cx = static_cast<int>(std::lround(expected.x()));
    const int cy = static_cast<int>(std::lround(expected.y()));
    const double white = static_cast<double>(shot.linear.at<float>(cy, cx - 13));
    double sum = 0;
    Eigen::Vector2d moment = Eigen::Vector2d::Zero();
    for (int y = cy - 12; y <= cy + 12; ++y) {
      for (int x = cx - 12; x <= cx + 12; ++x) {
        const double dark = white - static_cast<double>(shot.linear.at<float>(y, x));
        sum += dark;
        moment += dark * Eigen::Vector2d(x, y);
      }
    }
    const Eigen::Vector2d error = moment / sum - expected;
    worst = std::max(worst, error.norm());
    mean += error / static_cast<double>(points.size());
  }
  // Edges of a disc of 50 pixels around, each placed to a part in 144.
  EXPECT_LT(mean.norm(), 0.003);
  EXPECT_LT(worst, 0.02);
}

}  // namespace
}  // namespace cousin
