#include "sim/dataset/import.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/capture_io.h"
#include "sim/imaging/image_io.h"
#include "tests/places/places.h"
#include "tests/sim/dataset/sample_capture.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

const fs::path kMultiview = real_data() / "multiview";

// ---- nerfstudio ---------------------------------------------------------------------------------

/// A camera 2 m above the origin that looks down, world x to the right: OpenGL axes are the
/// world's.
std::string transforms(const std::string& intrinsics, const std::string& image = "images/a.png") {
  return R"({)" + intrinsics + R"(, "frames": [{"file_path": ")" + image + R"(", "sharpness": 1.5,
    "transform_matrix": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 2], [0, 0, 0, 1]]}]})";
}
const std::string kIntrinsics = R"("fl_x": 30, "fl_y": 31, "cx": 10, "cy": 6, "w": 20.0, "h": 12)";

TEST(ImportNerfstudio, TurnsOpenGlAxesAndCornerBasedCentres) {
  const NerfstudioFile file = parse_nerfstudio(transforms(kIntrinsics), "t.json");
  ASSERT_EQ(file.frames.size(), 1U);
  const Camera& camera = file.frames[0].camera;
  EXPECT_EQ(camera.model, LensModel::pinhole);
  EXPECT_EQ(camera.cx_px, 9.5);
  EXPECT_EQ(camera.cy_px, 5.5);
  EXPECT_EQ(camera.width_px, 20);
  // World x is right and y is up in the image; the origin is 2 m in front.
  const auto pixel = [&](double x, double y) {
    return *project(camera, file.frames[0].camera_from_world * Eigen::Vector3d(x, y, 0));
  };
  EXPECT_TRUE(pixel(0, 0).isApprox(Eigen::Vector2d(9.5, 5.5), 1e-12));
  EXPECT_TRUE(pixel(0.2, 0).isApprox(Eigen::Vector2d(12.5, 5.5), 1e-12));
  EXPECT_TRUE(pixel(0, 0.2).isApprox(Eigen::Vector2d(9.5, 2.4), 1e-12));
  EXPECT_THAT(file.warnings, testing::IsEmpty());
}

TEST(ImportNerfstudio, LensKeysBecomeTheRightModel) {
  const auto camera = [&](const std::string& more) {
    return parse_nerfstudio(transforms(kIntrinsics + more), "t.json").frames[0].camera;
  };
  const Camera brown = camera(R"(, "k1": 0.01, "k2": 0.02, "p1": 0.003, "p2": 0.004, "k3": 0.005)");
  EXPECT_EQ(brown.model, LensModel::opencv5);
  EXPECT_EQ(brown.distortion, (std::array<double, 12>{0.01, 0.02, 0.003, 0.004, 0.005}));
  const Camera fisheye = camera(
      R"(, "k1": 0.01, "k2": 0.02, "k3": 0.003, "k4": 0.004, "camera_model": "OPENCV_FISHEYE")");
  EXPECT_EQ(fisheye.model, LensModel::kannala_brandt4);
  EXPECT_EQ(fisheye.distortion, (std::array<double, 12>{0.01, 0.02, 0.003, 0.004}));
  // Half of 20 px at half of 90 degrees.
  const std::string angle = R"("camera_angle_x": 1.5707963267948966, "w": 20, "h": 12)";
  EXPECT_NEAR(parse_nerfstudio(transforms(angle), "t.json").frames[0].camera.fx_px, 10, 1e-12);
}

TEST(ImportNerfstudio, UnknownKeysAreNamedOnce) {
  const NerfstudioFile file =
      parse_nerfstudio(transforms(kIntrinsics + R"(, "mystery": 1)"), "t.json");
  EXPECT_THAT(file.warnings, testing::ElementsAre(HasSubstr("\"mystery\"")));
}

