#include <algorithm>
#include <array>
#include <cmath>

#include "scenes/boards/boards_scene.h"
#include "sim/types/pi.h"

namespace cousin {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kGoldenAngle = kPi * (3 - 2.23606797749979);

/// Radical inverse: places i = 0, 1, 2, ... evenly in [0, 1) [van der Corput 1935].
double radical_inverse(int i, int base) {
  double result = 0, share = 1.0 / base;
  for (; i > 0; i /= base, share /= base) result += share * (i % base);
  return result;
}

double wrapped(double v) { return v - std::floor(v); }

/// What is drawn of one view, each in [0, 1).
struct Draw {
  double across = 0, down = 0, tilt = 0, direction = 0, size = 0, roll = 0;
};

/// Share of the print beyond the border of the picture, by a lattice of its points. A point behind
/// the camera counts.
double share_outside(const BoardsSceneConfig& config, const Pose& camera_from_board) {
  constexpr int kPoints = 13;
  const Vector2d size = print_size_m(config.target);
  int out = 0;
  for (int j = 0; j < kPoints; ++j) {
    for (int i = 0; i < kPoints; ++i) {
      const Vector2d at =
          size.cwiseProduct(Vector2d(i / (kPoints - 1.0) - 0.5, j / (kPoints - 1.0) - 0.5));
      const Vector3d p = camera_from_board * Vector3d(at.x(), at.y(), 0);
      // 2 % of half the picture is left for lens and hand.
      const Vector2d u = p.head<2>().cwiseQuotient(0.98 * config.half_view) / p.z();
      if (p.z() <= 0 || u.cwiseAbs().maxCoeff() > 1) ++out;
    }
  }
  return out / static_cast<double>(kPoints * kPoints);
}

Eigen::Quaterniond turned(const Draw& draw, double tilt_rad, double roll_rad) {
  // Facing the camera: x right, y up, z towards it.
  const Eigen::Quaterniond facing(Eigen::AngleAxisd(kPi, Vector3d::UnitX()));
  const double direction = 2 * kPi * draw.direction;
  const Vector3d axis(std::cos(direction), std::sin(direction), 0);
  return Eigen::AngleAxisd(roll_rad, Vector3d::UnitZ()) * Eigen::AngleAxisd(tilt_rad, axis) *
         facing;
}

/// Cosine of the angle between the print's normal and the way to the camera.
double facing_cosine(const Pose& camera_from_board) {
  const Vector3d eye_in_board = centre_in_world_m(camera_from_board);
  return eye_in_board.z() / eye_in_board.norm();
}

Pose pose_of(const BoardsSceneConfig& config, const Draw& draw, double tilt_rad) {
  const auto& c = config.setting.poses;
  const Vector2d half = 0.5 * print_size_m(config.target);
  const double fill = c.fill_min + (c.fill_max - c.fill_min) * draw.size;
  double depth_m = half.cwiseQuotient(config.half_view).maxCoeff() / fill;
  const Vector2d spans = half.cwiseQuotient(config.half_view) / depth_m;
  const Vector2d reach = Vector2d::Ones() - (1 - config.outside) * spans;
  Vector2d offset =
      config.coverage * Vector2d(2 * draw.across - 1, 2 * draw.down - 1).cwiseProduct(reach);
  Pose pose;
  pose.rotation = turned(draw, tilt_rad, c.roll_max_rad * (2 * draw.roll - 1));
  // Towards the middle until enough of it is in the picture, then away.
  for (int attempt = 0; attempt < 200; ++attempt) {
    const Vector2d at = offset.cwiseProduct(config.half_view);
    pose.translation_m = depth_m * Vector3d(at.x(), at.y(), 1);
    if (share_outside(config, pose) <= config.outside) break;
    offset *= 0.9;
    if (attempt >= 20) depth_m *= 1.03;
  }
  return pose;
}

}  // namespace

std::vector<Pose> board_poses(const BoardsSceneConfig& config,
                              const std::function<bool(const Pose& camera_from_board)>& is_free,
                              Rng rng) {
  constexpr double kLeastCosine = 0.15;
  const bool is_planned = config.plan != "random";
  const auto& c = config.setting.poses;
  Rng start = rng.fork("start");
  std::array<double, 5> shift{};
  for (double& s : shift) s = uniform(start);
  std::vector<Pose> poses;
  for (int i = 0; i < config.views; ++i) {
    Rng own = rng.fork(static_cast<std::uint64_t>(i));
    Draw draw;
    for (double* value :
         {&draw.across, &draw.down, &draw.tilt, &draw.direction, &draw.size, &draw.roll})
      *value = uniform(own);
    if (is_planned) {
      draw.across = wrapped(radical_inverse(i, 2) + shift[0]);
      draw.down = wrapped(radical_inverse(i, 3) + shift[1]);
      draw.tilt = wrapped(radical_inverse(i, 5) + shift[2]);
      draw.size = wrapped(radical_inverse(i, 7) + shift[3]);
      draw.direction = wrapped(i * kGoldenAngle / (2 * kPi) + shift[4]);
    }
    double tilt_rad = c.tilt_min_rad + (c.tilt_max_rad - c.tilt_min_rad) * draw.tilt;
    Pose pose = pose_of(config, draw, tilt_rad);
    for (int attempt = 0; attempt < 40; ++attempt) {
      if (facing_cosine(pose) >= kLeastCosine && is_free(pose)) break;
      tilt_rad *= 0.85;
      pose = pose_of(config, draw, tilt_rad);
    }
    poses.push_back(pose);
  }
  return poses;
}

}  // namespace cousin
