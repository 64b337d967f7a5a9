// Captures that ask for more memory than is allowed are refused before any pixel is read.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/dataset/capture_io.h"
#include "sim/dataset/import.h"
#include "sim/types/memory_limit.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {
namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

/// Three colour views of 64 x 48 pixels: 27,648 bytes in memory.
class CaptureMemory : public testing::Test {
 protected:
  CaptureMemory() {
    Capture capture;
    capture.rig.resize(1);
    capture.rig[0].camera = Camera{LensModel::opencv5, 64, 48, 60, 60, 32, 24, {}};
    for (int i = 0; i < 3; ++i) {
      Frame frame;
      frame.id = i;
      frame.sensors.resize(1);
      frame.sensors[0].reported = capture.rig[0].camera;
      frame.sensors[0].color = Image<Rgb8>(64, 48, {90, 90, 90});
      capture.frames.push_back(frame);
    }
    write_capture(scene_, capture);
  }
  ~CaptureMemory() override { set_memory_limit(0); }
  TemporaryFolder folder_;
  fs::path scene_ = folder_.path() / "000000";
};

TEST_F(CaptureMemory, ADatasetWhoseImagesDoNotFitIsRefusedByItsFileAndBytes) {
  set_memory_limit(27647);
  EXPECT_THAT(error_of([&] { read_capture(scene_); }),
              AllOf(HasSubstr("scene_camera.json"), HasSubstr("3 views"), HasSubstr("27648 bytes"),
                    HasSubstr("27647 bytes")));
  set_memory_limit(27648);
  EXPECT_EQ(error_of([&] { read_capture(scene_); }), "");
}

TEST_F(CaptureMemory, PhotographsThatDoNotFitAreRefusedByTheirFolderAndBytes) {
  set_memory_limit(27647);
  EXPECT_THAT(error_of([&] { import_folder(scene_ / "rgb", "60,60,32,24"); }),
              AllOf(HasSubstr("rgb: 3 images"), HasSubstr("27648 bytes")));
  set_memory_limit(27648);
  EXPECT_EQ(error_of([&] { import_folder(scene_ / "rgb", "60,60,32,24"); }), "");
}

}  // namespace
}  // namespace cousin
