#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/import.h"
#include "sim/imaging/image_io.h"
#include "sim/types/memory_limit.h"
#include "tests/sim/dataset/sample_capture.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

/// Two colour images and one depth image, in the benchmark's own way of writing.
void write_sequence(const fs::path& folder) {
  write_png(folder / "rgb/1.png", noise<Rgb8>(20, 12, Rng(1)));
  write_png(folder / "rgb/2.png", noise<Rgb8>(20, 12, Rng(2)));
  write_png(folder / "depth/1.png", Image<std::uint16_t>(20, 12, 7500));
  write_file(folder / "rgb.txt",
             "# color images\n# file: 'a.bag'\n1.00 rgb/1.png\n2.00 rgb/2.png\n");
  write_file(folder / "depth.txt", "1.015 depth/1.png\n");
  write_file(folder / "groundtruth.txt",
             "# timestamp tx ty tz qx qy qz qw\n0.98 0 0 2 1 0 0 0\n1.02 0.4 0 2 1 0 0 0\n"
             "9.00 0 0 9 0 0 0 1\n");
}
const char* const kLens = "30,31,9.5,5.5";

void make_folders(const fs::path& folder) {
  fs::create_directories(folder / "rgb");
  fs::create_directories(folder / "depth");
}

TEST(ImportTum, PosesAreInterpolatedAndDepthBelongsToTheNearestImage) {
  const TemporaryFolder folder;
  make_folders(folder.path());
  write_sequence(folder.path());
  const Capture capture = import_tum(folder.path(), kLens);
  ASSERT_EQ(capture.frames.size(), 2U);
  // Half way between the poses around it: 2 m above the origin's neighbour, looking down.
  const Frame& first = capture.frames[0];
  EXPECT_LT((centre_in_world_m(*first.rig_from_world) - Eigen::Vector3d(0.2, 0, 2)).norm(), 1e-12);
  EXPECT_LT((*first.rig_from_world * Eigen::Vector3d(0.2, 0, 0) - Eigen::Vector3d(0, 0, 2)).norm(),
            1e-12);
  EXPECT_EQ(first.sensors[0].color, noise<Rgb8>(20, 12, Rng(1)));
  EXPECT_EQ(first.sensors[0].depth(3, 4) * first.sensors[0].depth_unit_m, 1.5);
  EXPECT_EQ(first.sensors[0].reported.cx_px, 9.5);
  EXPECT_FALSE(capture.frames[1].rig_from_world);
  EXPECT_TRUE(capture.frames[1].sensors[0].depth.empty());
  EXPECT_THAT(capture.warnings,
              testing::ElementsAre(AllOf(HasSubstr("rgb/2.png"), HasSubstr("pose")),
                                   AllOf(HasSubstr("rgb/2.png"), HasSubstr("depth"))));
}

TEST(ImportTum, DepthCountsBesideColour) {
  const TemporaryFolder folder;
  make_folders(folder.path());
  write_sequence(folder.path());
  constexpr std::uint64_t kBytes = 2 * 20 * 12 * 3 + 20 * 12 * 2;
  set_memory_limit(kBytes - 1);
  EXPECT_THAT(error_of([&] { import_tum(folder.path(), kLens); }),
              AllOf(HasSubstr("and 1 depth images"), HasSubstr(std::to_string(kBytes))));
  set_memory_limit(kBytes);
  EXPECT_EQ(error_of([&] { import_tum(folder.path(), kLens); }), "");
  set_memory_limit(0);
}

