#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/colmap_model.h"
#include "sim/dataset/import.h"
#include "sim/imaging/image_io.h"
#include "tests/sim/dataset/sample_capture.h"
#include "tests/sim/dataset/sample_lenses.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

/// All lenses that COLMAP has, a photograph of each.
ColmapModel odd_model() {
  Rng rng(13);
  ColmapModel model;
  for (const Camera& lens : odd_lenses()) {
    if (lens.model == LensModel::opencv12 || lens.model == LensModel::splined_stereographic)
      continue;
    const int id = static_cast<int>(model.cameras.size()) + 1;
    model.cameras[id] = lens;
    model.images[10 * id] = {"rgb/" + std::to_string(id) + ".png", id, odd_pose(rng)};
  }
  return model;
}

void expect_equal(const ColmapModel& a, const ColmapModel& b) {
  ASSERT_EQ(a.cameras.size(), b.cameras.size());
  for (const auto& [id, camera] : a.cameras) {
    EXPECT_EQ(b.cameras.at(id).width_px, camera.width_px);
    EXPECT_EQ(b.cameras.at(id).height_px, camera.height_px);
    // Half a pixel there and back rounds the principal point in its last digit.
    EXPECT_LE(largest_difference_px(camera, b.cameras.at(id)), 1e-9);
  }
  ASSERT_EQ(a.images.size(), b.images.size());
  for (const auto& [id, image] : a.images) {
    EXPECT_EQ(b.images.at(id).name, image.name);
    EXPECT_EQ(b.images.at(id).camera, image.camera);
    EXPECT_TRUE(same_pose(b.images.at(id).camera_from_world, image.camera_from_world));
  }
}

TEST(Colmap, TextAndBinaryReadBackWithEveryDigit) {
  const ColmapModel model = odd_model();
  ASSERT_EQ(model.cameras.size(), 5U);
  expect_equal(model, colmap_from_text(colmap_text(model), "m"));
  expect_equal(model, colmap_from_binary(colmap_binary(model), "m"));
}

TEST(Colmap, PixelsCountFromTheImagesCorner) {
  ColmapModel model;
  model.cameras[1] = {.width_px = 20,
                      .height_px = 12,
                      .fx_px = 30,
                      .fy_px = 31,
                      .cx_px = 9.5,
                      .cy_px = 5.5,
                      .distortion = {},
                      .spline = {}};
  EXPECT_THAT(colmap_text(model).cameras, HasSubstr("1 PINHOLE 20 12 30 31 10 6\n"));
}

TEST(Colmap, EachCameraModelPutsItsParametersWhereTheyBelong) {
  const auto camera = [](const std::string& line) {
    return colmap_from_text({.cameras = line, .images = "", .points = ""}, "m").cameras.at(7);
  };
  const std::array<double, 12> none{};
  const Camera simple = camera("7 SIMPLE_PINHOLE 20 12 30 10 6");
  EXPECT_EQ(std::tie(simple.fx_px, simple.fy_px), std::make_tuple(30.0, 30.0));
  EXPECT_EQ(std::tie(simple.cx_px, simple.cy_px), std::make_tuple(9.5, 5.5));
  EXPECT_EQ(simple.distortion, none);
  const Camera radial = camera("7 RADIAL 20 12 30 10 6 0.01 0.02");
  EXPECT_EQ(radial.model, LensModel::opencv5);
  EXPECT_EQ(radial.distortion, (std::array<double, 12>{0.01, 0.02}));
  EXPECT_EQ(camera("7 SIMPLE_RADIAL 20 12 30 10 6 0.01").distortion,
            (std::array<double, 12>{0.01}));
  EXPECT_EQ(camera("7 OPENCV 20 12 30 31 10 6 .01 .02 .003 .004").distortion,
            (std::array<double, 12>{.01, .02, .003, .004}));
  const Camera full =
      camera("7 FULL_OPENCV 20 12 30 31 10 6 .01 .02 .003 .004 .005 .006 .007 .008");
  EXPECT_EQ(full.model, LensModel::opencv8);
  EXPECT_EQ(full.distortion,
            (std::array<double, 12>{.01, .02, .003, .004, .005, .006, .007, .008}));
  for (const char* line : {"7 OPENCV_FISHEYE 20 12 30 30 10 6 .01 .02 0 0",
                           "7 RADIAL_FISHEYE 20 12 30 10 6 .01 .02"}) {
    EXPECT_EQ(camera(line).model, LensModel::kannala_brandt4);
    EXPECT_EQ(camera(line).distortion, (std::array<double, 12>{.01, .02}));
  }
}

