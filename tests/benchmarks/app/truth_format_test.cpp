// Truth images as a user asks for them, and as other people's readers see them.
#include "sim/dataset/truth_format.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/float_files.h"
#include "sim/imaging/exr_vectors.h"
#include "sim/imaging/image_io.h"
#include "sim/imaging/npy.h"
#include "tests/benchmarks/app/program.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// Two views of an empty board by a time-of-flight camera, with depths of both its cameras.
Words small_depth_camera() {
  return {"render",  "seeds",
          "--truth", "depth,normal,flow,noise_free_depth,invalid_reason",
          "--set",   "views=2",
          "--set",   "seeds=0",
          "--set",   "rig=kinect_v2",
          "--set",   "rig.time_of_flight.columns=128",
          "--set",   "rig.time_of_flight.rows=96",
          "--set",   "rig.rgb.width_px=96",
          "--set",   "rig.rgb.height_px=64",
          "--set",   "ring_distances_m=[0.7, 0.7, 0.7]",
          "--set",   "knows_pose=true",
          "--set",   "render.irradiance_samples=16",
          "--set",   "render.edge_samples=16",
          "--set",   "render.board_texel_m=0.005",
          "--set",   "render.max_bounces=0"};
}

/// The dataset "FORMAT" in each of the formats.
void render_all(const Program& program) {
  for (const std::string format : {"npy", "exr", "png16"}) {
    const Outcome rendered =
        program.run(small_depth_camera() + Words{"--truth-format", format, "--out", format});
    ASSERT_EQ(rendered.code, 0) << rendered.err;
    EXPECT_EQ(program.run({"verify", format}).code, 0) << format;
  }
}

/// Largest difference of two depths; an error where one has a depth and the other has none.
double largest_difference(const Image<float>& a, const Image<float>& b) {
  double most = 0;
  EXPECT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size() && i < b.size(); ++i) {
    EXPECT_EQ(std::isnan(a.data()[i]), std::isnan(b.data()[i]));
    if (!std::isnan(a.data()[i]))
      most = std::max(most, std::abs(static_cast<double>(a.data()[i] - b.data()[i])));
  }
  return most;
}

TEST(AppTruthFormat, EveryFormatHoldsTheSameTruth) {
  const Program program;
  render_all(program);
  const auto scene = [&](const char* format) { return program.path(format) / "000000"; };
  for (const std::string folder : {"depth", "noise_free_depth"}) {
    const std::string stem = "truth/" + folder + "/000001";
    const Image<float> exr = read_exr(scene("exr") / (stem + ".exr"));
    EXPECT_EQ(largest_difference(read_npy(scene("npy") / (stem + ".npy")), exr), 0) << folder;
    EXPECT_LE(largest_difference(read_truth_depth(scene("png16"), stem + ".png"), exr), 0.51e-4)
        << folder;
  }
  const auto vectors = [&](const char* format, const std::string& folder) {
    return read_float_vectors(scene(format) /
                              float_file(scene(format), "truth/" + folder + "/000000"));
  };
  EXPECT_EQ(vectors("npy", "normal"), vectors("exr", "normal"));
  // PNG holds no signs: these are .npy.
  EXPECT_EQ(vectors("png16", "normal"), vectors("exr", "normal"));
  EXPECT_TRUE(fs::exists(scene("png16") / "truth/flow/000000.npy"));
  // All else is the same bytes.
  for (const char* file : {"rgb/000001.png", "depth/000001.png", "rig.json", "truth/camera.json",
                           "truth/invalid_reason/000001.png"}) {
    EXPECT_EQ(read_file(scene("npy") / file), read_file(scene("exr") / file)) << file;
    EXPECT_EQ(read_file(scene("png16") / file), read_file(scene("exr") / file)) << file;
  }
}

TEST(AppTruthFormat, ShardsAgreeAndARenderThatWasStoppedGoesOn) {
  const Program program;
  const Words render = small_depth_camera() + Words{"--truth-format", "png16"};
  ASSERT_EQ(program.run(render + Words{"--out", "whole"}).code, 0);
  ASSERT_EQ(program.run(render + Words{"--out", "data", "--shard", "1/2"}).code, 0);
  ASSERT_EQ(program.run(render + Words{"--out", "data", "--shard", "0/2"}).code, 0);
  auto files = contents(program.path("data"));
  EXPECT_EQ(files.erase("manifest.0-of-2.json") + files.erase("manifest.1-of-2.json"), 2U);
  EXPECT_EQ(files, contents(program.path("whole")));
  EXPECT_TRUE(files.contains("000000/truth/noise_free_depth/000001.json"));
  // A frame that lacks a scale is not there yet.
  const auto before = contents(program.path("whole"));
  fs::remove(program.path("whole/000000/truth/noise_free_depth/000001.json"));
  EXPECT_EQ(program.run(render + Words{"--out", "whole"}).code, 0);
  EXPECT_EQ(contents(program.path("whole")), before);
}

