// BOP, scenewise [thodan/bop_toolkit, docs/bop_datasets_format.md]: true cameras, millimetres
//   OUT/camera.json  models/obj_000001.ply  models/models_info.json  test_targets_bop19.json
//   OUT/train/000000/  and val/, test/: rgb or gray, depth, mask, mask_visib, scene_camera.json,
//                      scene_gt.json, scene_gt_info.json
// An object is a mesh: instances whose files are equal share one. Poses are those of the middle
// row. depth/ is the sensor's own, brought to the picture's pixels; where there is none, that of
// truth/depth in steps of 0.1 mm.

#include <bit>
#include <cmath>
#include <cstring>
#include <map>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/export/export_dataset.h"
#include "sim/dataset/export/export_pictures.h"
#include "sim/dataset/export/for_each_picture.h"
#include "sim/dataset/export/labels.h"
#include "sim/dataset/export/splits.h"
#include "sim/dataset/float_files.h"
#include "sim/dataset/json_interop.h"
#include "sim/dataset/manifest.h"
#include "sim/dataset/truth_format.h"
#include "sim/geometry/measure.h"
#include "sim/geometry/mesh_io.h"
#include "sim/imaging/image_io.h"
#include "sim/imaging/undistort.h"
#include "sim/truth/specimens.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using Interpolation = UndistortConfig::Interpolation;
static_assert(std::endian::native == std::endian::little, "PLY files are written in memory order");

/// Objects of the whole dataset.
struct BopObjects {
  std::map<std::string, int> id_of_hash;
  std::vector<std::map<int, int>> id_of_model;  ///< of each scene: by model
  Json info = Json::object();
};

/// Files of the surface of a specimen: its model's, and those of its organs.
std::vector<fs::path> mesh_files_of(const ExportScene& scene, const Instance& specimen) {
  const ExportTruth& truth = *scene.truth;
  std::vector<fs::path> files;
  for (const std::size_t place : places_of(truth.scene, specimen)) {
    const auto model = static_cast<std::size_t>(truth.scene.instances[place].model);
    files.push_back(resolve_inside(scene.folder / "truth", truth.mesh_files[model]));
  }
  return files;
}

template <class Number>
void put(std::string& bytes, Number value) {
  char raw[sizeof(Number)];
  std::memcpy(raw, &value, sizeof value);
  bytes.append(raw, sizeof raw);
}

/// Binary PLY as bop_toolkit reads it: its types are float, double, int and uchar alone.
std::string bop_ply(const Mesh& mesh) {
  std::string bytes = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                      std::to_string(mesh.vertices_m.size()) +
                      "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
                      std::to_string(mesh.triangles.size()) +
                      "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const Eigen::Vector3d& vertex : mesh.vertices_m) {
    for (int k = 0; k < 3; ++k) put(bytes, vertex[k]);
  }
  for (const auto& triangle : mesh.triangles) {
    put(bytes, std::uint8_t{3});
    for (const std::uint32_t v : triangle) put(bytes, static_cast<std::int32_t>(v));
  }
  return bytes;
}

/// Writes a model in millimetres and says its size. Organs lie as they do at rest.
Json write_model(const std::vector<fs::path>& from, const fs::path& to) {
  Mesh mesh = read_mesh(from.front());
  for (std::size_t i = 1; i < from.size(); ++i) {
    const Mesh organ = read_mesh(from[i]);
    const auto first = static_cast<std::uint32_t>(mesh.vertices_m.size());
    mesh.vertices_m.insert(mesh.vertices_m.end(), organ.vertices_m.begin(), organ.vertices_m.end());
    for (const auto& t : organ.triangles)
      mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  for (Eigen::Vector3d& vertex : mesh.vertices_m) vertex *= 1000;
  write_once(to, bop_ply(mesh));
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& vertex : mesh.vertices_m) box.extend(vertex);
  const Eigen::Vector3d low = box.min(), size = box.sizes();
  return {{"diameter", caliper_diameters(mesh.vertices_m).maximum_m},
          {"min_x", low.x()},
          {"min_y", low.y()},
          {"min_z", low.z()},
          {"size_x", size.x()},
          {"size_y", size.y()},
          {"size_z", size.z()}};
}

