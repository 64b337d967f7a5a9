// Posed pictures: a folder a scene.
//   colmap      OUT/000000/images/rgb/000000.png, sparse/0/*.bin, sparse_txt/*.txt
//   nerfstudio  OUT/000000/images/rgb/000000.png, transforms.json
//   tum         OUT/000000/rgb/000000.png, depth/000000.png, rgb.txt, depth.txt, groundtruth.txt,
//               camera.yaml (TUM's own files hold no lens)

#include <cmath>
#include <map>
#include <stdexcept>

#include "sim/dataset/camera_files.h"
#include "sim/dataset/colmap_model.h"
#include "sim/dataset/export/export_dataset.h"
#include "sim/dataset/export/export_pictures.h"
#include "sim/dataset/json_interop.h"
#include "sim/dataset/text_fields.h"
#include "sim/imaging/image_io.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

/// A picture with its place, as it is handed over.
struct PosedPicture {
  const ExportPicture* picture = nullptr;
  Camera lens;    ///< that took it
  Camera camera;  ///< of the picture handed over
  Pose camera_from_world;
  std::string file;  ///< "rgb/000000.png"
};

std::vector<PosedPicture> posed_pictures(const ExportScene& scene, const ExportOptions& options) {
  std::vector<PosedPicture> result;
  for (const ExportPicture& picture : scene.pictures) {
    const ExportCamera camera = camera_of(scene, picture, options.true_cameras);
    result.push_back({&picture, camera.camera, handed_over(camera.camera, options),
                      pose_of(scene, picture, camera),
                      scene.capture.rig[picture.sensor].name + "/" +
                          six_digits(scene.capture.frames[picture.frame].id) +
                          picture_ending(picture, options)});
  }
  return result;
}

std::string who(const ExportScene& scene, const ExportPicture& picture) {
  return scene.folder.string() + " (frame " +
         std::to_string(scene.capture.frames[picture.frame].id) + "): sensor \"" +
         scene.capture.rig[picture.sensor].name + "\"";
}

/// Adds what helps to a lens that a format cannot hold.
[[noreturn]] void refuse_lens(const ExportScene& scene, const ExportPicture& picture,
                              const Camera& camera, const std::string& format) {
  throw std::invalid_argument(who(scene, picture) + " has the lens model " +
                              std::string(to_string(camera.model)) + ", which " + format +
                              " does not have; --undistort makes pinhole pictures");
}

void write_pictures(ExportJob& job, const std::vector<PosedPicture>& pictures, const fs::path& root,
                    const std::string& scene, int& done) {
  const int total = picture_count(job.scenes);
  for (const PosedPicture& p : pictures) {
    job.progress("pictures of " + scene, done++, total);
    write_picture(*p.picture, p.lens, p.camera, (root / p.file).replace_extension(), job.options);
  }
}

ColmapModel colmap_model(const ExportScene& scene, const std::vector<PosedPicture>& pictures) {
  ColmapModel model;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const PosedPicture& p = pictures[i];
    if (p.camera.model == LensModel::opencv12 ||
        p.camera.model == LensModel::splined_stereographic) {
      refuse_lens(scene, *p.picture, p.camera, "COLMAP");
    }
    int id = 0;  // cameras of equal numbers are one, from the last on: frames come in turn
    for (auto known = model.cameras.rbegin(); known != model.cameras.rend() && id == 0; ++known) {
      if (known->second == p.camera) id = known->first;
    }
    if (id == 0) {
      id = static_cast<int>(model.cameras.size()) + 1;
      model.cameras[id] = p.camera;
    }
    model.images[static_cast<int>(i) + 1] = {p.file, id, p.camera_from_world};
  }
  return model;
}

void write_model(const fs::path& folder, const ColmapFiles& files, const std::string& ending) {
  write_once(folder / ("cameras" + ending), files.cameras);
  write_once(folder / ("images" + ending), files.images);
  write_once(folder / ("points3D" + ending), files.points);
}

/// Intrinsics of transforms.json, which counts pixels from the image's corner.
Json nerfstudio_lens(const ExportScene& scene, const PosedPicture& p) {
  const Camera& c = p.camera;
  Json json = {{"fl_x", c.fx_px},     {"fl_y", c.fy_px}, {"cx", c.cx_px + 0.5},
               {"cy", c.cy_px + 0.5}, {"w", c.width_px}, {"h", c.height_px}};
  const std::array<double, 12>& d = c.distortion;
  if (c.model == LensModel::opencv5) {
    json.update({{"k1", d[0]}, {"k2", d[1]}, {"k3", d[4]}, {"p1", d[2]}, {"p2", d[3]}});
  } else if (c.model == LensModel::kannala_brandt4) {
    json.update({{"k1", d[0]}, {"k2", d[1]}, {"k3", d[2]}, {"k4", d[3]}});
  } else if (c.model != LensModel::pinhole) {
    refuse_lens(scene, *p.picture, c, "nerfstudio");
  }
  return json;
}

Json nerfstudio_file(const ExportScene& scene, const std::vector<PosedPicture>& pictures) {
  Json frames = Json::array();
  bool fisheye = false, flat = false;
  for (const PosedPicture& p : pictures) {
    (p.camera.model == LensModel::kannala_brandt4 ? fisheye : flat) = true;
    Json frame = {{"file_path", "images/" + p.file}};
    frame.update(nerfstudio_lens(scene, p));
    Eigen::Matrix4d m = to_matrix(inverse(p.camera_from_world));
    m.col(1) *= -1;  // OpenGL's y is up and its z backward
    m.col(2) *= -1;
    frame["transform_matrix"] = Json::array();
    for (Eigen::Index row = 0; row < 4; ++row)
      frame["transform_matrix"].push_back({m(row, 0), m(row, 1), m(row, 2), m(row, 3)});
    frames.push_back(frame);
  }
  if (fisheye && flat) {
    throw std::invalid_argument(scene.folder.string() +
                                ": fisheye and other lenses in one rig, but nerfstudio has one "
                                "camera_model a file; --undistort makes pinhole pictures");
  }
  return {{"camera_model", fisheye ? "OPENCV_FISHEYE" : "OPENCV"}, {"frames", frames}};
}