TEST(ImportTum, WrongFilesAreErrorsWithFileAndLine) {
  const TemporaryFolder folder;
  make_folders(folder.path());
  write_sequence(folder.path());
  const auto error = [&](const char* name, const std::string& text) {
    write_sequence(folder.path());
    write_file(folder.path() / name, text);
    return error_of([&] { import_tum(folder.path(), kLens); });
  };
  EXPECT_THAT(error("rgb.txt", ""), HasSubstr("rgb.txt: lists no image"));
  EXPECT_THAT(error("rgb.txt", "1.0\n"), HasSubstr("rgb.txt: line 1"));
  EXPECT_THAT(error("rgb.txt", "inf rgb/1.png\n"), HasSubstr("not a finite number"));
  EXPECT_THAT(error("rgb.txt", "2 rgb/1.png\n1 rgb/2.png\n"), HasSubstr("is not above"));
  EXPECT_THAT(error("rgb.txt", "1 ../../etc/passwd\n"), HasSubstr("\"..\""));
  EXPECT_THAT(error("rgb.txt", "1 /etc/passwd\n"), HasSubstr("absolute"));
  EXPECT_THAT(error("rgb.txt", "1 rgb/absent.png\n"), HasSubstr("absent.png"));
  EXPECT_THAT(error("groundtruth.txt", "1 0 0 0 0 0 0\n"), HasSubstr("7 words, not 8"));
  EXPECT_THAT(error("groundtruth.txt", "1 0 0 0 1 1 0 0\n"), HasSubstr("norm"));
  write_sequence(folder.path());
  EXPECT_THAT(error_of([&] { import_tum(folder.path(), ""); }), HasSubstr("--intrinsics"));
  write_png(folder.path() / "depth/1.png", Image<std::uint16_t>(10, 12));
  EXPECT_THAT(error_of([&] { import_tum(folder.path(), kLens); }),
              AllOf(HasSubstr("depth/1.png"), HasSubstr("10 x 12")));
}

// ---- units, times and absent files --------------------------------------------------------------

class TumFolder : public testing::Test {
 protected:
  TumFolder() { make_folders(folder_.path()); }
  void write(const std::string& rgb, const std::string& depth, const std::string& poses,
             std::uint16_t units = 5000) {
    for (const char* name : {"1.png", "2.png"}) {
      write_png(folder_.path() / "rgb" / name, Image<Rgb8>(20, 12));
      write_png(folder_.path() / "depth" / name, Image<std::uint16_t>(20, 12, units));
    }
    write_file(folder_.path() / "rgb.txt", rgb);
    write_file(folder_.path() / "depth.txt", depth);
    write_file(folder_.path() / "groundtruth.txt", poses);
  }
  Capture import(std::optional<double> depth_unit_m = {}) const {
    return import_tum(folder_.path(), kLens, depth_unit_m);
  }
  static double depth_m(const Capture& capture) {
    const SensorFrame& sensor = capture.frames[0].sensors[0];
    return sensor.depth(3, 4) * sensor.depth_unit_m;
  }
  TemporaryFolder folder_;
};
const std::string kRgb = "1.0 rgb/1.png\n1.1 rgb/2.png\n";
const std::string kDepth = "1.0 depth/1.png\n1.1 depth/2.png\n";

TEST_F(TumFolder, ADepthThatTumsUnitMakesImplausibleIsAskedAbout) {
  write(kRgb, kDepth, "", 1000);  // a metre in millimetres
  EXPECT_THAT(error_of([&] { import(); }),
              AllOf(HasSubstr("depth.txt"), HasSubstr("1000 units"), HasSubstr("0.2 m"),
                    HasSubstr("--depth-unit"), HasSubstr("0.001 (millimetres"), HasSubstr("1 m)")));
  EXPECT_EQ(depth_m(import(0.001)), 1);
  EXPECT_EQ(depth_m(import(0.0002)), 0.2);
  write(kRgb, "# time file; 1000 = 1 m\n" + kDepth, "", 1000);
  EXPECT_EQ(depth_m(import()), 1);
  write(kRgb, kDepth, "", 60000);
  EXPECT_THAT(error_of([&] { import(); }), AllOf(HasSubstr("12 m"), HasSubstr("6 m")));
}

TEST_F(TumFolder, TimesMayBeNanoseconds) {
  write("1403636579763555584 rgb/1.png\n1403636579813555456 rgb/2.png\n",
        "1403636579763555584 depth/1.png\n",
        "1403636579.763555584 1 0 0 0 0 0 1\n1403636579.813555456 2 0 0 0 0 0 1\n");
  const Capture capture = import();
  EXPECT_NEAR(capture.frames[0].time_s, 1403636579.763555584, 1e-6);
  ASSERT_TRUE(capture.frames[1].rig_from_world);
  EXPECT_NEAR(centre_in_world_m(*capture.frames[1].rig_from_world).x(), 2, 1e-4);
  EXPECT_FALSE(capture.frames[0].sensors[0].depth.empty());
  write("1403636579763 rgb/1.png\n", "", "");
  EXPECT_THAT(error_of([&] { import(); }),
              AllOf(HasSubstr("rgb.txt: line 1"), HasSubstr("neither in seconds")));
}

