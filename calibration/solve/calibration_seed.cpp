#include "calibration/solve/calibration_seed.h"

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "calibration/boards/homography.h"
#include "calibration/boards/planar_pose.h"

namespace cousin {
namespace {

constexpr std::size_t kSeedViews = 5;
constexpr double kWidestSeed_rad = 1.3;  ///< rays farther off the axis do not enter a homography

std::vector<const ProblemView*> views_of_lens(const CalibrationProblem& problem, int lens) {
  std::vector<const ProblemView*> views;
  for (const ProblemView& view : problem.views) {
    if (problem.lens_of_camera[static_cast<std::size_t>(view.camera)] == lens)
      views.push_back(&view);
  }
  return views;
}

template <class T>
std::vector<T> evenly(const std::vector<T>& all, std::size_t most) {
  if (all.size() <= most) return all;
  std::vector<T> some;
  for (std::size_t i = 0; i < most; ++i) some.push_back(all[i * all.size() / most]);
  return some;
}

PlanarPose view_pose(const CalibrationProblem& problem, const Lens& lens, const ProblemView& view) {
  std::vector<BoardPoint> points;
  const double least_z = std::cos(kWidestSeed_rad);
  for (const ProblemPoint& p : view.points) {
    const std::optional<Eigen::Vector3d> ray = lens.unproject(p.pixel_px);
    if (!ray || ray->z() < least_z) continue;
    points.push_back(
        {problem.target[static_cast<std::size_t>(p.id)], p.pixel_px, Eigen::Matrix2d::Identity()});
  }
  if (points.size() < 4) return {};
  return estimate_planar_pose(lens.camera(), points);
}

/// Mean square of the fits, in square pixels, of views capped so that one cannot decide.
double seed_cost(const CalibrationProblem& problem, const Camera& camera,
                 const std::vector<const ProblemView*>& views) {
  const Lens lens(camera);
  const double cap = 0.1 * camera.width_px;
  double sum = 0;
  for (const ProblemView* view : views) {
    const PlanarPose pose = view_pose(problem, lens, *view);
    sum += pose.ok ? std::min(pose.rms_px * pose.rms_px, cap * cap) : cap * cap;
  }
  return sum;
}

/// Focal lengths from homographies with the principal point at `centre`; nothing if they do not
/// come out positive. For the image of the absolute conic diag(1 / fx^2, 1 / fy^2, 1), columns 1
/// and 2 of a homography are orthogonal and of one length.
std::optional<Eigen::Vector2d> zhang(const CalibrationProblem& problem,
                                     const std::vector<const ProblemView*>& views,
                                     const Eigen::Vector2d& centre, double size_px) {
  Eigen::MatrixXd a(2 * static_cast<Eigen::Index>(views.size()), 2);
  Eigen::VectorXd b(a.rows());
  Eigen::Index row = 0;
  for (const ProblemView* view : views) {
    std::vector<PlanePoint> points;
    for (const ProblemPoint& p : view->points) {
      points.push_back({problem.target[static_cast<std::size_t>(p.id)].head<2>(),
                        (p.pixel_px - centre) / size_px, 1 / size_px});
    }
    const HomographyFit fit = fit_homography(points);
    if (!fit.ok) continue;
    const Eigen::Matrix3d h = fit.normalized_from_plane / fit.normalized_from_plane.col(0).norm();
    a.row(row) << h(0, 0) * h(0, 1), h(1, 0) * h(1, 1);
    b(row++) = -h(2, 0) * h(2, 1);
    a.row(row) << h(0, 0) * h(0, 0) - h(0, 1) * h(0, 1), h(1, 0) * h(1, 0) - h(1, 1) * h(1, 1);
    b(row++) = h(2, 1) * h(2, 1) - h(2, 0) * h(2, 0);
  }
  if (row < 2) return std::nullopt;
  const Eigen::Vector2d w = a.topRows(row).colPivHouseholderQr().solve(b.head(row));
  if (!(w.x() > 0 && w.y() > 0)) return std::nullopt;
  const Eigen::Vector2d f = size_px * w.cwiseInverse().cwiseSqrt();
  const bool usable = f.allFinite() && f.x() < 2 * f.y() && f.y() < 2 * f.x();
  return usable ? std::optional<Eigen::Vector2d>(f) : std::nullopt;
}

Camera bare_camera(const ProblemLens& lens) {
  Camera camera = lens.like;
  if (camera.model != LensModel::kannala_brandt4 &&
      camera.model != LensModel::splined_stereographic) {
    camera.model = LensModel::pinhole;
  }
  camera.distortion = {};
  camera.spline = lens.shape.grid;
  camera.spline.delta_u.assign(
      static_cast<std::size_t>(2 * lens.shape.grid.columns * lens.shape.grid.rows), 0.0);
  camera.cx_px = 0.5 * (camera.width_px - 1);
  camera.cy_px = 0.5 * (camera.height_px - 1);
  return camera;
}

/// Angle (rad) and distance (units) between two poses.
double apart(const Pose& a, const Pose& b) {
  return angle_rad(a.rotation.conjugate() * b.rotation) +
         (a.translation_m - b.translation_m).norm() / (1 + a.translation_m.norm());
}

const Pose kHalfTurn{Eigen::Quaterniond(0, 0, 0, 1), Eigen::Vector3d::Zero()};

/// What each view says of the pose of its camera, given its frame's; two where a half turn is
/// unknown.
struct Candidate {
  std::size_t view = 0;
  Pose camera_from_rig;
  bool turned = false;
};

/// The candidate that agrees best with all views.
Pose medoid(const std::vector<Candidate>& all) {
  const std::vector<Candidate> some = evenly(all, 60);
  double best = std::numeric_limits<double>::infinity();
  Pose pose;
  for (const Candidate& a : some) {
    double sum = 0;
    for (const Candidate& b : some)
      sum += std::min(0.3, apart(a.camera_from_rig, b.camera_from_rig));
    if (sum < best) best = sum, pose = a.camera_from_rig;
  }
  return pose;
}

/// Numbers a view's points from the other end.
void turn_half(ProblemView& view, int points_of_target) {
  for (ProblemPoint& p : view.points) p.id = points_of_target - 1 - p.id;
  std::reverse(view.points.begin(), view.points.end());
}

/// The growing rig: cameras and frames whose poses are known so far.
struct RigGrowth {
  const std::vector<ProblemView>& views;
  const std::vector<std::optional<Pose>>& poses;  ///< of the views, camera_from_target
  std::vector<std::optional<Pose>> cameras;       ///< camera_from_rig
  std::vector<std::optional<Pose>> frames;        ///< rig_from_target

