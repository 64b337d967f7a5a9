#include "sim/dataset/truth_format.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/float_files.h"
#include "sim/dataset/seam_io.h"
#include "sim/imaging/exr_vectors.h"
#include "sim/imaging/image_io.h"
#include "sim/imaging/npy.h"
#include "tests/sim/dataset/sample_capture.h"
#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

Image<float> sample_depth(float farthest_m) {
  Image<float> depth_m(4, 3, 0.3F);
  depth_m(0, 0) = kNaN;
  depth_m(1, 0) = 1 / 3.0F;
  depth_m(2, 0) = 0.00001F;  // below half a step, which is a depth all the same
  depth_m(3, 2) = farthest_m;
  return depth_m;
}

TEST(TruthFormats, DepthComesBackFromEachOfThem) {
  const TemporaryFolder folder;
  const Image<float> depth_m = sample_depth(6.5F);
  for (const TruthFormat format : {TruthFormat::npy, TruthFormat::exr, TruthFormat::png16}) {
    const fs::path dir = folder.path() / to_string(format);
    write_truth_depth(dir, "depth/000000", depth_m, format);
    for (const std::string& file : depth_files("depth/000000", format))
      EXPECT_TRUE(fs::exists(dir / file)) << file;
    const std::string relative = float_file(dir, "depth/000000", depth_endings());
    const Image<float> read = read_truth_depth(dir, relative);
    ASSERT_EQ(read.size(), depth_m.size()) << relative;
    // PNG: half a step of 0.1 mm, and what a float of 6.5 rounds by; others: every bit.
    const float most_off = format == TruthFormat::png16 ? 0.5e-4F + 1e-6F : 0.0F;
    for (std::size_t i = 0; i < read.size(); ++i) {
      const float a = read.data()[i], b = depth_m.data()[i];
      EXPECT_EQ(std::isnan(a), std::isnan(b)) << relative << ' ' << i;
      if (i == 2 && format == TruthFormat::png16)
        EXPECT_FLOAT_EQ(a, 1e-4F);  // the least step
      else if (!std::isnan(b))
        EXPECT_NEAR(a, b, most_off) << relative << ' ' << i;
    }
  }
}

TEST(TruthFormats, ThePngIsBopsDepthWithItsScaleBeside) {
  const TemporaryFolder folder;
  struct Case {
    float farthest_m;
    double step_mm;
  };
  for (const auto& [farthest_m, step_mm] : {Case{6.5F, 0.1}, Case{6.5535F, 0.1}, Case{6.6F, 1},
                                            Case{65.6F, 10}, Case{700, 100}, Case{65535, 1000}}) {
    write_truth_depth(folder.path(), "depth/000000", sample_depth(farthest_m), TruthFormat::png16);
    const Image<std::uint16_t> codes = read_png16(folder.path() / "depth/000000.png");
    EXPECT_EQ(codes(0, 0), 0);
    EXPECT_EQ(codes(2, 0), 1);
    EXPECT_EQ(codes(1, 0), std::max(1.0, std::round(1000 / 3.0 / step_mm))) << farthest_m;
    EXPECT_NEAR(codes(3, 2) * step_mm / 1000, farthest_m, 0.51e-3 * step_mm) << farthest_m;
    const std::string json = read_file(folder.path() / "depth/000000.json");
    const std::size_t colon = json.find("\"depth_scale\":");
    ASSERT_NE(colon, std::string::npos) << json;
    EXPECT_EQ(std::stod(json.substr(colon + 14)), step_mm);
  }
}

TEST(TruthFormats, DepthsThatAPngCannotHoldAreNamed) {
  const TemporaryFolder folder;
  for (const float depth_m : {-0.1F, 65536.0F, std::numeric_limits<float>::infinity()}) {
    const auto write = [&] {
      write_truth_depth(folder.path(), "depth/000004", sample_depth(depth_m), TruthFormat::png16);
    };
    EXPECT_THAT(write, ThrowsMessage<std::invalid_argument>(
                           AllOf(HasSubstr("depth/000004.png"), HasSubstr("[0, 65535]"),
                                 HasSubstr(std::to_string(static_cast<double>(depth_m))))));
  }
  EXPECT_FALSE(fs::exists(folder.path() / "depth"));
  EXPECT_THAT([] { truth_format_from_string("tiff"); },
              ThrowsMessage<std::invalid_argument>(
                  HasSubstr("--truth-format \"tiff\" is not one of npy, exr, png16")));
}

TEST(TruthFormats, AScaleThatIsMissingOrWrongIsNamed) {
  const TemporaryFolder folder;
  write_truth_depth(folder.path(), "depth/000000", sample_depth(1), TruthFormat::png16);
  const fs::path json = folder.path() / "depth/000000.json";
  const auto said = [&] {
    return error_of([&] { read_truth_depth(folder.path(), "depth/000000.png"); });
  };
  EXPECT_EQ(said(), "");
  for (const char* text :
       {"{\"depth_scale\": 0}", "{\"depth_scale\": -1}", "{\"depth_scale\": 1e4}",
        "{\"depth_scale\": \"1\"}", "{\"scale\": 1}", "{}", "1"}) {
    write_file(json, text);
    EXPECT_THAT(said(), HasSubstr("000000.json")) << text;
  }
  fs::remove(json);
  EXPECT_THAT(said(), HasSubstr("000000.json"));
}

TEST(FloatFiles, TwoFilesOfOneImageAreRefused) {
  const TemporaryFolder folder;
  EXPECT_EQ(float_file(folder.path(), "depth/000000"), "");
  write_truth_depth(folder.path(), "depth/000000", sample_depth(1), TruthFormat::npy);
  EXPECT_EQ(float_file(folder.path(), "depth/000000"), "depth/000000.npy");
  write_truth_depth(folder.path(), "depth/000000", sample_depth(1), TruthFormat::exr);
  EXPECT_THAT(error_of([&] { float_file(folder.path(), "depth/000000"); }),
              AllOf(HasSubstr("000000.exr"), HasSubstr("000000.npy"), HasSubstr("expected one")));
}

TEST(FloatFiles, DepthsOfAnotherProgramMayBeNpy) {
  const TemporaryFolder folder;
  write_npy(folder.path() / "depth/000002.npy", sample_depth(1));
  write_npy(folder.path() / "depth_sigma/000002.npy", Image<float>(4, 3, 1e-3F));
  write_npy(folder.path() / "depth_normal/000002.npy",
            Image<Eigen::Vector3f>(4, 3, Eigen::Vector3f(0, 0, -1)));
  write_exr(folder.path() / "depth/000005.exr", sample_depth(2));
  const Depths depths = read_depths(folder.path());
  ASSERT_EQ(depths.size(), 2U);
  EXPECT_EQ(depths[0].frame, 2);
  EXPECT_EQ(depths[0].depth_m(1, 0), 1 / 3.0F);
  EXPECT_EQ(depths[0].sigma_m(3, 2), 1e-3F);
  EXPECT_EQ(depths[0].normal(0, 0).z(), -1);
  EXPECT_EQ(depths[1].depth_m(3, 2), 2.0F);
  write_npy(folder.path() / "depth_sigma/000002.npy", Image<float>(3, 3, 1e-3F));
  EXPECT_THAT(error_of([&] { read_depths(folder.path()); }),
              AllOf(HasSubstr("depth_sigma/000002.npy"), HasSubstr("3 x 3")));
}

}  // namespace
}  // namespace cousin
