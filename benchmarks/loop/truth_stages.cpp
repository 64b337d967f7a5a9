#include "benchmarks/loop/truth_stages.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <stdexcept>

#include "benchmarks/loop/box_truth.h"
#include "benchmarks/loop/score_trees.h"
#include "benchmarks/loop/stage_pictures.h"
#include "benchmarks/loop/stem_pictures.h"
#include "benchmarks/loop/true_outline.h"
#include "sim/geometry/measure.h"
#include "sim/truth/specimens.h"

namespace cousin {
namespace {

std::optional<std::int32_t> instance_at(const TruthImages& truth, const Eigen::Vector2d& pixel) {
  const int x = static_cast<int>(std::lround(pixel.x()));
  const int y = static_cast<int>(std::lround(pixel.y()));
  if (!truth.instance.contains(x, y)) return std::nullopt;
  return truth.instance(x, y);
}

int board_id(const Scene& scene) {
  for (const Instance& instance : scene.instances) {
    if (instance.category == "board") return instance.id;
  }
  return -2;  // no board: no pixel carries this id
}

/// The board as it was printed, which may have another size than it should have.
SeedBoard printed_board(const Scene& scene, const SeedBoard& board) {
  for (const Instance& instance : scene.instances) {
    if (instance.category != "board" || instance.material < 0) continue;
    const auto& print = scene.materials[static_cast<std::size_t>(instance.material)].print;
    if (print) return *print;
  }
  return board;
}

/// Height of the board's face at a place, which a bent sheet has.
double face_height_m(const Scene& scene, int board, const Eigen::Vector2d& at_m) {
  for (const Instance& instance : scene.instances) {
    if (instance.id != board) continue;
    const Mesh& mesh = scene.models[static_cast<std::size_t>(instance.model)].mesh;
    double height_m = -std::numeric_limits<double>::infinity();
    for (const auto& t : mesh.triangles) {
      const Eigen::Vector3d a = mesh.vertices_m[t[0]], b = mesh.vertices_m[t[1]],
                            c = mesh.vertices_m[t[2]];
      Eigen::Matrix2d edges;
      edges << (b - a).head<2>(), (c - a).head<2>();
      if (!(edges.determinant() > 1e-15)) continue;  // a side or the underside
      const Eigen::Vector2d part = edges.inverse() * (at_m - a.head<2>());
      if (part.minCoeff() < -1e-9 || part.sum() > 1 + 1e-9) continue;
      height_m = std::max(height_m, a.z() + part.x() * (b - a).z() + part.y() * (c - a).z());
    }
    if (std::isfinite(height_m)) return height_m;
  }
  return 0;
}

Corners true_corners(const SimulatedRun& run, const SeedBoard& nominal) {
  const int id = board_id(run.truth.scene);
  const SeedBoard board = printed_board(run.truth.scene, nominal);
  std::map<std::pair<int, int>, Eigen::Vector3d> places_m;
  for (int row = 0; row < board.squares - 1; ++row) {
    for (int column = 0; column < board.squares - 1; ++column) {
      if (!corner_exists(board, column, row)) continue;
      Eigen::Vector3d place_m = corner_in_world_m(board, column, row);
      place_m.z() = face_height_m(run.truth.scene, id, place_m.head<2>());
      places_m[{row, column}] = place_m;
    }
  }
  Corners result;
  for (std::size_t f = 0; f < run.truth.views.size(); ++f) {
    const TrueView& view = run.truth.views[f];
    FrameCorners frame;
    frame.frame = view.frame;
    for (const auto& [place, place_m] : places_m) {
      const auto pixel = project_rolling(view, place_m);
      if (!pixel || instance_at(run.truth.images[f], *pixel) != id) continue;
      frame.corners.push_back({place.second, place.first, *pixel, isotropic_px2(0.01)});
    }
    frame.status = frame.corners.size() >= 12 ? BoardStatus::ok : BoardStatus::too_few_corners;
    result.push_back(std::move(frame));
  }
  return result;
}

Poses true_poses(const SimulatedRun& run) {
  Poses result;
  for (const TrueView& view : run.truth.views) {
    FramePose pose;
    pose.frame = view.frame;
    pose.status = PoseStatus::ok;
    pose.camera_from_world = middle_pose(view);
    pose.camera = view.camera;
    pose.rms_px = 0;
    result.push_back(pose);
  }
  return result;
}

/// A true box with the mask of the pixels that show its specimen.
DetectedBox box_with_mask(const TrueBox& truth, int id, const Image<std::int32_t>& seen) {
  DetectedBox box;
  box.frame = truth.frame;
  box.sensor = static_cast<int>(truth.sensor);
  box.instance = truth.specimen;
  box.low_px = truth.low_px;
  box.high_px = truth.high_px;
  box.image_px = {seen.width(), seen.height()};
  box.mask_at_px = (truth.low_px.array() + 0.5).cast<int>();
  const Eigen::Vector2i size = (truth.high_px - truth.low_px).cast<int>();
  box.mask = Image<std::uint8_t>(size.x(), size.y());
  for (int y = 0; y < size.y(); ++y) {
    for (int x = 0; x < size.x(); ++x)
      box.mask(x, y) = seen(box.mask_at_px.x() + x, box.mask_at_px.y() + y) == id ? 255 : 0;
  }
  return box;
}

/// Boxes and masks of the pixels that show a specimen, sensor after sensor.
Boxes true_boxes(const SimulatedRun& run) {
  Boxes result;
  const auto objects = specimens_of(run.truth.scene);
  const auto category = [&](const Instance& object) {
    const auto found = std::find(run.categories.begin(), run.categories.end(), object.category);
    return found == run.categories.end() ? 1 : static_cast<int>(found - run.categories.begin()) + 1;
  };
  for (const std::size_t sensor : sensors_with_truth(run.truth)) {
    const SensorTruth own = truth_of_sensor(run.truth, sensor);
    for (const TrueBox& truth : true_boxes_of(run.truth, sensor)) {
      const Instance& object = *objects[static_cast<std::size_t>(truth.specimen)];
      DetectedBox box = box_with_mask(truth, object.id, own.images[truth.view].instance);
      box.category = category(object);
      box.id = static_cast<int>(result.size());
      result.push_back(std::move(box));
    }
  }
  return result;
}

/// What a view shows of one specimen's keypoints, in the order of its model.
std::vector<DetectedKeypoint> keypoints_of(const TruthImages& images, int id) {
  std::vector<DetectedKeypoint> points;
  for (const KeypointView& view : images.keypoints) {
    if (view.instance != id) continue;
    const bool is_seen = view.state == PointState::visible;
    const bool is_inside = is_seen || view.state == PointState::occluded;
    points.push_back({is_seen     ? KeypointStatus::seen
                      : is_inside ? KeypointStatus::hidden
                                  : KeypointStatus::missing,
                      view.pixel_px, 0});
  }
  return points;
}

/// Keypoints of all specimens, sensor after sensor.
Keypoints true_keypoints(const SimulatedRun& run) {
  Keypoints result;
  const auto objects = specimens_of(run.truth.scene);
  for (const std::size_t sensor : sensors_with_truth(run.truth)) {
    const SensorTruth own = truth_of_sensor(run.truth, sensor);
    for (std::size_t f = 0; f < own.views.size(); ++f) {
      for (std::size_t k = 0; k < objects.size(); ++k) {
        KeypointDetection detection;
        detection.frame = own.views[f].frame;
        detection.sensor = static_cast<int>(sensor);
        detection.id = static_cast<int>(result.size());
        detection.instance = static_cast<int>(k);
        detection.points = keypoints_of(own.images[f], objects[k]->id);
        if (!detection.points.empty()) result.push_back(std::move(detection));
      }
    }
  }
  return result;
}

Depths true_depths(const SimulatedRun& run) {
  Depths result;
  for (std::size_t f = 0; f < run.truth.views.size(); ++f) {
    result.push_back({run.truth.views[f].frame, run.truth.images[f].depth_m, {}});
  }
  return result;
}

/// Whether a view sees the point: its depth there is the first surface's, within half a per mille.
bool sees(const TrueView& view, const TruthImages& truth, const Eigen::Vector3d& point_in_world_m) {
  const auto pixel = project_rolling(view, point_in_world_m);
  if (!pixel) return false;
  const int x = static_cast<int>(std::lround(pixel->x()));
  const int y = static_cast<int>(std::lround(pixel->y()));
  if (!truth.depth_m.contains(x, y)) return false;
  const double depth_m = (pose_at_row(view, pixel->y()) * point_in_world_m).z();
  return std::abs(truth.depth_m(x, y) - depth_m) < 5e-4 * depth_m;
}

/// Points of the specimens' true surfaces that at least two views see, with exact normals; about
/// one a quarter millimetre.
Clusters true_clusters(const SimulatedRun& run) {
  constexpr double kSpacing_m = 0.00025;
  Clusters result;
  const auto objects = specimens_of(run.truth.scene);
  for (std::size_t k = 0; k < objects.size(); ++k) {
    const Mesh mesh = mesh_in_world(run.truth.scene, *objects[k]);
    std::map<std::array<int, 3>, bool> taken;
    for (const auto& t : mesh.triangles) {
      const Eigen::Vector3d a = mesh.vertices_m[t[0]], b = mesh.vertices_m[t[1]],
                            c = mesh.vertices_m[t[2]];
      const Eigen::Vector3d point = (a + b + c) / 3;
      const std::array<int, 3> cell = {static_cast<int>(std::floor(point.x() / kSpacing_m)),
                                       static_cast<int>(std::floor(point.y() / kSpacing_m)),
                                       static_cast<int>(std::floor(point.z() / kSpacing_m))};
      if (taken[cell]) continue;
      const Eigen::Vector3d normal = (b - a).cross(c - a).normalized();
      int seen = 0;
      for (std::size_t f = 0; f < run.truth.views.size() && seen < 2; ++f) {
        const Eigen::Vector3d to_camera =
            centre_in_world_m(run.truth.views[f].camera_from_world) - point;
        if (normal.dot(to_camera) > 0.2 * to_camera.norm() &&
            sees(run.truth.views[f], run.truth.images[f], point)) {
          ++seen;
        }
      }
      if (seen < 2) continue;
      taken[cell] = true;
      result.cloud.push_back({point.cast<float>(), normal.cast<float>(), {128, 128, 128}, 1e-5F});
      result.instance.push_back(static_cast<int>(k));
    }
  }
  result.count = static_cast<int>(objects.size());
  return result;
}

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Outer boundary of the contour as seen from its middle: the farthest crossing along each
/// direction.
std::vector<Eigen::Vector2d> outer_boundary(const std::vector<TrueOutlineSegment>& segments,
                                            int directions) {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const TrueOutlineSegment& s : segments)
    middle += (s[0] + s[1]) / (2.0 * static_cast<double>(segments.size()));
  std::vector<double> radius(static_cast<std::size_t>(directions), 0);
  const double step = 2 * std::numbers::pi / directions;
  for (const TrueOutlineSegment& s : segments) {
    const Eigen::Vector2d a = s[0] - middle, b = s[1] - middle;
    double from = std::atan2(a.y(), a.x()), to = std::atan2(b.y(), b.x());
    if (from > to) std::swap(from, to);
    if (to - from > std::numbers::pi) {  // across the cut of atan2
      std::swap(from, to);
      to += 2 * std::numbers::pi;
    }
    for (int i = static_cast<int>(std::ceil(from / step));
         i <= static_cast<int>(std::floor(to / step)); ++i) {
      const Eigen::Vector2d d(std::cos(i * step), std::sin(i * step));
      const double denominator = cross(d, b - a);
      if (std::abs(denominator) < 1e-15) continue;
      double& r = radius[static_cast<std::size_t>(((i % directions) + directions) % directions)];
      r = std::max(r, cross(a, b - a) / denominator);
    }
  }
  std::vector<Eigen::Vector2d> boundary;
  for (int i = 0; i < directions; ++i) {
    const double r = radius[static_cast<std::size_t>(i)];
    if (r > 0)
      boundary.push_back(middle + r * Eigen::Vector2d(std::cos(i * step), std::sin(i * step)));
  }
  return boundary;
}

Silhouettes true_silhouettes(const SimulatedRun& run) {
  Silhouettes result;
  const auto objects = specimens_of(run.truth.scene);
  for (std::size_t k = 0; k < objects.size(); ++k) {
    const Mesh mesh = mesh_in_world(run.truth.scene, *objects[k]);
    for (std::size_t f = 0; f < run.truth.views.size(); ++f) {
      const TrueView& view = run.truth.views[f];
      const std::vector<TrueOutlineSegment> contour = true_contour(mesh, view);
      if (contour.size() < 3) continue;
      const std::vector<Eigen::Vector2d> boundary = outer_boundary(contour, 240);
      Silhouette silhouette{view.frame, static_cast<int>(k), {}};
      for (std::size_t i = 0; i < boundary.size(); ++i) {
        const Eigen::Vector2d& next = boundary[(i + 1) % boundary.size()];
        const Eigen::Vector2d& previous = boundary[(i + boundary.size() - 1) % boundary.size()];
        const Eigen::Vector2d along = (next - previous).normalized();
        const Eigen::Vector2d normal(along.y(),
                                     -along.x());  // the angle grows from x to y: outward
        OutlinePoint point{boundary[i].cast<float>(), normal.cast<float>(), 0.01F, true};
        const auto inside = instance_at(run.truth.images[f], boundary[i] - 1.5 * normal);
        const auto outside = instance_at(run.truth.images[f], boundary[i] + 1.5 * normal);
        const auto is_other = [&](std::int32_t id) {
          return std::any_of(objects.begin(), objects.end(),
                             [&](const Instance* o) { return o->id == id && o != objects[k]; });
        };
        point.on_object = inside && outside && !is_other(*inside) && !is_other(*outside);
        silhouette.outline.push_back(point);
      }
      result.push_back(std::move(silhouette));
    }
  }
  return result;
}

Surfaces true_surfaces(const SimulatedRun& run) {
  Surfaces result;
  for (const Instance* object : specimens_of(run.truth.scene)) {
    Surface surface;
    surface.instance = static_cast<int>(result.size());
    surface.status = SurfaceStatus::ok;
    surface.mesh = mesh_in_world(run.truth.scene, *object);
    surface.points_m = surface.mesh.vertices_m;
    result.push_back(std::move(surface));
  }
  return result;
}

Traits true_traits(const SimulatedRun& run) {
  Traits result;
  for (const Instance* object : specimens_of(run.truth.scene)) {
    SpecimenTraits traits;
    traits.instance = static_cast<int>(result.size());
    traits.status = TraitStatus::ok;
    traits.centroid_in_world_m =
        mass_properties(mesh_in_world(run.truth.scene, *object)).centroid_m;
    for (const TrueTrait& trait : object->traits) {
      traits.traits.push_back({trait.name, trait.unit, trait.value, 0});
    }
    result.push_back(std::move(traits));
  }
  return result;
}

/// The row of a stage whose seam is a function of the run alone.
template <auto kStage, auto kTrue>
constexpr TruthRow row_of(TruthRow row) {
  row.put = [](Stages& stages, const SimulatedRun& run, const SeedBoard&) {
    stages.*kStage = [&run](const Capture&, const Estimate&) { return kTrue(run); };
  };
  return row;
}

Cloud true_cloud(const SimulatedRun& run) { return true_clusters(run).cloud; }

void put_corners(Stages& stages, const SimulatedRun& run, const SeedBoard& board) {
  stages.corners = [&run, board](const Capture&, const Estimate&) {
    return true_corners(run, board);
  };
}

void put_tracks(Stages& stages, const SimulatedRun& run, const SeedBoard&) {
  stages.tracks = [&run](const Capture&, const Estimate& so_far) {
    return true_tracks(run.truth, so_far.boxes);
  };
}

}  // namespace