TEST_F(TumFolder, TimesAreNotComparedExactly) {
  // The last pose is 25 microseconds before the last picture, the first as much after the first.
  write("1305031102.0 rgb/1.png\n1305031102.1 rgb/2.png\n", kDepth,
        "1305031102.000025 1 0 0 0 0 0 1\n1305031102.099975 2 0 0 0 0 0 1\n");
  Capture capture = import();
  ASSERT_TRUE(capture.frames[0].rig_from_world && capture.frames[1].rig_from_world);
  EXPECT_EQ(centre_in_world_m(*capture.frames[0].rig_from_world).x(), 1);
  EXPECT_EQ(centre_in_world_m(*capture.frames[1].rig_from_world).x(), 2);
  // 0.1 s apart, which doubles of such size hold only to 2.4e-7 s.
  for (const char* times : {"1305031102.1 1305031102.2", "1305031102.3 1305031102.4",
                            "1305031102.7 1305031102.8", "1305031103.9 1305031104.0"}) {
    const std::string text = times, first = text.substr(0, 12), second = text.substr(13);
    write(first.substr(0, 12) + "5 rgb/1.png\n", "",
          first + " 1 0 0 0 0 0 1\n" + second + " 2 0 0 0 0 0 1\n");
    capture = import();
    ASSERT_TRUE(capture.frames[0].rig_from_world) << times;
    EXPECT_NEAR(centre_in_world_m(*capture.frames[0].rig_from_world).x(), 1.5, 1e-5);
  }
  // 1 ms is another time.
  write("1305031102.0 rgb/1.png\n", "", "1305031102.0015 1 0 0 0 0 0 1\n");
  EXPECT_FALSE(import().frames[0].rig_from_world);
}

TEST_F(TumFolder, AbsentPicturesAreSkippedAndNamed) {
  write("0.9 rgb/absent.png\n" + kRgb, "1.0 depth/absent.png\n1.1 depth/2.png\n", "");
  const Capture capture = import();
  ASSERT_EQ(capture.frames.size(), 2U);
  EXPECT_TRUE(capture.frames[0].sensors[0].depth.empty());
  EXPECT_FALSE(capture.frames[1].sensors[0].depth.empty());
  EXPECT_THAT(capture.warnings,
              testing::ElementsAre(
                  AllOf(HasSubstr("rgb/absent.png"), HasSubstr("skipped: it is absent")),
                  AllOf(HasSubstr("depth/absent.png"), HasSubstr("skipped: it is absent"))));
  write("0.9 rgb/absent.png\n", "", "");
  EXPECT_THAT(error_of([&] { import(); }),
              AllOf(HasSubstr("none of the listed images"), HasSubstr("rgb/absent.png")));
}

TEST_F(TumFolder, NamesKeepTheirBlanksAndAreUtf8) {
  write("1.0 rgb/my plant  1.png\n", "", "");
  write_png(folder_.path() / "rgb/my plant  1.png", Image<Rgb8>(20, 12));
  EXPECT_EQ(import().frames.size(), 1U);
  write("# colour\n1.0 rgb/caf\xe9.png\n", "", "");
  EXPECT_THAT(error_of([&] { import(); }),
              AllOf(HasSubstr("rgb.txt: line 2"), HasSubstr("caf\\xe9.png")));
}

TEST_F(TumFolder, NumbersBeyondAllMeasureAreDamage) {
  write(kRgb, "", "1 1e308 0 0 0 0 0 1\n");
  EXPECT_THAT(error_of([&] { import(); }), HasSubstr("groundtruth.txt: line 1: word 2"));
  write("1e308 rgb/1.png\n", "", "");
  EXPECT_THAT(error_of([&] { import(); }), HasSubstr("rgb.txt: line 1"));
}

TEST_F(TumFolder, NoLinkLeadsOut) {
  const TemporaryFolder secret;
  write_file(secret.path() / "camera.yaml", "image_width: 20\n");
  write(kRgb, "", "");
  fs::create_symlink(secret.path() / "camera.yaml", folder_.path() / "camera.yaml");
  EXPECT_THAT(error_of([&] { import_tum(folder_.path(), ""); }), HasSubstr("symbolic link"));
}

}  // namespace
}  // namespace cousin
