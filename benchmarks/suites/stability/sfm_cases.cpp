#include "benchmarks/suites/stability/sfm_cases.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "perception/sfm/colmap_files.h"
#include "perception/sfm/self_calibration.h"
#include "perception/sfm/sfm_poses.h"
#include "sim/dataset/atomic_file.h"
#include "sim/geometry/similarity.h"
#include "sim/process/scratch_folder.h"
#include "sim/types/rng.h"

namespace cousin {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kUnlimited = std::numeric_limits<double>::quiet_NaN();

Camera grey_lens() {
  Camera camera;
  camera.width_px = 1280;
  camera.height_px = 720;
  camera.fx_px = camera.fy_px = 1000;
  camera.cx_px = 639.5;
  camera.cy_px = 359.5;
  return camera;
}

/// Twelve views around a board with 80 points above it, as structure from motion hands them over:
/// in a world seven times too large.
struct RingOfViews {
  std::vector<Pose> truth;
  SfmModel model;
  std::vector<int> frames;
  Corners corners;
  SeedBoard board;
};
RingOfViews ring_of_views(int placed, int draw = 0) {
  RingOfViews ring;
  Rng rng = Rng(1).fork("ring").fork(static_cast<std::uint64_t>(draw));
  const WorldSimilarity away{7, Eigen::Quaterniond(0.4, 0.3, -0.2, 0.7).normalized(), {1, 2, 3}};
  const Lens lens(grey_lens());
  constexpr int kViews = 12, kPoints = 80;
  for (int i = 0; i < kViews; ++i) {
    const double a = 2 * std::numbers::pi * i / kViews, e = 0.6 + 0.3 * (i % 2);
    Pose pose =
        look_at(0.4 * Vector3d(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e)),
                Vector3d::Zero());
    const Eigen::AngleAxisd roll(0.5 * std::sin(5.0 * i), Vector3d::UnitZ());
    pose = Pose{Eigen::Quaterniond(roll), Vector3d::Zero()} * pose;
    ring.truth.push_back(pose);
    ring.frames.push_back(i);
    FrameCorners corners{.frame = i, .status = BoardStatus::ok};
    for (int row = 0; row < ring.board.squares - 1; ++row) {
      for (int column = 0; column < ring.board.squares - 1; ++column) {
        if (!corner_exists(ring.board, column, row)) continue;
        const auto pixel = lens.project(pose * corner_in_world_m(ring.board, column, row));
        if (pixel)
          corners.corners.push_back({column, row,
                                     *pixel + 0.05 * Vector2d(normal(rng), normal(rng)),
                                     isotropic_px2(0.05)});
      }
    }
    ring.corners.push_back(std::move(corners));
    if (i >= placed) continue;
    ring.model.images.push_back(i);
    ring.model.lenses.push_back(grey_lens());
    ring.model.camera_from_world.push_back(moved(pose, away));
  }
  for (int p = 0; p < kPoints; ++p) {
    const Vector3d at(uniform(rng, -0.05, 0.05), uniform(rng, -0.05, 0.05), uniform(rng, 0, 0.04));
    SfmPoint point{away * at, {}, {}};
    for (int i = 0; i < placed; ++i) {
      const auto pixel = lens.project(ring.truth[static_cast<std::size_t>(i)] * at);
      const Vector2d off(normal(rng), normal(rng));
      if (pixel) point.sightings.push_back({i, *pixel + 0.3 * off});
    }
    ring.model.points.push_back(std::move(point));
  }
  return ring;
}

SfmEstimate refined(const RingOfViews& ring, const SfmConfig& config = {}) {
  return refine_sfm(ring.model, ring.frames, grey_lens(), ring.corners, ring.board, config);
}

double centre_rms_m(const RingOfViews& ring, const SfmEstimate& estimate) {
  double squares = 0;
  int posed = 0;
  for (std::size_t i = 0; i < estimate.poses.size(); ++i) {
    if (estimate.poses[i].status != PoseStatus::ok) continue;
    squares +=
        (centre_in_world_m(estimate.poses[i].camera_from_world) - centre_in_world_m(ring.truth[i]))
            .squaredNorm();
    ++posed;
  }
  return std::sqrt(squares / posed);
}