TEST(ImportNerfstudio, WrongFilesAreErrorsWithKeyAndFrame) {
  const auto error = [](const std::string& text) {
    return error_of([&] { parse_nerfstudio(text, "t.json"); });
  };
  EXPECT_THAT(error("{"), HasSubstr("t.json: not JSON"));
  EXPECT_THAT(error("[]"), HasSubstr("is not an object"));
  EXPECT_THAT(error("{}"), HasSubstr("lacks the key \"frames\""));
  EXPECT_THAT(error(transforms(R"("fl_x": 0, "cx": 10, "cy": 6, "w": 20, "h": 12)")),
              AllOf(HasSubstr("fl_x"), HasSubstr("frame 0")));
  EXPECT_THAT(error(transforms(R"("fl_x": "30", "w": 20, "h": 12)")),
              HasSubstr("/fl_x = \"30\" is not a number"));
  EXPECT_THAT(error(transforms(R"("fl_x": 30, "w": 20.5, "h": 12)")), HasSubstr("/w"));
  EXPECT_THAT(error(transforms(kIntrinsics + R"(, "k1": -30)")),
              HasSubstr("folds inside the image"));
  EXPECT_THAT(error(transforms(kIntrinsics + R"(, "k4": 0.1)")), HasSubstr("/k4"));
  EXPECT_THAT(error(transforms(kIntrinsics + R"(, "camera_model": "EQUIRECTANGULAR")")),
              HasSubstr("/camera_model"));
  EXPECT_THAT(
      error(R"({"fl_x": 30, "w": 20, "h": 12, "frames": [{"file_path": "a", "transform_matrix":
                     [[2, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 2], [0, 0, 0, 1]]}]})"),
      AllOf(HasSubstr("/frames/0/transform_matrix"), HasSubstr("not a rotation")));
  EXPECT_THAT(error(
                  R"({"fl_x": 30, "w": 20, "h": 12, "frames":
              [{"file_path": "a", "transform_matrix": [[1, 0, 0]]}]})"),
              HasSubstr("/frames/0/transform_matrix"));
}

TEST(ImportNerfstudio, ImagesStayInsideTheFolder) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "transforms.json";
  const auto error = [&](const std::string& image) {
    write_file(file, transforms(kIntrinsics, image));
    return error_of([&] { import_nerfstudio(file); });
  };
  EXPECT_THAT(error("../secret.png"), HasSubstr("\"..\""));
  EXPECT_THAT(error("/etc/passwd"), HasSubstr("absolute"));
  EXPECT_THAT(error("images/absent.png"), HasSubstr("none of the listed images"));
  fs::create_directories(folder.path() / "images");
  write_png(folder.path() / "images/a.png", Image<Rgb8>(21, 12));
  EXPECT_THAT(error("images/a.png"),
              AllOf(HasSubstr("a.png"), HasSubstr("frame 0"), HasSubstr("21 x 12")));
}

TEST(ImportNerfstudio, FoxSkipsTheSeventeenAbsentImages) {
  const fs::path file = kMultiview / "instantngp_fox" / "transforms.json";
  if (!fs::exists(file)) GTEST_SKIP() << "no real data at " << file;
  const Capture capture = import_nerfstudio(file);
  EXPECT_EQ(capture.frames.size(), 50U);
  EXPECT_EQ(
      std::count_if(capture.warnings.begin(), capture.warnings.end(),
                    [](const std::string& w) { return w.find("is skipped") != std::string::npos; }),
      17);
  const SensorFrame& sensor = capture.frames[0].sensors[0];
  EXPECT_EQ(sensor.reported.model, LensModel::opencv5);
  EXPECT_EQ(sensor.reported.cx_px, 554.558 - 0.5);
  EXPECT_EQ(sensor.color.height(), 1920);
  // The cameras stand around the fox: their axes nearly meet, in front of every camera.
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const Frame& frame : capture.frames) {
    const Eigen::Vector3d axis =
        frame.rig_from_world->rotation.conjugate() * Eigen::Vector3d::UnitZ();
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - axis * axis.transpose();
    a += across;
    b += across * centre_in_world_m(*frame.rig_from_world);
  }
  const Eigen::Vector3d focus = a.ldlt().solve(b);
  for (const Frame& frame : capture.frames) EXPECT_GT((*frame.rig_from_world * focus).z(), 1.0);
}

// ---- phenomenal ---------------------------------------------------------------------------------

struct CarvedPlant {
  const char* name;
  const char* voxels;  ///< the carving's file
};
class Phenomenal : public testing::TestWithParam<CarvedPlant> {};