BopObjects write_objects(const ExportJob& job) {
  BopObjects objects;
  for (const ExportScene& scene : job.scenes) {
    const ExportTruth& truth = truth_of(scene, "bop");
    std::map<int, int>& ids = objects.id_of_model.emplace_back();
    const std::vector<const Instance*> specimens = specimens_of(truth.scene);
    for (std::size_t i = 0; i < specimens.size(); ++i) {
      job.progress("models of " + six_digits(scene.number), static_cast<int>(i),
                   static_cast<int>(specimens.size()));
      const int model = specimens[i]->model;
      if (ids.contains(model)) continue;
      const std::vector<fs::path> files = mesh_files_of(scene, *specimens[i]);
      std::string hashes;
      for (const fs::path& file : files) hashes += sha256_hex_of_file(file);
      const int next = static_cast<int>(objects.id_of_hash.size()) + 1;
      const auto [known, is_new] = objects.id_of_hash.emplace(hashes, next);
      ids[model] = known->second;
      if (!is_new) continue;
      Json info = write_model(files, job.out / "models" / ("obj_" + six_digits(next) + ".ply"));
      info["name"] = specimens[i]->name;
      info["category"] = variety_of(*specimens[i]);  // one shape, any maturity
      objects.info[std::to_string(next)] = info;
    }
  }
  write_once(job.out / "models/models_info.json", to_text(objects.info));
  return objects;
}

/// One frame of one scene's JSON files.
struct BopFrame {
  int id = 0;
  Json camera, gt = Json::array(), info = Json::array();
};

Json matrix_of(const Camera& c) {
  return {c.fx_px, 0.0, c.cx_px, 0.0, c.fy_px, c.cy_px, 0.0, 0.0, 1.0};
}

/// Pixels inside, their box, and how many of them have depth.
struct MaskCount {
  std::int64_t pixels = 0, with_depth = 0;
  Json box = {-1, -1, -1, -1};
};
MaskCount count(const Image<std::uint8_t>& mask, const Image<std::uint16_t>& depth) {
  MaskCount result;
  int low_x = mask.width(), low_y = mask.height(), high_x = -1, high_y = -1;
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      if (mask(x, y) == 0) continue;
      ++result.pixels;
      if (!depth.empty() && depth(x, y) > 0) ++result.with_depth;
      low_x = std::min(low_x, x);
      low_y = std::min(low_y, y);
      high_x = std::max(high_x, x);
      high_y = std::max(high_y, y);
    }
  }
  if (result.pixels > 0) result.box = {low_x, low_y, high_x - low_x + 1, high_y - low_y + 1};
  return result;
}

/// The sensor's depth, else the true one in steps of 0.1 mm; empty where neither is there.
ExportDepth depth_for(const ExportScene& scene, const ExportPicture& picture, const Camera& lens,
                      const ExportOptions& options) {
  ExportDepth depth = depth_of(scene, picture, handed_over(lens, options), options);
  const int frame = scene.capture.frames[picture.frame].id;
  const std::string relative =
      float_file(scene.folder, "truth/depth/" + six_digits(frame), depth_endings());
  if (!depth.depth.empty() || relative.empty()) return depth;
  Image<float> depth_m = read_truth_depth(scene.folder, relative);
  if (options.undistort)
    depth_m = undistort(depth_m, lens, {.interpolation = Interpolation::nearest}).image;
  depth.unit_m = 1e-4;
  depth.depth = Image<std::uint16_t>(depth_m.width(), depth_m.height());
  for (std::size_t i = 0; i < depth_m.size(); ++i) {
    const double value = std::round(static_cast<double>(depth_m.data()[i]) / depth.unit_m);
    if (value > 0 && value <= 65535) depth.depth.data()[i] = static_cast<std::uint16_t>(value);
  }
  return depth;
}

