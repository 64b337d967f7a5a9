// JSON seams: schemas in seam_json.cpp and seam_masks.cpp. Besides:
// depth/000000.exr, depth_sigma/000000.exr: metres, NaN = none; depth_normal/000000.exr: X, Y, Z,
// unit, in the camera, towards it, 0 = none
// depth/frames.json
//   {"frames": [0, 1, ...]}: all frames in order, also those without a depth image. Another program
//   may leave it out; then the frames are those with an image.
// surfaces.json
//   {"surfaces": [{"instance": 0, "status": "ok", "mesh": "meshes/000000.ply" or null,
//                  "points": "meshes/000000_points.ply" or null,
//                  "samples": "meshes/000000_samples.ply" or null, "sample_count": 0}]}
//   points: vertices only; samples: the vertices of all samples, one sample after the other.

#include "sim/dataset/seam_io.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/for_each_frame.h"
#include "sim/dataset/json_interop.h"
#include "sim/dataset/seam_json.h"
#include "sim/geometry/mesh_io.h"
#include "sim/imaging/exr_vectors.h"
#include "sim/imaging/image_io.h"
#include "sim/types/whole_file.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t kJsonLimitBytes = std::size_t{1} << 29;

/// Reads dir/name with a parser of (text, name).
template <class Parse>
auto read_json(const fs::path& dir, const char* name, const Parse& parse) {
  const fs::path file = resolve_inside(dir, name);
  return parse(read_file(file, kJsonLimitBytes), file.string());
}

