#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/camera_files.h"
#include "sim/dataset/categories.h"
#include "sim/dataset/export/export_dataset.h"
#include "sim/dataset/import.h"
#include "sim/geometry/mesh_io.h"
#include "sim/imaging/image_io.h"
#include "sim/imaging/undistort.h"
#include "tests/sim/dataset/sample_lenses.h"
#include "tests/sim/dataset/small_dataset.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;

/// A dataset and what is exported of it.
class Export : public testing::Test {
 protected:
  ExportSummary make(const std::string& format, const ExportOptions& options = {},
                     const std::string& out = "out") const {
    for (const ExportFormat& row : export_formats()) {
      if (row.name == format) {
        return export_dataset(folder_.path() / "data", row, options, folder_.path() / out, "test",
                              [](const std::string&, int, int) {});
      }
    }
    throw std::logic_error("no format " + format);
  }
  std::string refusal(const std::string& format, const ExportOptions& options = {},
                      const std::string& out = "refused") const {
    try {
      make(format, options, out);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  }
  void write(const SmallDataset& options) const {
    fs::remove_all(path("data"));
    write_small_dataset(path("data"), options);
  }
  fs::path path(const std::string& below) const { return folder_.path() / below; }
  json json_in(const std::string& below) const { return json::parse(read_file(path(below))); }
  std::map<std::string, std::string> contents(const std::string& below) const {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(path(below))) {
      if (entry.is_regular_file())
        files[fs::relative(entry.path(), path(below))] = read_file(entry.path());
    }
    return files;
  }

 private:
  TemporaryFolder folder_;
};

Camera distorted() {
  Camera camera = SmallDataset{}.camera;
  camera.model = LensModel::opencv5;
  camera.distortion = {-0.2, 0.03, 0.002, -0.001, 0.001};
  return camera;
}

// ---- labels -------------------------------------------------------------------------------------

TEST_F(Export, AClassHasTheSameNumberWhetherOrNotADatasetShowsIt) {
  write({});
  write_categories(path("data"), {"apple", "berry", "zea"});
  make("coco");
  const json coco = json_in("out/annotations/train.json");
  ASSERT_EQ(coco["categories"].size(), 3U);
  EXPECT_EQ(coco["categories"][1]["name"], "berry");
  EXPECT_EQ(coco["categories"][2]["id"], 3);
  EXPECT_EQ(coco["categories"][2]["keypoints"], json({"root", "node 1", "tip"}));
  EXPECT_EQ(coco["annotations"][1]["category_id"], 3);
  make("yolo", {}, "yolo");
  EXPECT_THAT(read_file(path("yolo/data.yaml")), HasSubstr("2: \"zea\""));
}

TEST_F(Export, CocoHasBoxesMasksKeypointsAndVisibleFractions) {
  write({});
  const ExportSummary summary = make("coco");
  EXPECT_EQ(summary.pictures, 2);
  EXPECT_THAT(summary.warnings, testing::ElementsAre(HasSubstr("val and test are empty")));
  const json coco = json_in("out/annotations/train.json");
  EXPECT_TRUE(coco["info"].is_object());  // pycocotools 2.0.9 reads no file without
  ASSERT_EQ(coco["images"].size(), 2U);
  EXPECT_EQ(coco["images"][1]["id"], 1);
  EXPECT_EQ(coco["images"][1]["file_name"], "000000_000001.png");
  EXPECT_EQ(read_file(path("out/images/train/000000_000001.png")),
            read_file(path("data/000000/rgb/000001.png")));
  // Categories in the order of their names, keypoints as the specimens have them.
  ASSERT_EQ(coco["categories"].size(), 2U);
  EXPECT_EQ(coco["categories"][0]["name"], "apple");
  EXPECT_EQ(coco["categories"][0]["keypoints"], json({"tip"}));
  EXPECT_EQ(coco["categories"][1]["id"], 2);
  EXPECT_EQ(coco["categories"][1]["keypoints"], json({"root", "node 1", "tip"}));
  ASSERT_EQ(coco["annotations"].size(), 4U);
  const json& ring = coco["annotations"][0];
  EXPECT_EQ(ring["instance_id"], 7);
  EXPECT_EQ(ring["category_id"], 1);
  EXPECT_EQ(ring["area"], 28);
  EXPECT_EQ(ring["bbox"], json({8, 5, 6, 5}));
  EXPECT_EQ(ring["visible_fraction"], 0.5);
  EXPECT_EQ(ring["segmentation"]["size"], json({30, 40}));
  EXPECT_EQ(ring["keypoints"], json({9.25, 6.5, 2}));  // pixels, whose centres are integers
  const json& bar = coco["annotations"][1];
  EXPECT_EQ(bar["keypoints"], json({20.0, 29.0, 1, 0, 0, 0, 20.125, 12.25, 2}));
  EXPECT_EQ(bar["num_keypoints"], 2);
  EXPECT_EQ(bar["bbox"], json({10, 7, 11, 23}));
  EXPECT_EQ(coco["annotations"][3]["id"], 4);
}