/// A mask of the dataset as handed over. One without a pixel has no file there; BOP has them all.
Image<std::uint8_t> write_mask(const ExportScene& scene, const fs::path& relative,
                               const Camera& lens, std::int64_t pixels, const fs::path& out,
                               const ExportOptions& options) {
  const fs::path file = resolve_inside(scene.folder, fs::path("truth") / relative);
  if (!fs::exists(file) && pixels > 0)
    throw std::runtime_error(file.string() +
                             " is missing; render with --truth visibility,instance");
  Image<std::uint8_t> mask =
      fs::exists(file) ? read_png8(file) : Image<std::uint8_t>(lens.width_px, lens.height_px);
  if (options.undistort)
    mask = undistort(mask, lens, {.interpolation = Interpolation::nearest}).image;
  fs::create_directories((out / relative).parent_path());
  write_png(out / relative, mask);
  return mask;
}

InstanceVisibility visibility_of(const ExportTruth& truth, int frame, int instance) {
  for (std::size_t i = 0; i < truth.views.size() && i < truth.labels.size(); ++i) {
    if (truth.views[i].frame != frame) continue;
    for (const InstanceVisibility& v : truth.labels[i].visibility) {
      if (v.instance == instance) return v;
    }
  }
  return {};
}

BopFrame write_frame(const ExportJob& job, const ExportScene& scene, const ExportPicture& picture,
                     const std::map<int, int>& objects, const fs::path& out) {
  const ExportTruth& truth = *scene.truth;
  const ExportCamera taken = camera_of(scene, picture, true);
  const Camera camera = handed_over(taken.camera, job.options);
  BopFrame frame;
  frame.id = scene.capture.frames[picture.frame].id;
  const std::string name = six_digits(frame.id);
  write_picture(picture, taken.camera, camera, out / (picture.is_grey ? "gray" : "rgb") / name,
                job.options);
  const ExportDepth depth = depth_for(scene, picture, taken.camera, job.options);
  if (!depth.depth.empty()) {
    fs::create_directories(out / "depth");
    write_png(out / "depth" / (name + ".png"), depth.depth);
  }
  const Pose& camera_from_world = *taken.camera_from_world;
  frame.camera = {{"cam_K", matrix_of(camera)},
                  {"cam_R_w2c", to_json(camera_from_world.rotation.toRotationMatrix())},
                  {"cam_t_w2c", to_json(1000 * camera_from_world.translation_m)},
                  {"depth_scale", 1000 * depth.unit_m}};
  const std::vector<const Instance*> specimens = specimens_of(truth.scene);
  for (std::size_t k = 0; k < specimens.size(); ++k) {
    const Instance& instance = *specimens[k];
    const Pose pose = camera_from_world * world_from_object(instance, taken.time_s);
    frame.gt.push_back({{"cam_R_m2c", to_json(pose.rotation.toRotationMatrix())},
                        {"cam_t_m2c", to_json(1000 * pose.translation_m)},
                        {"obj_id", objects.at(instance.model)},
                        {"instance_id", instance.id}});
    const std::string file = name + "_" + six_digits(static_cast<std::int64_t>(k)) + ".png";
    const auto mask_count = [&](const char* folder, std::int64_t pixels) {
      return count(
          write_mask(scene, fs::path(folder) / file, taken.camera, pixels, out, job.options),
          depth.depth);
    };
    const InstanceVisibility known = visibility_of(truth, frame.id, instance.id);
    const MaskCount whole = mask_count("mask", known.pixels_full);
    const MaskCount seen = mask_count("mask_visib", known.pixels_visible);
    frame.info.push_back({{"bbox_obj", whole.box},
                          {"bbox_visib", seen.box},
                          {"px_count_all", whole.pixels},
                          {"px_count_valid", whole.with_depth},
                          {"px_count_visib", seen.pixels},
                          {"visib_fract", whole.pixels > 0 ? static_cast<double>(seen.pixels) /
                                                                 static_cast<double>(whole.pixels)
                                                           : 0.0}});
  }
  return frame;
}