std::vector<int> frames_with_depth(const fs::path& dir) {
  std::vector<int> frames;
  if (fs::exists(dir / "depth" / "frames.json")) {
    const JsonDocument document = JsonDocument::read(resolve_inside(dir, "depth/frames.json"));
    const JsonNode root = document.root();
    root.expect_keys({"frames"});
    std::set<int> seen;
    for (const JsonNode& node : root["frames"].elements(1'000'000)) {
      frames.push_back(static_cast<int>(node.integer(0, 999'999)));
      if (!seen.insert(frames.back()).second) node.fail("is a frame that occurs twice");
    }
    return frames;
  }
  if (!fs::is_directory(dir / "depth"))
    throw std::runtime_error((dir / "depth").string() + ": the folder is missing");
  for (const fs::directory_entry& entry : fs::directory_iterator(dir / "depth")) {
    if (entry.path().extension() != ".exr") continue;
    const int frame = number_of_six_digits(entry.path().stem().string());
    if (frame < 0)
      throw std::runtime_error(entry.path().string() + ": the name is not a frame's six digits");
    frames.push_back(frame);
  }
  std::sort(frames.begin(), frames.end());
  return frames;
}

template <typename T>
void check_size(const fs::path& file, const Image<T>& image, const Image<float>& depth_m) {
  if (image.width() == depth_m.width() && image.height() == depth_m.height()) return;
  throw std::runtime_error(file.string() + ": the image is " + std::to_string(image.width()) +
                           " x " + std::to_string(image.height()) +
                           " pixels; its depth image has " + std::to_string(depth_m.width()) +
                           " x " + std::to_string(depth_m.height()));
}

/// Vectors are zero or of unit length.
void check_units(const fs::path& file, const Image<Eigen::Vector3f>& image) {
  constexpr float kMostOff = 1e-3F;  // twice what half floats round by
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const float length = image(x, y).norm();
      if (length == 0 || std::abs(length - 1) <= kMostOff) continue;  // NaN is neither
      throw std::runtime_error(file.string() + ": the normal at (" + std::to_string(x) + ", " +
                               std::to_string(y) + ") has length " + std::to_string(length) +
                               ", not 1, nor 0 for none");
    }
  }
}

FrameDepth read_frame_depth(const fs::path& dir, int frame) {
  FrameDepth depth{.frame = frame};
  const std::string name = six_digits(frame) + ".exr";
  if (!fs::exists(dir / "depth" / name)) return depth;
  depth.depth_m = read_exr(resolve_inside(dir, "depth/" + name));
  if (fs::exists(dir / "depth_sigma" / name)) {
    const fs::path file = resolve_inside(dir, "depth_sigma/" + name);
    depth.sigma_m = read_exr(file);
    check_size(file, depth.sigma_m, depth.depth_m);
  }
  if (fs::exists(dir / "depth_normal" / name)) {
    const fs::path file = resolve_inside(dir, "depth_normal/" + name);
    depth.normal = read_exr_vectors(file);
    check_size(file, depth.normal, depth.depth_m);
    check_units(file, depth.normal);
  }
  return depth;
}

/// The samples' vertices one after the other. @throws std::invalid_argument if they differ in
/// count.
std::vector<Eigen::Vector3d> concatenate(const Surface& surface) {
  std::vector<Eigen::Vector3d> all;
  for (const auto& sample : surface.samples_m) {
    if (sample.size() != surface.samples_m.front().size()) {
      throw std::invalid_argument("surface " + std::to_string(surface.instance) +
                                  ": the samples differ in their number of vertices");
    }
    all.insert(all.end(), sample.begin(), sample.end());
  }
  return all;
}

Surface read_surface(const fs::path& dir, const JsonNode& node) {
  node.expect_keys({"instance", "status", "mesh"}, {"points", "samples", "sample_count"});
  const auto read_part = [&](const char* key) -> Mesh {
    if (!node.has(key) || node[key].is_null()) return {};
    return read_mesh(resolve_inside(dir, node[key].text()));
  };
  Surface surface;
  surface.instance = static_cast<int>(node["instance"].integer(0, 999'999));
  surface.status = node["status"].choice({SurfaceStatus::ok, SurfaceStatus::too_few_views,
                                          SurfaceStatus::empty, SurfaceStatus::not_converged,
                                          SurfaceStatus::touching, SurfaceStatus::not_watertight});
  surface.mesh = read_part("mesh");
  surface.points_m = read_part("points").vertices_m;
  const std::vector<Eigen::Vector3d> samples = read_part("samples").vertices_m;
  const auto count = node.has("sample_count")
                         ? static_cast<std::size_t>(node["sample_count"].integer(0, 1'000'000))
                         : 0;
  if (count == 0 ? !samples.empty() : samples.size() % count != 0) {
    node.fail("has " + std::to_string(samples.size()) +
              " sample vertices, which sample_count does not divide");
  }
  for (std::size_t i = 0; i < count; ++i) {
    const auto begin = samples.begin() + static_cast<std::ptrdiff_t>(i * (samples.size() / count));
    surface.samples_m.emplace_back(begin,
                                   begin + static_cast<std::ptrdiff_t>(samples.size() / count));
  }
  return surface;
}

}  // namespace

void write_corners(const fs::path& dir, const Corners& corners) {
  write_file(dir / "corners.json", corners_to_json(corners));
}
Corners read_corners(const fs::path& dir) {
  return read_json(dir, "corners.json", corners_from_json);
}

void write_poses(const fs::path& dir, const Poses& poses) {
  write_file(dir / "poses.json", poses_to_json(poses));
}
Poses read_poses(const fs::path& dir) { return read_json(dir, "poses.json", poses_from_json); }

void write_silhouettes(const fs::path& dir, const Silhouettes& silhouettes, int scene_index) {
  write_file(dir / "masks.json", silhouettes_to_json(silhouettes, scene_index));
}
Silhouettes read_silhouettes(const fs::path& dir) {
  return read_json(dir, "masks.json", silhouettes_from_json);
}

void write_traits(const fs::path& dir, const Traits& traits) {
  write_file(dir / "traits.json", traits_to_json(traits));
}
Traits read_traits(const fs::path& dir) { return read_json(dir, "traits.json", traits_from_json); }

void write_timings(const fs::path& dir, const std::vector<StageTiming>& timings) {
  write_file(dir / "timings.json", timings_to_json(timings));
}
std::vector<StageTiming> read_timings(const fs::path& dir) {
  return read_json(dir, "timings.json", timings_from_json);
}

void write_depths(const fs::path& dir, const Depths& depths) {
  Json frames = Json::array();
  for (const FrameDepth& depth : depths) frames.push_back(depth.frame);
  fs::create_directories(dir / "depth");
  for_each_frame(depths.size(), [&](std::size_t i) {
    const std::string name = six_digits(depths[i].frame) + ".exr";
    const auto write = [&](const char* folder, const auto& image, const auto& to_file) {
      if (image.empty()) {  // what another run left would be taken for this one's
        remove_own(dir / folder / name);
        return;
      }
      fs::create_directories(dir / folder);
      to_file(dir / folder / name, image);
    };
    write("depth", depths[i].depth_m, write_exr);
    write("depth_sigma", depths[i].sigma_m, write_exr);
    write("depth_normal", depths[i].normal, write_exr_vectors);
  });
  Json root = Json::object();
  root["frames"] = frames;
  write_file(dir / "depth" / "frames.json", to_text(root));
}

Depths read_depths(const fs::path& dir) {
  const std::vector<int> frames = frames_with_depth(dir);
  Depths depths(frames.size());
  for_each_frame(frames.size(),
                 [&](std::size_t i) { depths[i] = read_frame_depth(dir, frames[i]); });
  return depths;
}

void write_cloud(const fs::path& dir, const Cloud& cloud) {
  fs::create_directories(dir);
  write_ply(dir / "cloud.ply", cloud);
}
Cloud read_cloud(const fs::path& dir) {
  return read_cloud_ply(resolve_inside(dir, "cloud.ply")).cloud;
}

void write_clusters(const fs::path& dir, const Clusters& clusters) {
  fs::create_directories(dir);
  write_ply(dir / "clusters.ply", clusters);
}
Clusters read_clusters(const fs::path& dir) {
  return read_cloud_ply(resolve_inside(dir, "clusters.ply"));
}

void write_surfaces(const fs::path& dir, const Surfaces& surfaces) {
  fs::create_directories(dir / "meshes");
  std::set<int> seen;
  Json entries = Json::array();
  for (const Surface& surface : surfaces) {
    if (!seen.insert(surface.instance).second) {
      throw std::invalid_argument("surface " + std::to_string(surface.instance) + " occurs twice");
    }
    const std::string stem = "meshes/" + six_digits(surface.instance);
    const auto write_part = [&](const std::string& suffix, const Mesh& mesh) -> Json {
      if (mesh.vertices_m.empty()) return nullptr;
      write_ply(dir / (stem + suffix), mesh);
      return stem + suffix;
    };
    Json entry = {{"instance", surface.instance}, {"status", to_string(surface.status)}};
    entry["mesh"] = write_part(".ply", surface.mesh);
    entry["points"] = write_part("_points.ply", {surface.points_m, {}});
    entry["samples"] = write_part("_samples.ply", {concatenate(surface), {}});
    entry["sample_count"] = surface.samples_m.size();
    entries.push_back(entry);
  }
  Json root = Json::object();
  root["surfaces"] = entries;
  write_file(dir / "surfaces.json", to_text(root));
}

Surfaces read_surfaces(const fs::path& dir) {
  const JsonDocument document = JsonDocument::read(resolve_inside(dir, "surfaces.json"));
  const JsonNode root = document.root();
  root.expect_keys({"surfaces"});
  Surfaces surfaces;
  std::set<int> seen;
  for (const JsonNode& node : root["surfaces"].elements(1'000'000)) {
    surfaces.push_back(read_surface(dir, node));
    if (!seen.insert(surfaces.back().instance).second)
      node["instance"].fail("is an instance that occurs twice");
  }
  return surfaces;
}

}  // namespace cousin