TEST(Colmap, LensesThatItDoesNotHaveAreRefusedByName) {
  for (const LensModel lens : {LensModel::opencv12, LensModel::splined_stereographic}) {
    ColmapModel model;
    model.cameras[3] = odd_lens(odd_lenses(), lens);
    try {
      colmap_text(model);
      ADD_FAILURE() << to_string(lens);
    } catch (const std::invalid_argument& error) {
      EXPECT_THAT(error.what(),
                  AllOf(HasSubstr("camera 3"), HasSubstr(std::string(to_string(lens)))));
    }
  }
}

TEST(Colmap, WrongTextIsAnErrorWithFileLineAndLimit) {
  const auto error = [](const std::string& cameras, const std::string& images = "") {
    return error_of([&] { colmap_from_text({cameras, images, ""}, "m"); });
  };
  const std::string good = "1 PINHOLE 20 12 30 31 10 6\n";
  EXPECT_THAT(error("# comment\n\n1 PINHOLE 20 12 30 31 10\n"),
              AllOf(HasSubstr("m/cameras.txt: line 3"), HasSubstr("PINHOLE has 8")));
  EXPECT_THAT(error("1 FOV 20 12 30 31 10 6 1\n"), AllOf(HasSubstr("FOV"), HasSubstr("OPENCV")));
  EXPECT_THAT(error("1 PINHOLE 99999999 12 30 31 10 6\n"), HasSubstr("65535"));
  EXPECT_THAT(error("1 PINHOLE 20 12 nan 31 10 6\n"), HasSubstr("\"nan\" is not a finite number"));
  EXPECT_THAT(error("1 PINHOLE 20 12 -30 31 10 6\n"), HasSubstr("fx_px"));
  EXPECT_THAT(error(good + good), HasSubstr("camera 1 occurs twice"));
  EXPECT_THAT(error(good, "1 1 0 0 0 0 0 0 2 a.png\n\n"),
              AllOf(HasSubstr("m/images.txt"), HasSubstr("camera 2 is not in")));
  EXPECT_THAT(error(good, "1 1 1 0 0 0 0 0 1 a.png\n\n"), HasSubstr("norm"));
  EXPECT_THAT(error(good, "1 1 0 0 0 0 0 0 1\n\n"), HasSubstr("word 10 is missing"));
}

TEST(Colmap, WrongBinaryIsAnErrorAndAsksForNoMemory) {
  const ColmapFiles good = colmap_binary(odd_model());
  for (std::size_t cut = 0; cut < good.images.size(); cut += 7) {
    ColmapFiles files = good;
    files.images.resize(cut);
    EXPECT_THAT(error_of([&] { colmap_from_binary(files, "m"); }), HasSubstr("m/images.bin: byte"));
  }
  ColmapFiles files = good;
  std::memset(files.cameras.data(), 0x7f, 8);  // 9e18 cameras
  EXPECT_THAT(error_of([&] { colmap_from_binary(files, "m"); }),
              AllOf(HasSubstr("byte 0"), HasSubstr("needs more bytes")));
  files = good;
  std::memset(files.images.data() + files.images.size() - 8, 0x7f, 8);  // as many points
  EXPECT_THAT(error_of([&] { colmap_from_binary(files, "m"); }), HasSubstr("needs more bytes"));
}