/// The same as the poses' covariances predict it: of a centre -R't, whose pose has the deviations w
/// of its turn and d of t, the error is R'(w x t - d).
double predicted_centre_rms_m(const SfmEstimate& estimate) {
  double squares = 0;
  int posed = 0;
  for (const FramePose& pose : estimate.poses) {
    if (pose.status != PoseStatus::ok) continue;
    Eigen::Matrix<double, 3, 6> to_centre;
    const Vector3d& t = pose.camera_from_world.translation_m;
    to_centre << 0, t.z(), -t.y(), -1, 0, 0,  //
        -t.z(), 0, t.x(), 0, -1, 0,           //
        t.y(), -t.x(), 0, 0, 0, -1;
    squares += (to_centre * pose.covariance * to_centre.transpose()).trace();
    ++posed;
  }
  return std::sqrt(squares / posed);
}

constexpr int kDraws = 12;  ///< of the noise, where predictions are held to errors

/// Predictions hold where the RMS error over all draws is near the RMS of what is predicted. All
/// centres of a draw err alike, by its focal length, so draws count, not centres: of twelve the
/// ratio's deviation is .2.
void add_honest(const std::string& name, int placed, const SfmConfig& config,
                std::vector<StabilityRow>& rows) {
  double squares = 0, predicted = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    const RingOfViews ring = ring_of_views(placed, draw);
    const SfmEstimate estimate = refined(ring, config);
    squares += std::pow(centre_rms_m(ring, estimate), 2);
    predicted += std::pow(predicted_centre_rms_m(estimate), 2);
  }
  const double ratio = std::sqrt(squares / predicted);
  const std::string quantity =
      "centres, RMS error over the predicted, " + std::to_string(kDraws) + " draws";
  rows.push_back(make_row(name, quantity, "", 1.6, ratio));
  rows.push_back(make_row(name, quantity, "", 0.6, ratio, false));
}

void add_missing_program(std::vector<StabilityRow>& rows) {
  ColmapInput input;
  input.lens = grey_lens();
  const Image<Rgb8> picture(input.lens->width_px, input.lens->height_px);
  input.images = {&picture, &picture};
  input.pairs = image_pairs(2);
  ColmapConfig config;
  config.program = "colmap-that-is-not-there";
  rows.push_back(make_row("COLMAP is absent", "says not_built", "", 1,
                          run_colmap(input, config).status == ColmapStatus::not_built, false));
}

void add_lost_images(std::vector<StabilityRow>& rows) {
  const RingOfViews half = ring_of_views(6);
  SfmConfig alone;
  alone.place_by_board = false;
  const SfmEstimate estimate = refined(half, alone);
  rows.push_back(make_row("half of the images placed", "says partly_registered", "", 1,
                          estimate.status == SfmStatus::partly_registered, false));
  const std::vector<int> expected = {6, 7, 8, 9, 10, 11};
  rows.push_back(make_row("half of the images placed", "names the others", "", 1,
                          estimate.lost == expected, false));
  add_honest("half of the images placed", 6, alone, rows);
  const SfmEstimate whole = refined(half);
  rows.push_back(make_row("half of the images placed, the rest by the board", "says ok", "", 1,
                          whole.status == SfmStatus::ok, false));
  add_honest("half of the images placed, the rest by the board", 6, {}, rows);
}

/// A model of some images as COLMAP leaves it, without points.
void write_model(const std::filesystem::path& folder, int from, int to) {
  ColmapModel model;
  model.cameras[1] = grey_lens();
  for (int i = from; i < to; ++i) model.images[i + 1] = {colmap_image_name(i), 1, Pose{}};
  const ColmapFiles files = colmap_binary(model);
  write_file(folder / "cameras.bin", files.cameras);
  write_file(folder / "images.bin", files.images);
  write_file(folder / "points3D.bin", files.points);
}