TEST_F(Export, PicturesOfAllColourSensorsHaveTheirOwnLabels) {
  write({});
  make("coco", {}, "one");
  write({.has_right = true});
  make("coco");
  const json one = json_in("one/annotations/train.json"),
             two = json_in("out/annotations/train.json");
  ASSERT_EQ(two["images"].size(), 4U);
  ASSERT_EQ(two["annotations"].size(), 8U);
  EXPECT_EQ(two["images"][1]["file_name"], "000000_000001.png");
  EXPECT_FALSE(two["images"][1].contains("sensor"));
  EXPECT_EQ(two["images"][3]["id"], 1'000'000'000'001);
  EXPECT_EQ(two["images"][3]["file_name"], "000000_000001_right.png");
  EXPECT_EQ(two["images"][3]["sensor"], "right");
  EXPECT_EQ(read_file(path("out/images/train/000000_000001_right.png")),
            read_file(path("data/000000/right/000001.png")));
  const json& ring = two["annotations"][4];
  EXPECT_EQ(ring["image_id"], 1'000'000'000'000);
  EXPECT_EQ(ring["bbox"], json({10, 5, 6, 5}));
  EXPECT_EQ(ring["visible_fraction"], 0.25);
  EXPECT_EQ(ring["keypoints"], json({11.25, 6.5, 2}));
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_EQ(one["annotations"][i]["bbox"], two["annotations"][i]["bbox"]);
  make("yolo", {}, "yolo");
  EXPECT_THAT(read_file(path("yolo/labels/train/000000_000000_right.txt")),
              HasSubstr("0 0.325 0.25 "));
  make("bop", {}, "bop");  // has one camera a scene
  EXPECT_EQ(json_in("bop/train/000000/scene_camera.json").size(), 2U);
}

TEST_F(Export, ALabelOfTheSpecimensIsTheCategoryIfAsked) {
  write({.has_labels = true});
  make("coco");
  const json own = json_in("out/annotations/train.json");
  EXPECT_EQ(own["categories"][0]["name"], "apple");
  EXPECT_EQ(own["annotations"][0]["attributes"]["maturity"], "low");
  EXPECT_EQ(own["annotations"][0]["attributes"]["variety"], "fuji");
  EXPECT_FALSE(json_in("out/export.json")["options"].contains("category"));
  make("coco", {.category = "maturity"}, "maturity");
  const json maturity = json_in("maturity/annotations/train.json");
  EXPECT_EQ(maturity["categories"][0]["name"], "high");
  EXPECT_EQ(maturity["categories"][0]["keypoints"], json({"root", "node 1", "tip"}));
  EXPECT_EQ(maturity["annotations"][0]["instance_id"], 7);
  EXPECT_EQ(maturity["annotations"][0]["category_id"], 2);
  make("yolo", {.category = "variety"}, "yolo");
  EXPECT_THAT(read_file(path("yolo/data.yaml")),
              AllOf(HasSubstr("0: \"fuji\""), testing::Not(HasSubstr("1: "))));
  make("bop", {}, "bop");
  EXPECT_EQ(json_in("bop/models/models_info.json")["1"]["category"], "fuji");
}