TEST(AppTruthFormat, AFolderHoldsOneFormat) {
  const Program program;
  const Words render = {"render", "seeds", "--quiet"};
  const Words depth = Words{"--truth", "depth"} + tiny_scene();
  ASSERT_EQ(program.run(render + depth + Words{"--out", "d"}).code, 0);
  const auto before = contents(program.path("d"));
  EXPECT_EQ(program.run(render + depth + Words{"--out", "d", "--truth-format", "npy"}).code, 0);
  for (const char* format : {"exr", "png16"}) {
    const Outcome other =
        program.run(render + depth + Words{"--out", "d", "--truth-format", format});
    EXPECT_EQ(other.code, 2);
    EXPECT_THAT(other.err, HasSubstr("choice of truth or of its format"));
  }
  EXPECT_EQ(contents(program.path("d")), before);
  // Without an image of floats there is nothing to differ.
  ASSERT_EQ(program.run(render + tiny_scene() + Words{"--out", "v"}).code, 0);
  EXPECT_EQ(program.run(render + tiny_scene() + Words{"--out", "v", "--truth-format", "exr"}).code,
            0);
  const Outcome unknown =
      program.run(render + tiny_scene() + Words{"--out", "n", "--truth-format", "tiff"});
  EXPECT_EQ(unknown.code, 2);
  EXPECT_THAT(unknown.err, HasSubstr("--truth-format \"tiff\" is not one of npy, exr, png16"));
  EXPECT_FALSE(fs::exists(program.path("n")));
}

/// Rows y, x, depth in metres of the PNG and of the .npy, and the .npy's normal: as numpy and cv2
/// read them.
constexpr const char* kReader = R"(
import json, sys
import numpy
scene, out = sys.argv[1:]
depth = numpy.load('npy/000000/truth/depth/000001.npy')
normal = numpy.load('npy/000000/truth/normal/000001.npy')
assert depth.dtype == numpy.float32 and normal.shape == depth.shape + (3,), (depth.dtype, normal.shape)
png = None
if scene == 'cv2':
    import cv2
    codes = cv2.imread('png16/000000/truth/depth/000001.png', cv2.IMREAD_UNCHANGED)
    assert codes.dtype == numpy.uint16 and codes.shape == depth.shape, (codes.dtype, codes.shape)
    png = codes * json.load(open('png16/000000/truth/depth/000001.json'))['depth_scale'] / 1000
    png[codes == 0] = numpy.nan
    # What numpy read is an image to cv2.
    half = cv2.resize(depth, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_NEAREST)
    assert half.shape == (depth.shape[0] // 2, depth.shape[1] // 2), half.shape
with open(out, 'w') as file:
    for y in range(depth.shape[0]):
        for x in range(depth.shape[1]):
            values = [depth[y, x], png[y, x] if png is not None else depth[y, x], *normal[y, x]]
            file.write(' '.join([str(y), str(x)] + [repr(float(v)) for v in values]) + '\n')
)";

TEST(AppTruthFormat, NumpyAndCv2ReadWhatTheExrHolds) {
  // Debian's, whatever else is first on the path: scripts/setup test installs both for it.
  if (std::system("/usr/bin/python3 -c 'import numpy' 2>/dev/null") != 0)
    GTEST_SKIP() << "/usr/bin/python3 has no numpy (Debian: python3-numpy)";
  const bool has_cv2 = std::system("/usr/bin/python3 -c 'import cv2' 2>/dev/null") == 0;
  const Program program;
  render_all(program);
  write_file(program.path("read.py"), kReader);
  const std::string command = "cd '" + program.path().string() + "' && /usr/bin/python3 read.py " +
                              (has_cv2 ? "cv2" : "numpy") + " values > said 2>&1";
  ASSERT_EQ(std::system(command.c_str()), 0) << read_file(program.path("said"));
  const Image<float> depth_m = read_exr(program.path("exr/000000/truth/depth/000001.exr"));
  const Image<Eigen::Vector3f> normal =
      read_exr_vectors(program.path("exr/000000/truth/normal/000001.exr"));
  std::ifstream rows(program.path("values"));
  std::size_t count = 0, with_depth = 0;
  std::string word[7];
  while (rows >> word[0] >> word[1] >> word[2] >> word[3] >> word[4] >> word[5] >> word[6]) {
    const int y = std::stoi(word[0]), x = std::stoi(word[1]);
    ++count;
    const double exr = static_cast<double>(depth_m(x, y));
    EXPECT_EQ(std::isnan(exr), word[2] == "nan");
    EXPECT_EQ(std::isnan(exr), word[3] == "nan");
    for (int k = 0; k < 3; ++k)
      EXPECT_EQ(std::stod(word[4 + k]), static_cast<double>(normal(x, y)[k])) << x << ' ' << y;
    if (std::isnan(exr)) continue;
    ++with_depth;
    EXPECT_EQ(std::stod(word[2]), exr) << x << ' ' << y;
    EXPECT_NEAR(std::stod(word[3]), exr, 0.51e-4) << x << ' ' << y;
  }
  EXPECT_EQ(count, depth_m.size());
  EXPECT_GT(with_depth, count / 2);
  if (!has_cv2) GTEST_SKIP() << "numpy reads the truth; python3 has no cv2 (python3-opencv)";
}

}  // namespace
}  // namespace cousin