/// Whether the bounding box of a voxel's eight projected corners shows a pixel of the silhouette:
/// phenomenal's rule.
bool touches_silhouette(const Frame& frame, const Eigen::Vector3d& centre_m, double voxel_m) {
  const SensorFrame& sensor = frame.sensors[0];
  Eigen::Array2d low = Eigen::Array2d::Constant(1e9), high = -low;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d side((corner & 1) != 0 ? 0.5 : -0.5, (corner & 2) != 0 ? 0.5 : -0.5,
                               (corner & 4) != 0 ? 0.5 : -0.5);
    const auto pixel = project(sensor.reported,
                               *frame.rig_from_world * Eigen::Vector3d(centre_m + voxel_m * side));
    if (!pixel) return false;
    low = low.min(pixel->array());
    high = high.max(pixel->array());
  }
  for (int y = static_cast<int>(std::floor(low.y())); y <= static_cast<int>(std::ceil(high.y()));
       ++y) {
    for (int x = static_cast<int>(std::floor(low.x())); x <= static_cast<int>(std::ceil(high.x()));
         ++x) {
      if (sensor.color.contains(x, y) && sensor.color(x, y).r == 255) return true;
    }
  }
  return false;
}

/// Share of at most 20000 voxels that touch the silhouette in every view, or in all but one.
double consistent_share(const Capture& capture, const VoxelCarving& carving) {
  const std::size_t step = std::max<std::size_t>(1, carving.centres_m.size() / 20000);
  std::size_t consistent = 0, count = 0;
  for (std::size_t i = 0; i < carving.centres_m.size(); i += step, ++count) {
    int misses = 0;
    for (const Frame& frame : capture.frames)
      misses += touches_silhouette(frame, carving.centres_m[i], carving.voxel_m) ? 0 : 1;
    consistent += misses <= 1 ? 1 : 0;
  }
  return static_cast<double>(consistent) / static_cast<double>(count);
}

// The carvings given let each voxel miss one view (error_tolerance = 1), and keep some more so that
// no part of a silhouette is lost; so 97 % and not all. Measured: 97.1 %, 97.1 %, 97.5 %. Of the
// bare centres, 82 to 89 % lie inside: a voxel of 4 mm is 4 pixels wide, a leaf seen from its edge
// is thinner.
TEST_P(Phenomenal, CarvedVoxelsProjectIntoTheSilhouettes) {
  const fs::path plant = kMultiview / "phenomenal_maize_silhouettes" / GetParam().name;
  if (!fs::exists(plant)) GTEST_SKIP() << "no real data at " << plant;
  Capture capture = import_phenomenal(plant);
  ASSERT_EQ(capture.frames.size(), 13U);  // 12 side views and the top
  const VoxelCarving carving = read_phenomenal_voxels(plant / "voxels" / GetParam().voxels);
  ASSERT_GT(carving.centres_m.size(), 1000U);
  const double share = consistent_share(capture, carving);
  std::printf("%s: %.2f %% of the voxels of %.0f mm\n", GetParam().name, 100 * share,
              1000 * carving.voxel_m);
  EXPECT_GT(share, 0.97);

  // The check can fail: the side views in the other sense of rotation share less than half.
  for (std::size_t i = 1; i < 6; ++i)
    std::swap(capture.frames[i].rig_from_world, capture.frames[12 - i].rig_from_world);
  EXPECT_LT(consistent_share(capture, carving), 0.5);
}
INSTANTIATE_TEST_SUITE_P(Plants, Phenomenal,
                         testing::Values(CarvedPlant{"plant_2", "4.npz"},
                                         CarvedPlant{"plant_3", "1.npz"},
                                         CarvedPlant{"plant_4", "4.npz"}));

TEST(ImportPhenomenal, AbsentFilesAreNamed) {
  const TemporaryFolder folder;
  EXPECT_THAT(error_of([&] { import_phenomenal(folder.path()); }),
              HasSubstr("calibration_camera_side.json"));
  write_file(folder.path() / "calibration/calibration_camera_side.json", "{}");
  EXPECT_THAT(error_of([&] { import_phenomenal(folder.path()); }), HasSubstr("lacks the key"));
}

