// calibrate as a user calls it: photographs of a board to cameras, and what it refuses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "sim/dataset/atomic_file.h"
#include "sim/imaging/image_io.h"
#include "tests/benchmarks/app/program.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

/// A board of 6 x 4 inner corners through a pinhole, by its homography, 16 samples a pixel.
void photograph(const fs::path& file, double yaw_rad, double pitch_rad, double distance) {
  constexpr int kWidth = 320, kHeight = 240;
  constexpr double kFocal = 330;
  Image<std::uint8_t> image(kWidth, kHeight);
  const double cy = std::cos(yaw_rad), sy = std::sin(yaw_rad), cp = std::cos(pitch_rad),
               sp = std::sin(pitch_rad);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      int white = 0;
      for (int k = 0; k < 16; ++k) {
        const double u = (x - 0.5 + (k % 4 + 0.5) / 4 - 159) / kFocal;
        const double v = (y - 0.5 + (k / 4 + 0.5) / 4 - 121) / kFocal;
        // Axes of the board in the camera: (cy, sp sy, -cp sy) and (0, cp, sp); its normal after.
        const double normal[3] = {sy, -sp * cy, cp * cy};
        const double t = distance * normal[2] / (u * normal[0] + v * normal[1] + normal[2]);
        const double p[3] = {t * u, t * v, t - distance};
        const double a = p[0] * cy + p[1] * sp * sy - p[2] * cp * sy, b = p[1] * cp + p[2] * sp;
        const bool inside = std::abs(a) < 3.5 && std::abs(b) < 2.5;
        const int square =
            static_cast<int>(std::floor(a + 3.5)) + static_cast<int>(std::floor(b + 2.5));
        white += !(inside && square % 2 == 0);
      }
      image(x, y) = static_cast<std::uint8_t>(40 + 12 * white);
    }
  }
  write_png(file, image);
}

void write_photographs(const fs::path& folder) {
  const double turns[8][2] = {{0, 0},     {0.5, 0.1}, {-0.5, 0.2}, {0.1, 0.5},
                              {0, -0.55}, {0.4, 0.4}, {-0.4, 0.3}, {0.3, -0.4}};
  for (int i = 0; i < 8; ++i) {
    photograph(folder / ("view" + std::to_string(i) + ".png"), turns[i][0], turns[i][1],
               10 + i % 3);
  }
}

TEST(AppCalibrate, PhotographsBecomeACameraForOtherPrograms) {
#ifdef COUSIN_NO_CERES
  const Words solver = {"--solver", "opencv"};
#else
  const Words solver = {};
#endif
  const Program program;
  write_photographs(program.path("photos"));
  const Words words = {"calibrate", "photos",  "--board", "chessboard:6x4:0.030",
                       "--model",   "opencv5", "--fix",   "k1,k2,k3,p1,p2",
                       "--out",     "out",     "--json"};
  const Outcome run = program.run(words + solver);
  ASSERT_EQ(run.code, 0) << run.err << run.out;
  const auto json = nlohmann::json::parse(run.out, nullptr, false);
  ASSERT_FALSE(json.is_discarded());
  const auto& fx = json["cameras"][0]["parameters"]["fx_px"];
  // Sixteen samples place an edge to a hundredth of a pixel; 192 corners of it.
  EXPECT_NEAR(fx["value"].get<double>(), 330, 1);
  EXPECT_GT(fx["deviation"].get<double>(), 0);
  EXPECT_EQ(read_file(program.path("out/calibration.json")), run.out);
  EXPECT_THAT(read_file(program.path("out/opencv/camera.yaml")), HasSubstr("camera_matrix"));
  EXPECT_THAT(read_file(program.path("out/report.html")),
              AllOf(HasSubstr("where to hold the board next"), HasSubstr("</html>")));
}

TEST(AppCalibrate, WrongWordsAndImagesAreNamed) {
  const Program program;
  write_photographs(program.path("photos"));
  const Outcome no_board = program.run({"calibrate", "photos"});
  EXPECT_EQ(no_board.code, 2);
  EXPECT_THAT(no_board.err, HasSubstr("--board"));
  const Outcome form = program.run({"calibrate", "photos", "--board", "chess:6x4:0.03"});
  EXPECT_EQ(form.code, 2);
  EXPECT_THAT(form.err, AllOf(HasSubstr("chess:6x4:0.03"), HasSubstr("COLUMNSxROWS")));
  const Outcome model =
      program.run({"calibrate", "photos", "--board", "chessboard:6x4:0.03", "--model", "mirror"});
  EXPECT_EQ(model.code, 2);
  EXPECT_THAT(model.err, AllOf(HasSubstr("mirror"), HasSubstr("kannala_brandt4")));
  const Outcome none = program.run({"calibrate", "nowhere", "--board", "chessboard:6x4:0.03"});
  EXPECT_EQ(none.code, 3);
  EXPECT_THAT(none.err, HasSubstr("nowhere"));
  const Outcome size = program.run({"calibrate", "photos", "--board", "chessboard:5x4:0.03"});
  EXPECT_EQ(size.code, 3);
  EXPECT_THAT(size.err, AllOf(HasSubstr("view0.png"), HasSubstr("wrong size")));
  write_png(program.path("photos/view9.png"), Image<std::uint8_t>(100, 80, 90));
  const Outcome sizes = program.run({"calibrate", "photos", "--board", "chessboard:6x4:0.03"});
  EXPECT_EQ(sizes.code, 3);
  EXPECT_THAT(sizes.err, AllOf(HasSubstr("view9.png: 100 x 80"), HasSubstr("320 x 240")));
  EXPECT_FALSE(fs::exists(program.path("out/calibrate/calibration.json")));
}

TEST(AppBoard, IsWrittenAsPdfAndSvgAndNothingElseIsLost) {
  const Program program;
  const Outcome made =
      program.run({"board", "seeds", "--paper", "a4", "--out", "kit.pdf", "--json"});
  EXPECT_EQ(made.code, 0) << made.err;
  const nlohmann::json said = nlohmann::json::parse(made.out);
  EXPECT_EQ(said["pages"], 3);
  EXPECT_EQ(said["paper"], "a4");
  const std::string pdf = read_file(program.path("kit.pdf"));
  EXPECT_TRUE(pdf.starts_with("%PDF-1.4"));
  EXPECT_EQ(program.run({"board", "seeds", "--paper", "a4", "--out", "kit.pdf"}).code, 0);
  EXPECT_EQ(program.run({"board", "charuco:11x8:0.022:0.73:DICT_4X4_50", "--out", "c.svg"}).code,
            0);
  EXPECT_THAT(read_file(program.path("c.svg")), testing::HasSubstr("<svg"));
  write_file(program.path("mine.pdf"), "%PDF-1.7 somebody's");
  const Outcome kept = program.run({"board", "seeds", "--out", "mine.pdf"});
  EXPECT_EQ(kept.code, 2);
  EXPECT_EQ(read_file(program.path("mine.pdf")), "%PDF-1.7 somebody's");
  const Outcome wrong = program.run({"board", "seeds", "--out", "board.png"});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_THAT(wrong.err, testing::HasSubstr(".pdf or .svg"));
  EXPECT_EQ(program.run({"board", "charuco_a2", "--paper", "a4"}).code, 2);
  EXPECT_EQ(program.run({"board", "no_such_board"}).code, 2);
}

}  // namespace
}  // namespace cousin