/// Objects to look for in a frame: those of which at least a tenth is seen, as in BOP 2019.
void add_targets(const BopFrame& frame, int scene, Json& targets) {
  std::map<int, int> count_of;
  for (std::size_t k = 0; k < frame.gt.size(); ++k) {
    if (frame.info[k]["visib_fract"] >= 0.1) ++count_of[frame.gt[k]["obj_id"].get<int>()];
  }
  for (const auto& [object, number] : count_of) {
    targets.push_back(
        {{"im_id", frame.id}, {"inst_count", number}, {"obj_id", object}, {"scene_id", scene}});
  }
}

void require_pinhole(const ExportJob& job) {
  for (const ExportScene& scene : job.scenes) {
    require_labels(scene, false);
    for (const ExportPicture* picture : first_pictures(scene)) {
      const Camera camera = handed_over(camera_of(scene, *picture, true).camera, job.options);
      if (camera.model == LensModel::pinhole) continue;
      throw std::invalid_argument(
          scene.folder.string() + " (frame " +
          std::to_string(scene.capture.frames[picture->frame].id) + "): sensor \"" +
          scene.capture.rig.front().name + "\" has the lens model " +
          std::string(to_string(camera.model)) +
          ", and BOP has pinhole cameras alone; --undistort makes pinhole pictures");
    }
  }
}

}  // namespace

void export_bop(ExportJob& job) {
  job.options.true_cameras = true;
  require_pinhole(job);
  const BopObjects objects = write_objects(job);
  const std::vector<Split> splits = splits_of(job.scenes, job.options.split, Split::test);
  if (const std::string empty = empty_splits(splits, job.options.split); !empty.empty())
    job.warnings.push_back(empty);
  Json targets = Json::array(), first_camera;
  int done = 0;
  for (std::size_t s = 0; s < job.scenes.size(); ++s) {
    const ExportScene& scene = job.scenes[s];
    const fs::path out = job.out / to_string(splits[s]) / six_digits(scene.number);
    std::vector<BopFrame> frames(scene.capture.frames.size());
    for_each_picture(job, scene, first_pictures(scene), done,
                     [&](std::size_t i, const ExportPicture& picture) {
                       frames[i] = write_frame(job, scene, picture, objects.id_of_model[s], out);
                     });
    Json cameras = Json::object(), gt = Json::object(), info = Json::object();
    for (const BopFrame& frame : frames) {
      if (frame.camera.is_null()) continue;
      cameras[std::to_string(frame.id)] = frame.camera;
      gt[std::to_string(frame.id)] = frame.gt;
      info[std::to_string(frame.id)] = frame.info;
      if (first_camera.is_null()) first_camera = frame.camera;
      if (splits[s] == Split::test) add_targets(frame, scene.number, targets);
    }
    write_once(out / "scene_camera.json", to_text(cameras));
    write_once(out / "scene_gt.json", to_text(gt));
    write_once(out / "scene_gt_info.json", to_text(info));
  }
  write_once(job.out / "test_targets_bop19.json", to_text(targets));
  if (first_camera.is_null()) return;
  const Camera size = job.scenes.front().capture.rig.front().camera;
  const Json& k = first_camera["cam_K"];
  write_once(job.out / "camera.json", to_text(Json{{"fx", k[0]},
                                                   {"fy", k[4]},
                                                   {"cx", k[2]},
                                                   {"cy", k[5]},
                                                   {"width", size.width_px},
                                                   {"height", size.height_px},
                                                   {"depth_scale", first_camera["depth_scale"]}}));
}

}  // namespace cousin