TEST(PhenomenalVoxels, BrokenArchivesAreErrors) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "v.npz";
  const auto error = [&](const std::string& bytes) {
    write_file(file, bytes);
    return error_of([&] { read_phenomenal_voxels(file); });
  };
  EXPECT_THAT(error(""), HasSubstr("not a ZIP"));
  EXPECT_THAT(error(std::string("PK\x05\x06")), HasSubstr("truncated ZIP"));
  EXPECT_THAT(error("PK\x05\x06" + std::string(18, '\xff')), HasSubstr("v.npz"));
  const fs::path real = kMultiview / "phenomenal_maize_silhouettes/plant_3/voxels/4.npz";
  if (!fs::exists(real)) GTEST_SKIP() << "no real data at " << real;
  const std::string good = read_file(real);
  for (std::size_t at = 0; at < good.size(); at += std::max<std::size_t>(1, good.size() / 60)) {
    std::string bad = good;
    bad[at] = static_cast<char>(~bad[at]);
    try {  // a flipped byte may pass unnoticed, but must not do anything else than throw
      write_file(file, bad);
      read_phenomenal_voxels(file);
    } catch (const std::runtime_error&) {
    }
  }
}

// ---- folders ------------------------------------------------------------------------------------

const char* const kOpenCvYaml = R"(%YAML:1.0
---
image_width: 20
image_height: 12
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 3.0e+01, 0., 9.5, 0.,
       31., 5.5, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ 1.0e-02, -2.0e-02, 1.0e-03, 2.0e-03, 0. ]
)";
const char* const kRosYaml = R"(image_width: 20
image_height: 12
camera_name: left   # a comment
camera_matrix:
  rows: 3
  cols: 3
  data: [30, 0, 9.5, 0, 31, 5.5, 0, 0, 1]
distortion_model: equidistant
distortion_coefficients:
  rows: 1
  cols: 4
  data: [0.01, 0.02, 0.003, 0.004]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]
)";

TEST(CameraFromYaml, ReadsOpenCvAndRos) {
  const Camera opencv = camera_from_yaml(kOpenCvYaml, "c.yaml");
  EXPECT_EQ(opencv.model, LensModel::opencv5);
  EXPECT_EQ(opencv.fx_px, 30);
  EXPECT_EQ(opencv.fy_px, 31);
  EXPECT_EQ(opencv.cx_px, 9.5);
  EXPECT_EQ(opencv.cy_px, 5.5);
  EXPECT_EQ(opencv.distortion, (std::array<double, 12>{0.01, -0.02, 0.001, 0.002, 0}));
  const Camera ros = camera_from_yaml(kRosYaml, "c.yaml");
  EXPECT_EQ(ros.model, LensModel::kannala_brandt4);
  EXPECT_EQ(ros.distortion, (std::array<double, 12>{0.01, 0.02, 0.003, 0.004}));
}

TEST(CameraFromYaml, ErrorsNameFileAndKey) {
  const auto error = [](std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    text.replace(at, from.size(), to);
    return error_of([&] { camera_from_yaml(text, "c.yaml"); });
  };
  EXPECT_THAT(error(kRosYaml, "image_width: 20", ""),
              HasSubstr("c.yaml: the key \"image_width\" is missing"));
  EXPECT_THAT(error(kRosYaml, "image_width: 20", "image_width: 20.5"), HasSubstr("image_width"));
  EXPECT_THAT(error(kRosYaml, "[30,", "[.nan,"),
              HasSubstr("camera_matrix.data = .nan is not a finite number"));
  EXPECT_THAT(error(kRosYaml, "[30,", "[0,"), HasSubstr("fx_px"));
  EXPECT_THAT(error(kRosYaml, "[30, 0,", "[30,"), HasSubstr("camera_matrix.data"));
  EXPECT_THAT(error(kRosYaml, "equidistant", "omnidirectional"), HasSubstr("distortion_model"));
  EXPECT_THAT(error(kRosYaml, "0.004]", "0.004"), HasSubstr("c.yaml"));
  EXPECT_THAT(error(kRosYaml, "rows: 3", "rows"), HasSubstr("line 5"));
  EXPECT_THAT(error(kOpenCvYaml, "1.0e-02,", "-30,"), HasSubstr("folds inside the image"));
}

