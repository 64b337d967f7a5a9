#include "benchmarks/suites/seeds/published_seeds.h"

#include <array>
#include <string>

#include "benchmarks/loop/score_geometry.h"
#include "benchmarks/loop/score_seeds.h"

namespace cousin {
namespace {

constexpr const char* kGaussians = "published: 3DGS";
constexpr const char* kStereo = "published: SfM-MVS";
constexpr const char* kRadianceField = "published: Instant-NGP";
constexpr double kPercent = 0.01, kMillimetre_m = 0.001;

struct Reconstruction {  // table 1
  const char* method;
  int steps;  ///< 0: it has none
  double seconds;
  int points;
};
constexpr Reconstruction kReconstructions[] = {{kStereo, 0, 757, 77416},
                                               {kGaussians, 5000, 624, 182404},
                                               {kGaussians, 7000, 694, 198203},
                                               {kGaussians, 10000, 804, 228321},
                                               {kGaussians, 30000, 1744, 261540}};

struct Agreement {
  double r2, mape_percent, rmse_mm;
};
struct Lengths {  // tables 2 and 4
  const char* cultivar;
  const char* method;
  std::array<Agreement, 3> of;  ///< length, width, height
};
constexpr Lengths kLengths[] = {
    {"zhengdan958", kGaussians, {{{.9361, 1.91, .304}, {.8889, 3.99, .464}, {.946, 3.66, .34}}}},
    {"zhengdan958", kStereo, {{{.812, 2.97, .501}, {.777, 4.35, .554}, {.8917, 5.76, .553}}}},
    {"tianguinuo932", kGaussians, {{{.9372, 3.96, .38}, {.9042, 2.37, .201}, {.9031, 9.11, .51}}}},
    {"jimai22", kGaussians, {{{.8527, 1.45, .118}, {.8643, 2.87, .124}, {.8661, 3.38, .137}}}},
    {"aikang58", kGaussians, {{{.9264, 2, .156}, {.8452, 4.01, .199}, {.8637, 2.54, .115}}}},
    {"suijing18", kGaussians, {{{.8998, 2.31, .216}, {.8402, 6.04, .193}, {.807, 8.34, .222}}}},
    {"xiangyaxiangzhan",
     kGaussians,
     {{{.9644, 3.04, .329}, {.8428, 9.63, .257}, {.8588, 9.1, .197}}}}};

struct ImageQuality {  // tables 3 and 5
  const char* cultivar;
  double ssim, psnr_db, lpips;
  double at_30000_db, at_7000_db, ngp_db;
};
constexpr ImageQuality kImageQuality[] = {
    {"zhengdan958", .9537, 35.74, .0528, 35.74, 33.64, 33.398},
    {"tianguinuo932", .9628, 37.13, .0529, 37.13, 34.88, 33.028},
    {"jimai22", .9629, 35.66, .0582, 35.87, 34.89, 32.994},
    {"aikang58", .9587, 35.87, .057, 35.66, 34.94, 33.376},
    {"suijing18", .9664, 36.75, .048, 36.75, 33.9, 32.954},
    {"xiangyaxiangzhan", .9691, 37.31, .047, 37.31, 34.13, 33.586}};

// In its text, of a sphere of 22 mm.
constexpr double kSphereArea_percent = 1.67, kSphereVolume_percent = 1.14;

/// In its text, of Zhengdan 958: means over specimens, 3DGS less SfM-MVS. Both are of length: the
/// percentages are table 2's, and 0.2223 mm is 1.91 % of a grain of 11.6 mm. An "RMSE" of one
/// specimen's one length is its absolute error.
struct PairedTest {
  const char* metric;
  double gaussians, stereo, t, p;
  double unit_si;
  const char* unit;
};
constexpr PairedTest kPairedTests[] = {
    {"length.absolute", .2223, .3450, -2.539, .0143, kMillimetre_m, "m"},
    {"length.relative", 1.91, 2.98, -2.569, .0133, kPercent, "1"}};

ScoreRow base_row(const char* scene, const char* method, int steps) {
  ScoreRow row;
  row.suite = kSplatsSuite;
  row.scene = scene;
  row.case_name = "270 photographs 1920x1080, RTX 4060 Ti";
  if (steps > 0) row.case_name += ", " + std::to_string(steps) + " steps";
  row.views = 270;
  row.width_px = 1920;
  row.height_px = 1080;
  row.steps = steps;
  row.method = method;
  return row;
}

}  // namespace

std::vector<ScoreRow> published_seeds_rows() {
  std::vector<ScoreRow> rows;
  for (const Reconstruction& line : kReconstructions) {
    ScoreRow row = base_row("pooled", line.method, line.steps);
    row.wall_s = line.seconds;
    rows.push_back(measured_row(row, "seconds.reconstruction", line.seconds, "s", 1));
    rows.push_back(measured_row(row, "reconstruction.points", line.points, "1", 1));
  }
  constexpr const char* kTraits[] = {"length", "width", "height"};
  for (const Lengths& line : kLengths) {
    const ScoreRow row = base_row(line.cultivar, line.method, 0);
    for (std::size_t i = 0; i < line.of.size(); ++i) {
      const std::string trait = kTraits[i];
      rows.push_back(measured_row(row, trait + ".r2_paper", line.of[i].r2, "1", 50));
      rows.push_back(
          measured_row(row, trait + ".mape", kPercent * line.of[i].mape_percent, "1", 50));
      rows.push_back(
          measured_row(row, trait + ".rmse", kMillimetre_m * line.of[i].rmse_mm, "m", 50));
    }
  }
  for (const ImageQuality& line : kImageQuality) {
    const ScoreRow whole = base_row(line.cultivar, kGaussians, 0);
    rows.push_back(measured_row(whole, "ssim", line.ssim, "1", 1));
    rows.push_back(measured_row(whole, "psnr", line.psnr_db, "dB", 1));
    rows.push_back(measured_row(whole, "lpips", line.lpips, "1", 1));
    rows.push_back(measured_row(base_row(line.cultivar, kGaussians, 30000), "psnr",
                                line.at_30000_db, "dB", 1));
    rows.push_back(
        measured_row(base_row(line.cultivar, kGaussians, 7000), "psnr", line.at_7000_db, "dB", 1));
    rows.push_back(
        measured_row(base_row(line.cultivar, kRadianceField, 0), "psnr", line.ngp_db, "dB", 1));
  }
  const ScoreRow sphere = base_row(kSphere, kGaussians, 0);
  rows.push_back(measured_row(sphere, "area.mape", kPercent * kSphereArea_percent, "1", 1));
  rows.push_back(measured_row(sphere, "volume.mape", kPercent * kSphereVolume_percent, "1", 1));
  for (const PairedTest& test : kPairedTests) {
    const std::string metric = test.metric;
    ScoreRow both = base_row("zhengdan958", kGaussians, 0);
    both.method += "/SfM-MVS";
    rows.push_back(measured_row(both, metric + "_difference",
                                test.unit_si * (test.gaussians - test.stereo), test.unit, 50));
    rows.push_back(
        measured_row(both, metric == "length.absolute" ? "length.paired_t" : metric + "_paired_t",
                     test.t, "1", 50));
    rows.push_back(measured_row(
        both, metric == "length.absolute" ? "length.paired_t_p" : metric + "_paired_t_p", test.p,
        "1", 50));
  }
  return rows;
}

}  // namespace cousin
