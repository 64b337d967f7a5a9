// JSON seams: schemas in seam_json.cpp and seam_masks.cpp. Besides:
// depth/000000.exr, depth_sigma/000000.exr: metres, NaN = none; depth_normal/000000.exr: X, Y, Z,
// unit, in the camera, towards it, 0 = none. Another program may write .npy (npy.h) in their place
// depth/frames.json
//   {"frames": [0, 1, ...]}: all frames in order, also those without a depth image. Another program
//   may leave it out; then the frames are those with an image.
// surfaces.json
//   {"surfaces": [{"instance": 0, "status": "ok", "mesh": "meshes/000000.ply" or null,
//                  "points": "meshes/000000_points.ply" or null,
//                  "samples": "meshes/000000_samples.ply" or null, "sample_count": 0}]}
//   points: vertices only; samples: the vertices of all samples, one sample after the other.
// PLY files are in metres: one whose comment names another unit is refused.

#include "sim/dataset/seam_io.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/float_files.h"
#include "sim/dataset/for_each_frame.h"
#include "sim/dataset/json_interop.h"
#include "sim/dataset/seam_json.h"
#include "sim/geometry/mesh_io.h"
#include "sim/geometry/ply_rows.h"
#include "sim/imaging/exr_vectors.h"
#include "sim/imaging/image_io.h"
#include "sim/types/memory_limit.h"
#include "sim/types/utf8.h"
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
    const fs::path ending = entry.path().extension();
    if (ending != ".exr" && ending != ".npy") continue;
    const int frame = number_of_six_digits(entry.path().stem().string());
    if (frame < 0)
      throw std::runtime_error(entry.path().string() + ": the name is not a frame's six digits");
    frames.push_back(frame);
  }
  if (frames.empty())
    throw std::runtime_error((dir / "depth").string() +
                             ": holds no .exr and no .npy, such as 000000.npy");
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

