#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/import.h"
#include "sim/imaging/image_io.h"
#include "tests/dataset/sample_capture.h"
#include "tests/dataset/temporary_folder.h"

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

}  // namespace
}  // namespace cousin