TEST_F(Export, ALabelThatNoSpecimenHasIsRefusedByName) {
  write({});
  try {
    make("coco", {.category = "variety"});
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("scene.json: \"i7\""), HasSubstr("\"variety\""),
                                    HasSubstr("its labels: none")));
  }
}

TEST_F(Export, CocoPolygonsAndTheLeastVisibleFraction) {
  write({});
  make("coco", {.masks = MaskCode::polygon, .least_visible = 0.6});
  const json coco = json_in("out/annotations/train.json");
  ASSERT_EQ(coco["annotations"].size(), 2U);  // the ring is half hidden
  EXPECT_EQ(coco["annotations"][0]["instance_id"], 9);
  EXPECT_EQ(coco["annotations"][0]["segmentation"],
            json({{10, 7, 11, 7, 11, 8, 10, 8}, {20, 12, 21, 12, 21, 30, 20, 30}}));
}

TEST_F(Export, YoloHasATaskEachFromTheImagesCorner) {
  write({});
  make("yolo");
  const std::string boxes = read_file(path("out/labels/train/000000_000000.txt"));
  EXPECT_EQ(boxes, "0 0.275 0.25 0.15 0.16666666666666666\n" +
                       std::string("1 0.3875 0.6166666666666667 0.275 0.7666666666666667\n"));
  EXPECT_THAT(
      read_file(path("out/data.yaml")),
      AllOf(HasSubstr("train: images/train\n"), HasSubstr("\nval: images/train  # there are no"),
            testing::Not(HasSubstr("path:")), HasSubstr("0: \"apple\""), HasSubstr("1: \"zea\"")));
  make("yolo", {.task = YoloTask::pose}, "pose");
  const std::string pose = read_file(path("pose/labels/train/000000_000000.txt"));
  // Three keypoints of all classes: tip, root, node 1. The centre of pixel 9.25 is at 9.75 / 40.
  EXPECT_THAT(pose, HasSubstr("0 0.275 0.25 0.15 0.16666666666666666 0.24375 "
                              "0.23333333333333334 2 0 0 0 0 0 0\n"));
  EXPECT_THAT(pose, HasSubstr(" 2 0.5125 0.9833333333333333 1 0 0 0\n"));
  EXPECT_THAT(read_file(path("pose/data.yaml")),
              AllOf(HasSubstr("kpt_shape: [3, 3]"), HasSubstr("flip_idx: [0, 1, 2]"),
                    HasSubstr("[\"tip\",\"root\",\"node 1\"]")));
  make("yolo", {.task = YoloTask::segment}, "segment");
  // One polygon an object: the ring's corners, its hole's, and the cut between them.
  const std::string segments = read_file(path("segment/labels/train/000000_000000.txt"));
  const std::string ring = segments.substr(0, segments.find('\n'));
  EXPECT_THAT(ring, testing::StartsWith("0 0.2 0.16666666666666666 "));
  EXPECT_EQ(std::count(ring.begin(), ring.end(), ' '), 2 * (4 + 4 + 2));
}

TEST_F(Export, SplitsAreByScene) {
  write({.scenes = 6});
  make("yolo", {.split = {0.5, 0.25, 0.25}});
  std::map<std::string, std::set<std::string>> scenes_of;
  for (const auto& [file, bytes] : contents("out")) {
    if (!file.starts_with("labels/")) continue;
    scenes_of[fs::path(file).filename().string().substr(0, 6)].insert(fs::path(file).parent_path());
  }
  EXPECT_EQ(scenes_of.size(), 6U);
  std::set<std::string> sides;
  for (const auto& [scene, folders] : scenes_of) {
    EXPECT_EQ(folders.size(), 1U) << scene;
    sides.insert(folders.begin(), folders.end());
  }
  EXPECT_EQ(sides.size(), 3U);
}