TEST(ImportColmap, TakesAWorkspaceAndStaysInside) {
  const TemporaryFolder folder;
  ColmapModel model;
  Rng rng(2);
  const Camera camera = odd_camera(20, 12, 1);
  model.cameras[1] = camera;
  model.images[1] = {"rgb/b.png", 1, odd_pose(rng)};
  model.images[2] = {"rgb/a.png", 1, odd_pose(rng)};
  model.images[3] = {"rgb/absent.png", 1, odd_pose(rng)};
  const auto write = [&](const ColmapFiles& files) {
    write_file(folder.path() / "sparse/0/cameras.txt", files.cameras);
    write_file(folder.path() / "sparse/0/images.txt", files.images);
  };
  write(colmap_text(model));
  EXPECT_THAT(error_of([&] { import_colmap(folder.path()); }), HasSubstr("none of the listed"));
  fs::create_directories(folder.path() / "images/rgb");
  for (const char* name : {"a.png", "b.png"})
    write_png(folder.path() / "images/rgb" / name, noise<Rgb8>(20, 12, Rng(name[0])));
  const Capture capture = import_colmap(folder.path());
  ASSERT_EQ(capture.frames.size(), 2U);
  EXPECT_EQ(capture.frames[0].sensors[0].color, noise<Rgb8>(20, 12, Rng('a')));
  EXPECT_TRUE(same_pose(*capture.frames[0].rig_from_world, model.images[2].camera_from_world));
  EXPECT_LE(largest_difference_px(camera, capture.frames[1].sensors[0].reported), 1e-9);
  EXPECT_THAT(capture.warnings, testing::ElementsAre(HasSubstr("rgb/absent.png")));

  model.images[3].name = "../secret.png";
  write(colmap_text(model));
  EXPECT_THAT(error_of([&] { import_colmap(folder.path()); }), HasSubstr("\"..\""));
  model.images[3].name = "rgb/small.png";
  write(colmap_text(model));
  write_png(folder.path() / "images/rgb/small.png", Image<Rgb8>(19, 12));
  EXPECT_THAT(error_of([&] { import_colmap(folder.path()); }),
              AllOf(HasSubstr("small.png"), HasSubstr("19 x 12")));
  EXPECT_THAT(error_of([&] { import_colmap(folder.path() / "images"); }),
              HasSubstr("no cameras.bin or cameras.txt"));
}

// ---- lines of images.txt ------------------------------------------------------------------------

const std::string kPinhole = "1 PINHOLE 64 48 80 81 32 24\n";
std::string image_line(int id) {
  return std::to_string(id) + " 1 0 0 0 0." + std::to_string(id) + " 0 2 1 " + std::to_string(id) +
         ".png\n";
}
ColmapModel model_of_images(const std::string& images) {
  return colmap_from_text({kPinhole, images, ""}, "m");
}

TEST(ColmapText, ImagesWithoutPointsNeedNoEmptyLine) {
  const std::string points = "10.5 20.5 -1 11 12.25 18446744073709551615 3 4 77\n";
  // The points begin with what could be an image's number, turn and camera, but for its length.
  const std::string like_image = "100 20.5 -1 300 40 7 5 6 1 7 8 9\n";
  const std::string i1 = image_line(1), i2 = image_line(2), i3 = image_line(3), i4 = image_line(4);
  for (const std::string& images :
       {i1 + i2 + i3 + i4, i1 + "\n" + i2 + "\n" + i3 + "\n" + i4 + "\n",
        i1 + points + i2 + i3 + points + i4, i1 + "# a comment\n" + points + i2 + "\n" + i3 + i4,
        i1 + like_image + i2 + "\r\n" + i3 + "\n\n\n" + i4}) {
    EXPECT_EQ(model_of_images(images).images.size(), 4U) << images;
  }
}

TEST(ColmapText, ALineThatIsNeitherIsNamed) {
  const auto error = [](const std::string& images) {
    return error_of([&] { model_of_images(images); });
  };
  EXPECT_THAT(error(image_line(1) + "10.5 20.5\n" + image_line(2)),
              HasSubstr("images.txt: line 2"));
  EXPECT_THAT(error(image_line(1) + "10.5 20.5 x\n"), HasSubstr("line 2"));
  EXPECT_THAT(error(image_line(1) + "\n" + "2 1 0 0 0 0 0 2 1\n"), HasSubstr("line 3"));
  // An image of another camera, where its points should be.
  EXPECT_THAT(error(image_line(1) + "2 1 0 0 0 0 0 2 9 b.png\n"), HasSubstr("line 2"));
}