void write_two_images(const fs::path& folder) {
  write_png(folder / "b.png", noise<Rgb8>(20, 12, Rng(2)));
  write_png(folder / "a.png", noise<Rgb8>(20, 12, Rng(1)));
  write_file(folder / "notes.txt", "not an image");
}

TEST(ImportFolder, TakesIntrinsicsFromYamlRigAndText) {
  const TemporaryFolder folder, rigs;
  write_two_images(folder.path());
  write_file(rigs.path() / "c.yaml", kOpenCvYaml);
  const Capture from_yaml = import_folder(folder.path(), (rigs.path() / "c.yaml").string());
  ASSERT_EQ(from_yaml.frames.size(), 2U);
  EXPECT_EQ(from_yaml.frames[0].sensors[0].color, noise<Rgb8>(20, 12, Rng(1)));  // sorted by name
  EXPECT_FALSE(from_yaml.frames[0].rig_from_world.has_value());

  const Capture from_text = import_folder(folder.path(), "30,31,9.5,5.5,0.01,-0.02,0.001,0.002,0");
  EXPECT_EQ(from_text.rig[0].camera, from_yaml.rig[0].camera);
  EXPECT_EQ(import_folder(folder.path(), "30,31,9.5,5.5").rig[0].camera.model, LensModel::pinhole);

  write_capture(rigs.path() / "000000",
                from_yaml);  // an imported capture is a capture like any other
  const Capture from_rig = import_folder(folder.path(), (rigs.path() / "000000/rig.json").string());
  EXPECT_EQ(from_rig.rig[0].camera, from_yaml.rig[0].camera);
  EXPECT_EQ(read_capture(rigs.path() / "000000").frames[1].sensors[0].color,
            from_yaml.frames[1].sensors[0].color);
}

TEST(ImportFolder, WrongInputIsNamed) {
  const TemporaryFolder folder;
  const auto error = [&](const std::string& intrinsics) {
    return error_of([&] { import_folder(folder.path(), intrinsics); });
  };
  EXPECT_THAT(error("30,31,9.5,5.5"), HasSubstr("no .png, .jpg or .jpeg"));
  write_two_images(folder.path());
  const auto usage_error = [&](const std::string& intrinsics) -> std::string {
    try {
      import_folder(folder.path(), intrinsics);
    } catch (const std::invalid_argument& wrong) {
      return wrong.what();
    }
    return "";
  };
  EXPECT_THAT(usage_error("30,31,9.5"), HasSubstr("3 numbers"));
  EXPECT_THAT(usage_error("30,31,9.5,nan"), HasSubstr("number 4"));
  EXPECT_THAT(error("absent.yaml"), HasSubstr("no such file"));
  EXPECT_THAT(usage_error("absent"), HasSubstr("no such file"));
  EXPECT_THAT(usage_error("0,31,9.5,5.5"), HasSubstr("fx_px"));
  EXPECT_THAT(usage_error("1e308,31,9.5,5.5"), HasSubstr("fx_px"));
  write_png(folder.path() / "c.png", Image<Rgb8>(12, 20));
  EXPECT_THAT(error("30,31,9.5,5.5"),
              AllOf(HasSubstr("c.png"), HasSubstr("frame 2"), HasSubstr("12 x 20")));
  EXPECT_THAT(error_of([&] { import_folder(folder.path() / "absent", "30,31,9.5,5.5"); }),
              HasSubstr("not a folder"));
}

TEST(ImportFolder, BoofCvChairIsRead) {
  const fs::path chair = kMultiview / "boofcv_chair";
  if (!fs::exists(chair)) GTEST_SKIP() << "no real data at " << chair;
  const Capture capture = import_folder(
      chair / "img", (chair / "intrinsic_DSC-HX5_3648x2736_to_640x480.yaml").string());
  EXPECT_EQ(capture.frames.size(), 21U);
  EXPECT_EQ(capture.rig[0].camera.fx_px, 477.1153682877197);
}

}  // namespace
}  // namespace cousin