/// Readers insist on train and val.
TEST_F(Export, YoloAlwaysNamesFoldersForTrainAndVal) {
  const auto yaml = [&](int scenes, const std::array<double, 3>& split, const std::string& out) {
    write({.scenes = scenes});
    const ExportSummary summary = make("yolo", {.split = split}, out);
    return std::pair(read_file(path(out + "/data.yaml")), summary.warnings);
  };
  const auto [two, said_of_two] = yaml(2, {0.8, 0.1, 0.1}, "two");
  EXPECT_THAT(two, AllOf(HasSubstr("train: images/train\n"), HasSubstr("\nval: images/val\n"),
                         testing::Not(HasSubstr("test:"))));
  EXPECT_THAT(said_of_two, testing::ElementsAre(HasSubstr("test is empty")));
  EXPECT_TRUE(fs::is_directory(path("two/images/val")));
  const auto [one, said_of_one] = yaml(1, {0.8, 0.1, 0.1}, "one");
  EXPECT_THAT(one, HasSubstr("\nval: images/train  # there are no pictures for val alone\n"));
  EXPECT_THAT(said_of_one, testing::ElementsAre(HasSubstr("val and test are empty"),
                                                HasSubstr("data.yaml names images/train for val")));
  const auto [no_val, said] = yaml(2, {0.5, 0, 0.5}, "no_val");
  EXPECT_THAT(no_val, HasSubstr("\nval: images/test  #"));
  EXPECT_THAT(said, testing::ElementsAre(HasSubstr("data.yaml names images/test for val")));
}

/// The types that bop_toolkit's load_ply knows are float, double, int and uchar.
TEST_F(Export, BopModelsHaveTheTypesThatItsToolkitReads) {
  write({});
  make("bop", {});
  const std::string ply = read_file(path("out/models/obj_000001.ply"));
  const std::string header = ply.substr(0, ply.find("end_header"));
  EXPECT_THAT(header, AllOf(HasSubstr("property list uchar int vertex_indices"),
                            testing::Not(HasSubstr("uint"))));
  EXPECT_EQ(read_mesh(path("out/models/obj_000001.ply")).triangles.size(), 4U);
}

TEST_F(Export, TumRefusesPicturesOfOneTime) {
  write({});
  for (const char* file : {"data/000000/scene_camera.json"}) {
    json cameras = json_in(file);
    cameras["1"]["cousin"]["time_s"] = cameras["0"]["cousin"]["time_s"];
    write_file(path(file), cameras.dump());
  }
  EXPECT_THAT(refusal("tum"), AllOf(HasSubstr("frame 1"), HasSubstr("the time of frame 0")));
}

TEST_F(Export, LabelsThatWereNotRenderedAreNamed) {
  write({.has_truth = false});
  EXPECT_THAT(refusal("coco"), AllOf(HasSubstr("data/000000"), HasSubstr("no truth/")));
  write({});
  fs::remove_all(path("data/000000/truth/instance"));
  EXPECT_THAT(refusal("coco", {}, "b"), HasSubstr("--truth visibility,instance"));
  EXPECT_THAT(refusal("bop", {}, "c"), HasSubstr("--truth visibility,instance"));
}

/// Labels of an undistorted picture lie where its pixels went.
TEST_F(Export, UndistortedLabelsGoWithTheirPixels) {
  write({.camera = distorted()});
  make("coco", {.undistort = true, .masks = MaskCode::polygon});
  const json coco = json_in("out/annotations/train.json");
  const Camera lens = distorted();
  const Camera pinhole = undistorted_camera(lens);
  const Image<Rgb8> taken = read_color(path("data/000000/rgb/000000.png"));
  EXPECT_EQ(read_color(path("out/images/train/000000_000000.png")), undistort(taken, lens).image);
  const Eigen::Vector2d tip = *project(pinhole, *unproject(lens, {9.25, 6.5}));
  const json& keypoints = coco["annotations"][0]["keypoints"];
  EXPECT_NEAR(keypoints[0], tip.x(), 1e-9);
  EXPECT_NEAR(keypoints[1], tip.y(), 1e-9);
  // The box's corner, pixel (8, 5), lands to within the rounding of a pixel.
  const Eigen::Vector2d corner = *project(pinhole, *unproject(lens, {8, 5}));
  EXPECT_NEAR(coco["annotations"][0]["bbox"][0], corner.x(), 1);
  EXPECT_NEAR(coco["annotations"][0]["bbox"][1], corner.y(), 1);
}

