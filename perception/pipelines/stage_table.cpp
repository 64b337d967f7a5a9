#include "perception/pipelines/stage_table.h"

#include <stdexcept>
#include <utility>

#include "perception/splats/splat_ply.h"
#include "sim/dataset/atomic_file.h"
#include "sim/dataset/seam_io.h"
#include "sim/types/whole_file.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

// ---- Readers and writers that seam_io.h has not as they are needed here
// --------------------------

constexpr const char* kSplatsFile = "splats.ply";  ///< the reference's layout
constexpr const char* kBlendedFile = "splats_blended.csv";

/// What the files of a seam are of.
struct SeamScope {
  const Capture& capture;
  int scene_index;
  const Warn& warn;
};

/// How many of the views trained on each Gaussian gives colour to, in the order of the model's
/// file. No file where that is not known.
void write_blended(const fs::path& dir, const SplatModel& model) {
  remove_own(dir / kBlendedFile);  // of another model
  if (model.views_seen.empty() || model.views_seen.size() != model.splats.size()) return;
  std::string text = "views\n";
  for (const int views : model.views_seen) text += std::to_string(views) + "\n";
  write_file(dir / kBlendedFile, text);
}

void write_splats(const fs::path& dir, const SplatModel& model, int) {
  write_splat_ply(dir / kSplatsFile, model);
  write_blended(dir, model);
}

/// The model, having told `warn` of rows that are no Gaussian.
SplatModel read_splats(const fs::path& dir, const SeamScope& of) {
  SplatFile file = read_splat_ply(dir / kSplatsFile);
  const std::size_t left_out = file.not_finite + file.zero_rotations;
  if (of.warn && left_out > 0) {
    of.warn((dir / kSplatsFile).string() + ": " + std::to_string(left_out) + " of " +
            std::to_string(left_out + file.model.splats.size()) +
            " rows are left out: " + std::to_string(file.not_finite) + " with NaN or infinity, " +
            std::to_string(file.zero_rotations) + " with a rotation of length zero");
  }
  return std::move(file.model);
}

/// Masks are of the first sensor's images.
Silhouettes read_masks(const fs::path& dir, const SeamScope& of) {
  MaskImages images;
  images.scene = of.scene_index;
  for (const Frame& frame : of.capture.frames) {
    const Camera& camera = frame.sensors.front().reported;
    images.size_px[frame.id] = {camera.width_px, camera.height_px};
  }
  return read_silhouettes(dir, images);
}

/// Boxes and keypoints are of every sensor's colour images.
DetectionImages detection_images(const SeamScope& of) {
  DetectionImages images;
  images.scene = of.scene_index;
  for (const Frame& frame : of.capture.frames) {
    for (std::size_t s = 0; s < frame.sensors.size(); ++s) {
      const Camera& camera = frame.sensors[s].reported;
      images.size_px[{frame.id, static_cast<int>(s)}] = {camera.width_px, camera.height_px};
    }
  }
  return images;
}

constexpr auto read_boxes_of = [](const fs::path& dir, const SeamScope& of) {
  return read_boxes(dir, detection_images(of));
};
constexpr auto read_keypoints_of = [](const fs::path& dir, const SeamScope& of) {
  return read_keypoints(dir, detection_images(of));
};

void write_masks(const fs::path& dir, const Silhouettes& silhouettes, int scene_index) {
  if (!silhouettes.empty()) write_silhouettes(dir, silhouettes, scene_index);
}

/// As StageRow's columns want them.
template <auto kRead>
constexpr auto reader = [](const fs::path& dir, const SeamScope&) { return kRead(dir); };
template <auto kWrite>
constexpr auto writer = [](const fs::path& dir, const auto& seam, int) { kWrite(dir, seam); };

// ---- What a seam says of each frame is taken by its place
// -----------------------------------------

template <auto kSeam>
void require_frames(std::string_view stage, const Capture& capture, const Estimate& estimate) {
  const auto& items = estimate.*kSeam;
  const auto fail = [&](const std::string& why) { throw StageError(std::string(stage), why); };
  if (items.size() != capture.frames.size()) {
    fail(std::to_string(items.size()) + " frames; the capture has " +
         std::to_string(capture.frames.size()));
  }
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (items[i].frame == capture.frames[i].id) continue;
    fail("place " + std::to_string(i) + " is frame " + std::to_string(items[i].frame) +
         ", of the capture frame " + std::to_string(capture.frames[i].id) +
         "; frames come in the capture's order");
  }
}

/// Corners and depths may be empty where a later stage is replaced.
template <auto kSeam>
void require_frames_if_any(std::string_view stage, const Capture& capture,
                           const Estimate& estimate) {
  if (!(estimate.*kSeam).empty()) require_frames<kSeam>(stage, capture, estimate);
}

// ---- Rows
// ----------------------------------------------------------------------------------------