/// Depth as TUM has it: 5000 = 1 m. What does not fit into 16 bits, beyond 13.1 m, is none.
Image<std::uint16_t> tum_depth(const ExportDepth& depth) {
  Image<std::uint16_t> result(depth.depth.width(), depth.depth.height());
  for (std::size_t i = 0; i < result.size(); ++i) {
    const double value = std::round(depth.depth.data()[i] * depth.unit_m * 5000);
    result.data()[i] = value <= 65535 ? static_cast<std::uint16_t>(value) : std::uint16_t{0};
  }
  return result;
}

/// Lists and pictures of one scene.
struct TumLists {
  std::map<double, int> frame_at;  ///< by time
  std::string rgb = "# time file\n", depth = "# time file; 5000 = 1 m\n",
              poses = "# time tx ty tz qx qy qz qw: camera to world\n";
  bool has_depth = false, has_pose = false;
};

void add_to_lists(const ExportJob& job, const ExportScene& scene, const ExportPicture& picture,
                  const Camera& handed, const fs::path& folder, TumLists& lists) {
  const std::string stem = six_digits(scene.capture.frames[picture.frame].id);
  const ExportCamera camera = camera_of(scene, picture, job.options.true_cameras);
  const std::string time = exact_text(camera.time_s);
  const int frame = scene.capture.frames[picture.frame].id;
  const auto [known, is_new] = lists.frame_at.emplace(camera.time_s, frame);
  if (!is_new) {
    throw std::invalid_argument(who(scene, picture) + " has the time of frame " +
                                std::to_string(known->second) + ", " + time +
                                " s, and TUM tells pictures apart by their times");
  }
  write_picture(picture, camera.camera, handed, folder / "rgb" / stem, job.options);
  lists.rgb += time + " rgb/" + stem + picture_ending(picture, job.options) + "\n";
  const ExportDepth depth = depth_of(scene, picture, handed, job.options);
  if (!depth.depth.empty()) {
    fs::create_directories(folder / "depth");
    write_png(folder / "depth" / (stem + ".png"), tum_depth(depth));
    lists.depth += time + " depth/" + stem + ".png\n";
    lists.has_depth = true;
  }
  if (!camera.camera_from_world) return;
  const Pose world_from_camera = inverse(*camera.camera_from_world);
  const Eigen::Quaterniond& q = world_from_camera.rotation;
  const Eigen::Vector3d& t = world_from_camera.translation_m;
  lists.poses += time + " " + exact_text({t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()}) + "\n";
  lists.has_pose = true;
}

}  // namespace

void export_colmap(ExportJob& job) {
  int done = 0;
  for (const ExportScene& scene : job.scenes) {
    const fs::path folder = job.out / six_digits(scene.number);
    const std::vector<PosedPicture> pictures = posed_pictures(scene, job.options);
    const ColmapModel model = colmap_model(scene, pictures);
    write_pictures(job, pictures, folder / "images", six_digits(scene.number), done);
    write_model(folder / "sparse/0", colmap_binary(model), ".bin");
    write_model(folder / "sparse_txt", colmap_text(model), ".txt");
  }
}

void export_nerfstudio(ExportJob& job) {
  int done = 0;
  for (const ExportScene& scene : job.scenes) {
    const fs::path folder = job.out / six_digits(scene.number);
    const std::vector<PosedPicture> pictures = posed_pictures(scene, job.options);
    const Json file = nerfstudio_file(scene, pictures);
    write_pictures(job, pictures, folder / "images", six_digits(scene.number), done);
    write_once(folder / "transforms.json", to_text(file));
  }
}

void export_tum(ExportJob& job) {
  int done = 0;
  for (const ExportScene& scene : job.scenes) {
    const fs::path folder = job.out / six_digits(scene.number);
    const std::vector<const ExportPicture*> pictures = first_pictures(scene);
    TumLists lists;
    const Camera first = camera_of(scene, *pictures.front(), job.options.true_cameras).camera;
    const Camera handed = handed_over(first, job.options);  // of all: TUM has one lens a sequence
    for (const ExportPicture* picture : pictures) {
      job.progress("sequence " + six_digits(scene.number), done++, picture_count(job.scenes));
      const Camera lens = camera_of(scene, *picture, job.options.true_cameras).camera;
      if (!job.options.undistort && lens != first) {
        throw std::invalid_argument(who(scene, *picture) +
                                    " has another lens than the first frame's, and TUM has one a "
                                    "sequence; --undistort makes all those of one pinhole camera");
      }
      add_to_lists(job, scene, *picture, handed, folder, lists);
    }
    const CalibratedCamera camera{
        scene.capture.rig.front().name, handed_over(first, job.options), {}};
    write_once(folder / "camera.yaml", opencv_yaml(camera, camera));
    write_once(folder / "rgb.txt", lists.rgb);
    if (lists.has_depth) write_once(folder / "depth.txt", lists.depth);
    if (lists.has_pose) {
      write_once(folder / "groundtruth.txt", lists.poses);
    } else {
      job.warnings.push_back(six_digits(scene.number) +
                             ": no groundtruth.txt: the rig knows no poses; --true-cameras takes "
                             "the truth's");
    }
  }
}

}  // namespace cousin