// ---- BOP ----------------------------------------------------------------------------------------

TEST_F(Export, BopHasTrueCamerasAndMillimetres) {
  write({.scenes = 3, .has_depth = true});
  make("bop");
  std::string test_scene;
  for (const char* split : {"train", "val", "test"}) {
    for (const auto& entry : fs::directory_iterator(path("out") / split)) {
      const std::string scene = entry.path().filename();
      if (std::string(split) == "test") test_scene = scene;
      const std::string base = "out/" + std::string(split) + "/" + scene + "/";
      const json camera = json_in(base + "scene_camera.json")["1"];
      const json true_camera = json_in("data/" + scene + "/truth/camera.json")["views"][1];
      EXPECT_EQ(camera["cam_K"][0], true_camera["camera"]["fx_px"]);
      EXPECT_EQ(camera["depth_scale"], 1);
      // Where the pose puts the object, in millimetres, is where truth puts it, in metres.
      const json gt = json_in(base + "scene_gt.json")["1"][1];
      EXPECT_EQ(gt["instance_id"], 9);
      const Eigen::Vector3d t(gt["cam_t_m2c"][0], gt["cam_t_m2c"][1], gt["cam_t_m2c"][2]);
      const json truth_gt = json_in("data/" + scene + "/truth/scene_gt.json")["1"][1];
      EXPECT_NEAR(t.x(), truth_gt["cam_t_m2c"][0], 1e-9);
      const json info = json_in(base + "scene_gt_info.json")["1"][1];
      EXPECT_EQ(info["px_count_all"], 19);
      EXPECT_EQ(info["px_count_valid"], 19);
      EXPECT_EQ(info["visib_fract"], 1);
      EXPECT_EQ(read_png8(path(base + "mask_visib/000001_000001.png"))(11, 7), 255);
      EXPECT_EQ(read_png16(path(base + "depth/000001.png"))(3, 4), 1500);
    }
  }
  // Two instances of each scene share a mesh's bytes, so a scene has one object.
  const json models = json_in("out/models/models_info.json");
  EXPECT_EQ(models.size(), 3U);
  EXPECT_NEAR(models["1"]["size_x"], 10, 1e-12);
  EXPECT_NEAR(models["1"]["diameter"], std::hypot(10, 10 / 3.0), 1e-9);
  EXPECT_NEAR(read_mesh(path("out/models/obj_000001.ply")).vertices_m[1].x(), 10, 1e-12);
  for (const json& target : json_in("out/test_targets_bop19.json")) {
    EXPECT_EQ(target["scene_id"], std::stoi(test_scene));
    EXPECT_EQ(target["inst_count"], 2);
  }
}

TEST_F(Export, BopRefusesALensByNameUnlessUndistorted) {
  write({.camera = distorted()});
  EXPECT_THAT(refusal("bop"),
              AllOf(HasSubstr("\"rgb\""), HasSubstr("opencv5"), HasSubstr("--undistort")));
  EXPECT_FALSE(fs::exists(path("refused")));
  make("bop", {.undistort = true});
  const json camera = json_in("out/train/000000/scene_camera.json")["0"];
  EXPECT_EQ(camera["cam_K"][0], distorted().fx_px + 1);  // the true one
}

// ---- posed pictures -----------------------------------------------------------------------------