TruthNeeds truth_stage_needs() {
  TruthNeeds needs;
  needs.depth = true;
  needs.instance = true;
  return needs;
}

std::span<const TruthRow> truth_table() {
  static constexpr auto kRows = std::to_array<TruthRow>({
      {.stage = "corners", .put = put_corners, .why_not_shown = "poses say how well they fit"},
      row_of<&Stages::poses, true_poses>(
          {.stage = "poses", .why_not_shown = "its error is a row of the scores"}),
      {.stage = "splats", .why_none = "no set of Gaussians is the true one", .show = show_splats},
      row_of<&Stages::boxes, true_boxes>({.stage = "boxes", .show = show_boxes}),
      row_of<&Stages::keypoints, true_keypoints>({.stage = "keypoints", .show = show_keypoints}),
      row_of<&Stages::depths, true_depths>({.stage = "depth", .show = show_depths}),
      row_of<&Stages::cloud, true_cloud>({.stage = "cloud", .show = show_cloud}),
      row_of<&Stages::clusters, true_clusters>(
          {.stage = "clusters", .why_not_shown = "the cloud is shown as a whole"}),
      row_of<&Stages::silhouettes, true_silhouettes>({.stage = "masks", .show = show_outlines}),
      {.stage = "fits", .why_none = "a fit's model is its pipeline's own", .show = show_stems},
      {.stage = "tracks", .put = put_tracks, .why_not_shown = "its fruits are numbered"},
      row_of<&Stages::surfaces, true_surfaces>({.stage = "surfaces", .show = show_surfaces}),
      row_of<&Stages::traits, true_traits>({.stage = "traits", .show = show_numbers}),
  });
  return kRows;
}

const TruthRow& truth_row(std::string_view stage) {
  for (const TruthRow& row : truth_table()) {
    if (row.stage == stage) return row;
  }
  throw std::logic_error("stage \"" + std::string(stage) + "\" has no truth row");
}

Stages truth_stages(const SimulatedRun& run, const SeedBoard& board) {
  if (run.truth.images.size() != run.truth.views.size()) {
    throw std::invalid_argument("true seams need truth images of every view");
  }
  Stages stages;
  for (const TruthRow& row : truth_table()) {
    if (row.put) row.put(stages, run, board);
  }
  return stages;
}

}  // namespace cousin