  /// Gives the frames that a known camera sees their poses.
  void place_frames(std::size_t camera) {
    for (std::size_t v = 0; v < poses.size(); ++v) {
      auto& frame = frames[static_cast<std::size_t>(views[v].frame)];
      if (views[v].camera == static_cast<int>(camera) && poses[v] && !frame)
        frame = inverse(*cameras[camera]) * *poses[v];
    }
  }
  std::vector<Candidate> candidates(std::size_t camera) const {
    std::vector<Candidate> found;
    for (std::size_t v = 0; v < poses.size(); ++v) {
      const auto& frame = frames[static_cast<std::size_t>(views[v].frame)];
      if (views[v].camera != static_cast<int>(camera) || !poses[v] || !frame) continue;
      found.push_back({v, *poses[v] * inverse(*frame), false});
      if (views[v].half_turn_unknown)
        found.push_back({v, *poses[v] * kHalfTurn * inverse(*frame), true});
    }
    return found;
  }
};

/// Keeps the views that have a place, and their frames, without gaps.
void keep_placed(CalibrationProblem& problem, const RigGrowth& rig, CalibrationState& state) {
  std::vector<ProblemView> views;
  std::vector<int> index(rig.frames.size(), -1), numbers;
  for (std::size_t v = 0; v < rig.poses.size(); ++v) {
    const auto f = static_cast<std::size_t>(problem.views[v].frame);
    if (!rig.poses[v] || !rig.frames[f] ||
        !rig.cameras[static_cast<std::size_t>(problem.views[v].camera)])
      continue;
    if (index[f] < 0) {
      index[f] = static_cast<int>(numbers.size());
      numbers.push_back(problem.frames[f]);
      state.frames.push_back(pose_vector(*rig.frames[f]));
    }
    views.push_back(problem.views[v]);
    views.back().frame = index[f];
  }
  problem.views = std::move(views);
  problem.frames = std::move(numbers);
}

}  // namespace

Eigen::VectorXd seed_lens(const CalibrationProblem& problem, int index) {
  const ProblemLens& lens = problem.lenses[static_cast<std::size_t>(index)];
  if (lens.given) return lens_parameters(lens.like);
  Camera camera = bare_camera(lens);
  const std::vector<const ProblemView*> views = evenly(views_of_lens(problem, index), kSeedViews);
  std::vector<Eigen::Vector2d> focal;
  const double size = std::max(camera.width_px, camera.height_px);
  const bool perspective = camera.model == LensModel::pinhole;
  const double first = perspective ? 0.3 * size : 0.2 * size;
  const double last = perspective ? 25 * size : 4 * size;
  for (double f = first; f < last; f *= 1.4) focal.emplace_back(f, f);
  const auto closed = zhang(problem, views, {camera.cx_px, camera.cy_px}, size);
  if (perspective && closed) focal.insert(focal.begin(), *closed);
  double best = std::numeric_limits<double>::infinity();
  Eigen::Vector2d chosen = focal.front();
  for (const Eigen::Vector2d& f : focal) {
    camera.fx_px = f.x(), camera.fy_px = f.y();
    const double cost = seed_cost(problem, camera, views);
    if (cost < best) best = cost, chosen = f;
  }
  Eigen::VectorXd parameters = Eigen::VectorXd::Zero(lens_parameter_count(lens.shape));
  parameters.head<4>() << chosen, camera.cx_px, camera.cy_px;
  return parameters;
}

std::vector<std::optional<Pose>> seed_view_poses(const CalibrationProblem& problem,
                                                 const std::vector<Eigen::VectorXd>& lenses) {
  std::vector<Lens> cameras;
  for (std::size_t i = 0; i < lenses.size(); ++i)
    cameras.emplace_back(with_parameters(problem.lenses[i].like, lenses[i]));
  std::vector<std::optional<Pose>> poses;
  for (const ProblemView& view : problem.views) {
    const auto lens =
        static_cast<std::size_t>(problem.lens_of_camera[static_cast<std::size_t>(view.camera)]);
    const PlanarPose pose = view_pose(problem, cameras[lens], view);
    poses.push_back(pose.ok ? std::optional<Pose>(pose.camera_from_board) : std::nullopt);
  }
  return poses;
}

CalibrationProblem single_lens_problem(const CalibrationProblem& problem, int lens, int most) {
  CalibrationProblem single = problem;
  single.lenses = {problem.lenses[static_cast<std::size_t>(lens)]};
  single.lens_of_camera = {0};
  single.views.clear();
  single.frames.clear();
  for (const ProblemView* view :
       evenly(views_of_lens(problem, lens), static_cast<std::size_t>(most))) {
    single.views.push_back(*view);
    single.views.back().camera = 0;
    single.views.back().frame = static_cast<int>(single.frames.size());
    single.frames.push_back(static_cast<int>(single.frames.size()));
  }
  return single;
}

std::vector<int> assemble_rig(CalibrationProblem& problem,
                              const std::vector<std::optional<Pose>>& poses,
                              CalibrationState& state) {
  const std::size_t cameras = problem.lens_of_camera.size();
  const std::vector<ProblemView> views = problem.views;
  RigGrowth rig{views, poses, {}, {}};
  rig.cameras.resize(cameras);
  rig.frames.resize(problem.frames.size());
  rig.cameras.front() = Pose{};
  rig.place_frames(0);
  for (std::size_t joined = 1; joined < cameras; ++joined) {
    std::size_t best = 0;
    std::vector<Candidate> most;
    for (std::size_t c = 1; c < cameras; ++c) {
      if (rig.cameras[c]) continue;
      std::vector<Candidate> found = rig.candidates(c);
      if (found.size() > most.size()) best = c, most = std::move(found);
    }
    if (most.empty()) break;
    rig.cameras[best] = medoid(most);
    // The turned candidate of a view follows the one that is not.
    for (std::size_t i = 1; i < most.size(); ++i) {
      if (most[i].turned && apart(most[i].camera_from_rig, *rig.cameras[best]) <
                                apart(most[i - 1].camera_from_rig, *rig.cameras[best]))
        turn_half(problem.views[most[i].view], static_cast<int>(problem.target.size()));
    }
    rig.place_frames(best);
  }
  std::vector<int> alone;
  for (std::size_t c = 0; c < cameras; ++c) {
    if (!rig.cameras[c]) alone.push_back(static_cast<int>(c));
    state.cameras.push_back(rig.cameras[c] ? pose_vector(*rig.cameras[c]) : Vector6d::Zero());
  }
  keep_placed(problem, rig, state);
  return alone;
}

}  // namespace cousin