/// The dataset's own cameras and poses beside what another program's format gives back.
void expect_same_views(const Capture& dataset, const Capture& back) {
  ASSERT_EQ(back.frames.size(), dataset.frames.size());
  for (std::size_t f = 0; f < back.frames.size(); ++f) {
    const Frame &a = dataset.frames[f], &b = back.frames[f];
    EXPECT_LE(largest_difference_px(a.sensors[0].reported, b.sensors[0].reported), 1e-9);
    const Pose camera_from_world = dataset.rig[0].sensor_from_rig * *a.rig_from_world;
    const Pose difference = camera_from_world * inverse(*b.rig_from_world);
    EXPECT_LT(angle_rad(difference.rotation), 1e-14);
    EXPECT_LT(difference.translation_m.norm(), 1e-14);
    EXPECT_EQ(a.sensors[0].color, b.sensors[0].color);
  }
}

TEST_F(Export, ColmapNerfstudioAndTumComeBackAsTheyWere) {
  for (const Camera& camera : {SmallDataset{}.camera, distorted()}) {
    write({.camera = camera, .has_depth = true});
    const std::string name(to_string(camera.model));
    const Capture dataset = read_capture(path("data/000000"));
    make("colmap", {}, "colmap_" + name);
    expect_same_views(dataset, import_colmap(path("colmap_" + name + "/000000")));
    fs::remove_all(path("colmap_" + name + "/000000/sparse"));  // leaves the text
    expect_same_views(dataset, import_colmap(path("colmap_" + name + "/000000")));
    make("nerfstudio", {}, "nerf_" + name);
    expect_same_views(dataset, import_nerfstudio(path("nerf_" + name + "/000000/transforms.json")));
    make("tum", {}, "tum_" + name);
    const Capture tum = import_tum(path("tum_" + name + "/000000"), "");
    expect_same_views(dataset, tum);
    EXPECT_EQ(tum.frames[1].time_s, dataset.frames[1].time_s);
    EXPECT_EQ(tum.frames[1].sensors[0].depth, Image<std::uint16_t>(40, 30, 7500));  // 1.5 m
  }
}

/// The first record of a text file, as words.
std::vector<std::string> first_record(const std::string& text) {
  std::istringstream lines(text);
  std::string line;
  while (std::getline(lines, line) && (line.empty() || line[0] == '#')) {
  }
  std::istringstream words(line);
  return {std::istream_iterator<std::string>(words), {}};
}

Eigen::Matrix3d rotation(const std::vector<std::string>& words,
                         const std::array<std::size_t, 4>& wxyz) {
  const auto number = [&](std::size_t i) { return std::stod(words.at(i)); };
  return Eigen::Quaterniond(number(wxyz[0]), number(wxyz[1]), number(wxyz[2]), number(wxyz[3]))
      .toRotationMatrix();
}

Eigen::Vector3d vector_at(const std::vector<std::string>& words, std::size_t first) {
  return {std::stod(words.at(first)), std::stod(words.at(first + 1)),
          std::stod(words.at(first + 2))};
}