/// A row with the columns that follow from the members and from how the seam is read and written.
template <auto kStage, auto kSeam, auto kRead, auto kWrite>
StageRow complete(StageRow row) {
  row.is_there = [](const Stages& stages) { return stages.*kStage != nullptr; };
  row.leave_out = [](Stages& stages) { stages.*kStage = nullptr; };
  row.replace = [](Stages& base, const Stages& from) { base.*kStage = from.*kStage; };
  row.read_from = [](Stages& stages, SeamFolder folder, int scene_index, Warn warn) {
    stages.*kStage = [folder = std::move(folder), scene_index, warn = std::move(warn)](
                         const Capture& capture, const Estimate& so_far) {
      const auto dir = folder(capture, so_far);
      return kRead(*dir, SeamScope{capture, scene_index, warn});
    };
  };
  row.run = [](const Stages& stages, const Capture& capture, Estimate& estimate) {
    estimate.*kSeam = (stages.*kStage)(capture, estimate);
  };
  row.write = [](const fs::path& dir, const Estimate& estimate, int scene_index) {
    kWrite(dir, estimate.*kSeam, scene_index);
  };
  return row;
}

std::vector<StageRow> make_rows() {
  using S = Stages;
  using E = Estimate;
  return {
      complete<&S::corners, &E::corners, reader<read_corners>, writer<write_corners>>(
          {.name = "corners",
           .files = {"corners.json"},
           .check = require_frames_if_any<&E::corners>}),
      complete<&S::poses, &E::poses, reader<read_poses>, writer<write_poses>>(
          {.name = "poses", .files = {"poses.json"}, .check = require_frames<&E::poses>}),
      complete<&S::splats, &E::splats, read_splats, write_splats>(
          {.name = "splats", .files = {kSplatsFile, kBlendedFile}}),
      complete<&S::boxes, &E::boxes, read_boxes_of, write_boxes>(
          {.name = "boxes", .files = {"boxes.json"}}),
      complete<&S::keypoints, &E::keypoints, read_keypoints_of, write_keypoints>(
          {.name = "keypoints", .files = {"keypoints.json"}}),
      complete<&S::depths, &E::depths, reader<read_depths>, writer<write_depths>>(
          {.name = "depth",
           .files = {"depth/frames.json", "depth/######.exr", "depth_sigma/######.exr",
                     "depth_normal/######.exr"},
           .makes_needless = {"splats"},
           .check = require_frames_if_any<&E::depths>}),
      complete<&S::cloud, &E::cloud, reader<read_cloud>, writer<write_cloud>>(
          {.name = "cloud", .files = {"cloud.ply"}}),
      complete<&S::clusters, &E::clusters, reader<read_clusters>, writer<write_clusters>>(
          {.name = "clusters",
           .files = {"clusters.ply"},
           .makes_needless = {"splats", "depth", "cloud"}}),
      complete<&S::silhouettes, &E::silhouettes, read_masks, write_masks>(
          {.name = "masks", .files = {"masks.json"}}),
      complete<&S::fits, &E::fits, reader<read_fits>, writer<write_fits>>(
          {.name = "fits", .files = {"fits.json"}}),
      complete<&S::tracks, &E::tracks, reader<read_tracks>, writer<write_tracks>>(
          {.name = "tracks", .files = {"tracks.json"}}),
      complete<&S::surfaces, &E::surfaces, reader<read_surfaces>, writer<write_surfaces>>(
          {.name = "surfaces", .files = {"surfaces.json", "meshes/######*.ply"}}),
      complete<&S::traits, &E::traits, reader<read_traits>, writer<write_traits>>(
          {.name = "traits", .files = {"traits.json"}}),
  };
}

/// Removes a folder's files that are named by six digits and `ending`, and the folder if that was
/// all: it may be somebody's own.
void remove_numbered(const fs::path& folder, const std::string& ending) {
  if (fs::symlink_status(folder).type() != fs::file_type::directory) return;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    const bool is_numbered = name.find_first_not_of("0123456789") == 6;
    if (is_numbered && name.ends_with(ending)) files.push_back(entry.path());
  }
  for (const fs::path& file : files) remove_own(file);
  std::error_code not_empty;
  fs::remove(folder, not_empty);
}

}  // namespace

std::span<const StageRow> stage_table() {
  static const std::vector<StageRow> kRows = make_rows();
  return kRows;
}

const StageRow& stage_row(std::string_view name) {
  std::string known;
  for (const StageRow& row : stage_table()) {
    if (row.name == name) return row;
    known += (known.empty() ? "" : ", ") + std::string(row.name);
  }
  throw std::invalid_argument("stage \"" + std::string(name) + "\" is not one of " + known);
}

Stages replace_stages(Stages base, const Stages& replacement,
                      const std::vector<std::string>& names) {
  for (const std::string& name : names) stage_row(name).replace(base, replacement);
  return base;
}

void leave_out_needless(Stages& stages, const std::vector<std::string>& known) {
  for (const std::string& name : known) {
    for (const std::string_view needless : stage_row(name).makes_needless)
      stage_row(needless).leave_out(stages);
  }
}

void remove_seam(const fs::path& dir, const StageRow& stage) {
  for (const std::string_view pattern : stage.files) {
    const fs::path file = dir / pattern;
    const bool is_numbered = file.filename().string().starts_with("######");
    if (is_numbered)
      remove_numbered(file.parent_path(), file.extension().string());
    else
      remove_own(file);
  }
}

}  // namespace cousin