void add_components(std::vector<StabilityRow>& rows) {
  const ScratchFolder scratch("cousin-stability");
  write_model(scratch.path() / "0", 0, 3);
  write_model(scratch.path() / "1", 3, 12);
  const std::vector<SfmModel> models = read_models(scratch.path(), 12).models;
  rows.push_back(make_row("two components of 3 and 9 images", "models read", "", 2,
                          static_cast<double>(models.size()), false));
  rows.push_back(make_row("two components of 3 and 9 images", "images of the one taken", "", 9,
                          static_cast<double>(models.front().images.size()), false));
}

void add_little_board(std::vector<StabilityRow>& rows) {
  RingOfViews ring = ring_of_views(12);
  for (std::size_t i = 1; i < ring.corners.size(); ++i)
    ring.corners[i].status = BoardStatus::not_seen;
  rows.push_back(make_row("board in one image alone", "says no_scale", "", 1,
                          refined(ring).status == SfmStatus::no_scale, false));
  const RingOfViews whole = ring_of_views(12);
  const SfmEstimate estimate = refined(whole);
  double scales = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    const SfmEstimate one = refined(ring_of_views(12, draw));
    scales += std::pow((7 * one.metres_per_unit - 1) / one.scale_sigma_share, 2);
  }
  const double scale_ratio = std::sqrt(scales / kDraws);
  const std::string of_scale =
      "error of the scale over its deviation, RMS of " + std::to_string(kDraws) + " draws";
  rows.push_back(make_row("board in all images", of_scale, "", 1.6, scale_ratio));
  rows.push_back(make_row("board in all images", of_scale, "", 0.5, scale_ratio, false));
  SfmConfig squares;
  squares.scale = SfmScale::squares;
  add_honest("board in all images", 12, {}, rows);
  rows.push_back(make_row("board in all images", "centres, RMS error, board adjusted", "m",
                          kUnlimited, centre_rms_m(whole, estimate)));
  rows.push_back(make_row("board in all images", "centres, RMS error, one factor", "m", kUnlimited,
                          centre_rms_m(whole, refined(whole, squares))));
}

/// Views that go straight at a heap: the lens cannot be told.
void add_forward_motion(std::vector<StabilityRow>& rows) {
  SfmModel model;
  Rng rng = Rng(2).fork("forward");
  const Lens lens(grey_lens());
  for (int i = 0; i < 10; ++i) {
    model.images.push_back(i);
    model.lenses.push_back(grey_lens());
    model.camera_from_world.push_back(look_at({0.15, 0, 0.5 - 0.02 * i}, {0.15, 0.01, 0}));
  }
  for (int p = 0; p < 80; ++p) {
    const Vector3d at(uniform(rng, 0.05, 0.25), uniform(rng, -0.1, 0.1), uniform(rng, 0, 0.1));
    SfmPoint point{at, {}, {}};
    for (int i = 0; i < 10; ++i) {
      const auto pixel = lens.project(model.camera_from_world[static_cast<std::size_t>(i)] * at);
      const Vector2d off(normal(rng), normal(rng));
      if (pixel) point.sightings.push_back({i, *pixel + 0.3 * off});
    }
    model.points.push_back(std::move(point));
  }
  const SelfCalibration found = self_calibrate(model, std::nullopt);
  rows.push_back(make_row("lens from views that move along their axis", "says not_determined", "",
                          1, found.status == CalibrationStatus::not_determined, false));
  rows.push_back(make_row("lens from views that move along their axis", "names the motion", "", 1,
                          std::count(found.weaknesses.begin(), found.weaknesses.end(),
                                     CalibrationWeakness::forward_motion) > 0,
                          false));
}

}  // namespace

std::vector<StabilityRow> sfm_cases() {
  std::vector<StabilityRow> rows;
  add_missing_program(rows);
  add_components(rows);
  if (refined(ring_of_views(12)).status == SfmStatus::not_built) {
    rows.push_back(make_row("structure from motion without Ceres", "not built in", "", kUnlimited,
                            kUnlimited));
    return rows;
  }
  add_lost_images(rows);
  add_little_board(rows);
  add_forward_motion(rows);
  return rows;
}

}  // namespace cousin