TEST(ColmapText, NamesKeepTheirBlanks) {
  const ColmapModel model = model_of_images("1 1 0 0 0 0 0 2 1 my plant  7.png\n\n");
  EXPECT_EQ(model.images.at(1).name, "my plant  7.png");
}

TEST(ColmapText, NumbersBeyondAllMeasureAreDamage) {
  EXPECT_THAT(error_of([&] { model_of_images("1 1 0 0 0 1e308 0 2 1 a.png\n"); }),
              AllOf(HasSubstr("images.txt: line 1"), HasSubstr("1e9")));
  EXPECT_THAT(error_of([&] {
                colmap_from_text({"1 PINHOLE 64 48 1e308 81 32 24\n", "", ""}, "m");
              }),
              AllOf(HasSubstr("cameras.txt: line 1"), HasSubstr("fx_px")));
}

TEST(ColmapText, NamesThatAreNotUtf8AreRefusedWithTheirLine) {
  EXPECT_THAT(error_of([&] { model_of_images("\n1 1 0 0 0 0 0 2 1 caf\xe9.png\n"); }),
              AllOf(HasSubstr("images.txt: line 2"), HasSubstr("caf\\xe9.png")));
}

TEST(ImportColmap, TheLargestModelIsTakenAndTheOthersAreNamed) {
  const TemporaryFolder folder;
  const auto write = [&](const std::string& model, const std::string& images) {
    write_file(folder.path() / "sparse" / model / "cameras.txt", kPinhole);
    write_file(folder.path() / "sparse" / model / "images.txt", images);
  };
  write("0", image_line(1));
  fs::create_directories(folder.path() / "images");
  for (const char* name : {"1.png", "2.png", "3.png"})
    write_png(folder.path() / "images" / name, Image<Rgb8>(64, 48));
  EXPECT_THAT(import_colmap(folder.path()).warnings, testing::IsEmpty());
  write("1", image_line(2) + image_line(3));
  const Capture capture = import_colmap(folder.path());
  EXPECT_EQ(capture.frames.size(), 2U);
  EXPECT_THAT(capture.warnings, testing::ElementsAre(AllOf(HasSubstr("sparse/1 with 2 images"),
                                                           HasSubstr("sparse/0 with 1 images"))));
}

TEST(ImportColmap, NoLinkLeadsOut) {
  const TemporaryFolder folder, secret;
  write_file(folder.path() / "sparse/0/cameras.txt", kPinhole);
  write_file(folder.path() / "sparse/0/images.txt", image_line(1));
  write_png(secret.path() / "1.png", Image<Rgb8>(64, 48));
  fs::create_directory_symlink(secret.path(), folder.path() / "images");
  EXPECT_THAT(error_of([&] { import_colmap(folder.path()); }), HasSubstr("symbolic link"));
}

/// COLMAP's own reader and writer.
TEST(Colmap, ItsProgramReadsOurBinaryAndWritesWhatWeMeant) {
  if (std::system("command -v colmap > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "the program colmap is not installed";
  const TemporaryFolder folder;
  const ColmapModel model = odd_model();
  const ColmapFiles binary = colmap_binary(model);
  write_file(folder.path() / "in/cameras.bin", binary.cameras);
  write_file(folder.path() / "in/images.bin", binary.images);
  write_file(folder.path() / "in/points3D.bin", binary.points);
  fs::create_directories(folder.path() / "out");
  const std::string command = "colmap model_converter --input_path '" +
                              (folder.path() / "in").string() + "' --output_path '" +
                              (folder.path() / "out").string() + "' --output_type TXT > /dev/null";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const ColmapFiles text{read_file(folder.path() / "out/cameras.txt"),
                         read_file(folder.path() / "out/images.txt"), ""};
  expect_equal(model, colmap_from_text(text, "out"));
}

}  // namespace
}  // namespace cousin