/// What the depth images take in memory, from their headers.
void check_depth_memory(const fs::path& dir, const std::vector<int>& frames) {
  std::uint64_t bytes = 0;
  for (const int frame : frames) {
    const std::string name = six_digits(frame);
    for (const auto& [folder, pixel_bytes] : {std::pair("depth/", sizeof(float)),
                                              {"depth_sigma/", sizeof(float)},
                                              {"depth_normal/", sizeof(Eigen::Vector3f)}}) {
      const std::string file = float_file(dir, folder + name);
      if (file.empty()) continue;
      const std::uint64_t pixels = float_pixels(resolve_inside(dir, file));
      bytes = bytes_plus(bytes, bytes_times(pixels, pixel_bytes));
    }
    const std::string file = float_file(dir, "depth/" + name);
    check_memory(file.empty() ? dir / "depth" : dir / file, bytes,
                 "the depth images up to frame " + std::to_string(frame));
  }
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
  const std::string name = six_digits(frame);
  const std::string depth_file = float_file(dir, "depth/" + name);
  if (depth_file.empty()) return depth;
  depth.depth_m = read_floats(resolve_inside(dir, depth_file));
  if (const std::string sigma = float_file(dir, "depth_sigma/" + name); !sigma.empty()) {
    const fs::path file = resolve_inside(dir, sigma);
    depth.sigma_m = read_floats(file);
    check_size(file, depth.sigma_m, depth.depth_m);
  }
  if (const std::string normal = float_file(dir, "depth_normal/" + name); !normal.empty()) {
    const fs::path file = resolve_inside(dir, normal);
    depth.normal = read_float_vectors(file);
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

/// Words of a comment that say another unit than metres: "units mm", "unit: inch".
bool names_other_unit(const std::string& comment) {
  std::string low;
  for (const char c : comment) {
    if (c >= 'A' && c <= 'Z')
      low += static_cast<char>(c + 32);
    else
      low += c == ':' || c == '=' ? ' ' : c;
  }
  std::istringstream words(low);
  std::string word, unit;
  while (words >> word) {
    if (word != "unit" && word != "units") continue;
    words >> unit;
    return unit != "" && unit != "m" && unit != "meter" && unit != "meters" && unit != "metre" &&
           unit != "metres";
  }
  return false;
}

/// The header of a PLY file of a seam. @throws if a comment names another unit than metres.
geometry::PlyHeader metre_ply_header(const fs::path& file) {
  constexpr std::size_t kMostHeaderBytes = std::size_t{1} << 16;
  std::ifstream stream(file, std::ios::binary);
  std::string bytes(kMostHeaderBytes, '\0');
  stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(stream.gcount()));
  geometry::PlyHeader header = geometry::parse_ply_header(bytes, file.string());
  for (const std::string& comment : header.comments) {
    if (!names_other_unit(comment)) continue;
    throw std::runtime_error(file.string() + ": the comment \"" +
                             readable_utf8(cut_utf8(comment, 100)) +
                             "\" names a unit other than metres, which this file must be in");
  }
  return header;
}

std::uint64_t size_of_file(const fs::path& file) {
  std::error_code none;
  const std::uintmax_t size = fs::file_size(file, none);
  if (none) throw std::runtime_error(file.string() + ": cannot read: " + none.message());
  return size;
}

/// What reading a PLY file takes at most, by the rows that its header announces; a count that the
/// file is too short for is refused by the reader.
std::uint64_t ply_memory(const geometry::PlyHeader& header, std::uint64_t file_bytes) {
  constexpr std::uint64_t kRowBytes = 64, kNumberBytes = 8, kListBytes = 64, kItemBytes = 8;
  std::uint64_t bytes = bytes_times(file_bytes, kItemBytes);
  for (const geometry::PlyElementHeader& element : header.elements) {
    std::uint64_t row = kRowBytes;
    for (const geometry::PlyProperty& property : element.properties)
      row += property.is_list ? kListBytes : kNumberBytes;
    bytes = bytes_plus(bytes, bytes_times(std::min<std::uint64_t>(element.count, file_bytes), row));
  }
  return bytes;
}

std::uint64_t memory_of(const Mesh& mesh) {
  return mesh.vertices_m.size() * sizeof(mesh.vertices_m[0]) +
         mesh.triangles.size() * sizeof(mesh.triangles[0]);
}

/// Meshes that the entries of surfaces.json name, read while they fit into memory together.
class SurfaceMeshes {
 public:
  explicit SurfaceMeshes(const fs::path& dir) : dir_(dir) {}
  /// An absent or null key is empty.
  Mesh read(const JsonNode& node, const char* key) {
    if (!node.has(key) || node[key].is_null()) return {};
    constexpr std::uint64_t kMemoryPerByte = 16;  ///< of files of words, which are shorter
    const fs::path file = resolve_inside(dir_, node[key].text());
    const std::uint64_t size = size_of_file(file);
    const std::uint64_t while_read = file.extension() == ".ply"
                                         ? ply_memory(metre_ply_header(file), size)
                                         : bytes_times(size, kMemoryPerByte);
    check_memory(node.file(), bytes_plus(kept_bytes_, while_read),
                 "the meshes and points up to " + file.string());
    Mesh mesh = read_mesh(file);
    kept_bytes_ = bytes_plus(kept_bytes_, memory_of(mesh));
    return mesh;
  }

 private:
  const fs::path& dir_;
  std::uint64_t kept_bytes_ = 0;
};

Surface read_surface(const JsonNode& node, SurfaceMeshes& meshes) {
  node.expect_keys({"instance", "status", "mesh"}, {"points", "samples", "sample_count"});
  Surface surface;
  surface.instance = static_cast<int>(node["instance"].integer(0, 999'999));
  surface.status = node["status"].choice({SurfaceStatus::ok, SurfaceStatus::too_few_views,
                                          SurfaceStatus::empty, SurfaceStatus::not_converged,
                                          SurfaceStatus::touching, SurfaceStatus::not_watertight});
  surface.mesh = meshes.read(node, "mesh");
  surface.points_m = meshes.read(node, "points").vertices_m;
  const std::vector<Eigen::Vector3d> samples = meshes.read(node, "samples").vertices_m;
  const auto count = node.has("sample_count")
                         ? static_cast<std::size_t>(node["sample_count"].integer(0, 1'000'000))
                         : 0;
  // Empty samples would take memory for nothing: a count needs vertices.
  if (count == 0 ? !samples.empty() : samples.empty() || samples.size() % count != 0) {
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

/// The header of a cloud that fits into memory.
geometry::PlyHeader check_cloud(const fs::path& file) {
  const std::uint64_t size = size_of_file(file);
  geometry::PlyHeader header = metre_ply_header(file);
  check_memory(file, ply_memory(header, size), "the points");
  return header;
}

bool has_vertex_property(const geometry::PlyHeader& header, const std::string& name) {
  for (const geometry::PlyElementHeader& element : header.elements) {
    for (const geometry::PlyProperty& property : element.properties) {
      if (element.name == "vertex" && property.name == name) return true;
    }
  }
  return false;
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

void write_boxes(const fs::path& dir, const Boxes& boxes, int scene_index) {
  write_file(dir / "boxes.json", boxes_to_json(boxes, scene_index));
}
Boxes read_boxes(const fs::path& dir, const DetectionImages& images) {
  return read_json(dir, "boxes.json", [&](const std::string& text, const std::string& name) {
    return boxes_from_json(text, name, images);
  });
}

void write_keypoints(const fs::path& dir, const Keypoints& keypoints, int scene_index) {
  write_file(dir / "keypoints.json", keypoints_to_json(keypoints, scene_index));
}
Keypoints read_keypoints(const fs::path& dir, const DetectionImages& images) {
  return read_json(dir, "keypoints.json", [&](const std::string& text, const std::string& name) {
    return keypoints_from_json(text, name, images);
  });
}

void write_fits(const fs::path& dir, const Fits& fits) {
  write_file(dir / "fits.json", fits_to_json(fits));
}
Fits read_fits(const fs::path& dir) { return read_json(dir, "fits.json", fits_from_json); }

void write_tracks(const fs::path& dir, const Tracks& tracks) {
  write_file(dir / "tracks.json", tracks_to_json(tracks));
}
Tracks read_tracks(const fs::path& dir) { return read_json(dir, "tracks.json", tracks_from_json); }

void write_silhouettes(const fs::path& dir, const Silhouettes& silhouettes, int scene_index) {
  write_file(dir / "masks.json", silhouettes_to_json(silhouettes, scene_index));
}
Silhouettes read_silhouettes(const fs::path& dir, const MaskImages& images) {
  return read_json(dir, "masks.json", [&](std::string_view text, const std::string& name) {
    return silhouettes_from_json(text, name, images);
  });
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
  check_depth_memory(dir, frames);
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
  const fs::path file = resolve_inside(dir, "cloud.ply");
  check_cloud(file);
  return read_cloud_ply(file).cloud;
}

void write_clusters(const fs::path& dir, const Clusters& clusters) {
  fs::create_directories(dir);
  write_ply(dir / "clusters.ply", clusters);
}
Clusters read_clusters(const fs::path& dir) {
  const fs::path file = resolve_inside(dir, "clusters.ply");
  const geometry::PlyHeader header = check_cloud(file);
  if (!has_vertex_property(header, "instance")) {
    throw std::runtime_error(file.string() +
                             ": vertices have no property \"instance\", which says whose a point "
                             "is; -1 = nobody's");
  }
  return read_cloud_ply(file);
}

void write_surfaces(const fs::path& dir, const Surfaces& surfaces) {
  fs::create_directories(surfaces.empty() ? dir : dir / "meshes");
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
  SurfaceMeshes meshes(dir);
  for (const JsonNode& node : root["surfaces"].elements(1'000'000)) {
    surfaces.push_back(read_surface(node, meshes));
    if (!seen.insert(surfaces.back().instance).second)
      node["instance"].fail("is an instance that occurs twice");
  }
  return surfaces;
}

}  // namespace cousin