/// A dot in the centre of pixel (12, 7), by each format's own formula and none of our readers.
/// Formats that count from the image's corner find it at (12.5, 7.5).
TEST_F(Export, ADotIsWhereEachFormatsOwnFormulaPutsIt) {
  write({});
  const Capture dataset = read_capture(path("data/000000"));
  const Pose camera_from_world = dataset.rig[0].sensor_from_rig * *dataset.frames[0].rig_from_world;
  const Eigen::Vector3d dot =
      inverse(camera_from_world) *
      Eigen::Vector3d(3 * *unproject(dataset.frames[0].sensors[0].reported, {12, 7}));
  constexpr double kRounding_px = 1e-10;
  const Eigen::Vector2d centre(12, 7), corner(12.5, 7.5);

  make("colmap", {}, "colmap");
  const auto camera = first_record(read_file(path("colmap/000000/sparse_txt/cameras.txt")));
  const auto image = first_record(read_file(path("colmap/000000/sparse_txt/images.txt")));
  EXPECT_EQ(camera.at(1), "PINHOLE");
  EXPECT_EQ(image.at(9), "rgb/000000.png");
  const Eigen::Vector3d c = rotation(image, {1, 2, 3, 4}) * dot + vector_at(image, 5);
  const Eigen::Vector2d colmap(std::stod(camera[4]) * c.x() / c.z() + std::stod(camera[6]),
                               std::stod(camera[5]) * c.y() / c.z() + std::stod(camera[7]));
  EXPECT_LT((colmap - corner).norm(), kRounding_px);

  make("nerfstudio", {}, "nerf");
  const json frame = json_in("nerf/000000/transforms.json")["frames"][0];
  Eigen::Matrix4d world_from_camera;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column)
      world_from_camera(row, column) = frame["transform_matrix"][row][column];
  }
  const Eigen::Vector4d n = world_from_camera.inverse() * dot.homogeneous();  // y up, z back
  const Eigen::Vector2d nerf(
      frame["cx"].get<double>() - frame["fl_x"].get<double>() * n.x() / n.z(),
      frame["cy"].get<double>() + frame["fl_y"].get<double>() * n.y() / n.z());
  EXPECT_LT((nerf - corner).norm(), kRounding_px);

  make("tum", {}, "tum");
  const auto pose = first_record(read_file(path("tum/000000/groundtruth.txt")));
  const Eigen::Vector3d t =
      rotation(pose, {7, 4, 5, 6}).transpose() * (dot - vector_at(pose, 1));  // camera to world
  const Camera k = SmallDataset{}.camera;
  const Eigen::Vector2d tum(k.fx_px * t.x() / t.z() + k.cx_px, k.fy_px * t.y() / t.z() + k.cy_px);
  EXPECT_LT((tum - centre).norm(), kRounding_px);

  make("bop", {}, "bop");
  const json bop = json_in("bop/train/000000/scene_camera.json")["0"];
  const TrueView view = read_truth(path("data/000000")).views[0];
  const Eigen::Vector3d true_dot_mm =
      1000 *
      (inverse(view.camera_from_world) * Eigen::Vector3d(3 * *unproject(view.camera, {12, 7})));
  const std::vector<double> r = bop["cam_R_w2c"], shift = bop["cam_t_w2c"], m = bop["cam_K"];
  const Eigen::Vector3d b =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(m.data()) *
      (Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(r.data()) * true_dot_mm +
       Eigen::Vector3d(shift.data()));
  EXPECT_LT((b.hnormalized() - centre).norm(), kRounding_px);
}

TEST_F(Export, PosesThatTheRigDoesNotKnowAreTheTruthsOrRefused) {
  write({.knows_poses = false});
  for (const char* format : {"colmap", "nerfstudio"}) {
    EXPECT_THAT(refusal(format, {}, std::string("no_") + format),
                AllOf(HasSubstr("has no pose"), HasSubstr("--true-cameras")));
  }
  EXPECT_THAT(make("tum", {}, "no_tum").warnings,
              testing::ElementsAre(HasSubstr("no groundtruth.txt")));
  make("colmap", {.true_cameras = true});
  const Capture back = import_colmap(path("out/000000"));
  const SceneTruth truth = read_truth(path("data/000000"));
  EXPECT_TRUE(same_pose(*back.frames[1].rig_from_world, truth.views[1].camera_from_world));
  EXPECT_EQ(back.frames[1].sensors[0].reported.fx_px, truth.views[1].camera.fx_px);
  write({.has_truth = false});
  EXPECT_THAT(refusal("colmap", {.true_cameras = true}, "d"), HasSubstr("there is no truth/"));
}

TEST_F(Export, ALensThatAFormatCannotHoldIsRefusedByName) {
  Camera camera = SmallDataset{}.camera;
  camera.model = LensModel::opencv12;
  camera.distortion = {0.05, 0.01, 1e-3, 1e-3, 0, 0, 0, 0, 1e-3, 0, 1e-3, 0};
  write({.camera = camera});
  for (const char* format : {"colmap", "nerfstudio"}) {
    EXPECT_THAT(refusal(format, {}, std::string("r_") + format),
                AllOf(HasSubstr("opencv12"), HasSubstr("\"rgb\""), HasSubstr("--undistort")));
    make(format, {.undistort = true}, format);
  }
  EXPECT_EQ(import_colmap(path("colmap/000000")).frames[0].sensors[0].reported.model,
            LensModel::pinhole);
  EXPECT_THAT(refusal("ros", {}, "ros"),
              AllOf(HasSubstr("data/000000"), HasSubstr("opencv12"), HasSubstr("--undistort")));
  EXPECT_THAT(refusal("kalibr", {}, "kalibr"), HasSubstr("opencv12"));
  make("opencv");
  EXPECT_LE(largest_difference_px(
                camera, camera_from_yaml(read_file(path("out/000000/rgb.yaml")), "rgb.yaml")),
            1e-9);
}

/// An autofocus changes the lens from frame to frame.
TEST_F(Export, LensesThatChangeAreAFileAFrameOrOnePinholeCamera) {
  write({.camera = distorted(), .focus_step_px = 2});
  EXPECT_THAT(refusal("tum"), AllOf(HasSubstr("frame 1"), HasSubstr("--undistort")));
  make("tum", {.undistort = true});
  const Capture tum = import_tum(path("out/000000"), "");
  const Capture dataset = read_capture(path("data/000000"));
  Camera second = distorted();
  second.fx_px += 2;
  EXPECT_EQ(dataset.frames[1].sensors[0].reported, second);
  const Camera pinhole = undistorted_camera(distorted());
  EXPECT_LE(largest_difference_px(tum.frames[1].sensors[0].reported, pinhole), 1e-9);
  EXPECT_EQ(tum.frames[1].sensors[0].color,
            undistort(dataset.frames[1].sensors[0].color, second, {.pinhole = pinhole}).image);
  EXPECT_THAT(make("ros", {}, "ros").warnings, testing::ElementsAre(HasSubstr("a file for each")));
  EXPECT_EQ(camera_from_yaml(read_file(path("ros/000000/rgb_000001.yaml")), "y").fx_px,
            second.fx_px);
}

TEST_F(Export, CalibrationsAreTheReportedOnesOrTheTrue) {
  write({});
  make("mrcal");
  const CalibratedCamera reported =
      camera_from_mrcal(read_file(path("out/000000/rgb.cameramodel")), "m");
  EXPECT_EQ(reported.camera, SmallDataset{}.camera);
  make("kalibr", {.true_cameras = true}, "true");
  const auto cameras =
      cameras_from_kalibr(read_file(path("true/000000/camchain.yaml")), "camchain.yaml");
  EXPECT_EQ(cameras.at(0).camera.fx_px, SmallDataset{}.camera.fx_px + 1);
}

// ---- folders ------------------------------------------------------------------------------------

TEST_F(Export, AgainChangesNothingAndAnotherFolderIsAskedForAnythingElse) {
  write({.scenes = 3});
  for (const ExportFormat& format : export_formats()) {
    const std::string out = "same_" + format.name;
    {
      const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
      make(format.name, {}, out);
    }
    const auto first = contents(out);
    make(format.name, {}, out);
    EXPECT_EQ(contents(out), first) << format.name;
    make(format.name, {}, "other_" + format.name);
    EXPECT_EQ(contents("other_" + format.name), first) << format.name;
    // As if it had been stopped: what is there stays, the rest is made.
    fs::rename(path(out) / "export.json", path(out) / "partial.json");
    for (const auto& [file, bytes] : first) {
      const bool is_list = file.starts_with(".cousin.");  // kept until the end
      if (file != "export.json" && !is_list && file.size() % 2 == 0) fs::remove(path(out) / file);
    }
    make(format.name, {}, out);
    EXPECT_EQ(contents(out), first) << format.name;
  }
  EXPECT_THAT(refusal("coco", {.undistort = true}, "same_coco"),
              AllOf(HasSubstr("same_coco/export.json"), HasSubstr("choose another --out")));
  EXPECT_THAT(refusal("yolo", {}, "same_coco"), HasSubstr("choose another --out"));
  EXPECT_THAT(refusal("coco", {}, "data"), HasSubstr("choose another --out"));
}

}  // namespace
}  // namespace cousin
