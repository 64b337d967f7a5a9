#include "benchmarks/suites/seedlings/published_psnr.h"

#include <array>

#include "benchmarks/suites/seedlings/field_training.h"
#include "benchmarks/suites/seedlings/seedlings_rows.h"

namespace cousin {
namespace {

struct PublishedNumber {
  double minutes, psnr_db;
};
/// A line of tables 2 to 4: Gaussians after 7,000 and 30,000 iterations, Instant-NGP.
struct PublishedSample {
  const char* light;
  int sample;
  std::array<PublishedNumber, 3> numbers;
};
constexpr PublishedSample kPublished[] = {
    {"D1", 1, {{{5.38, 25.22}, {30.03, 32.31}, {3.05, 21.28}}}},
    {"D1", 2, {{{5.87, 26.02}, {27.65, 32.09}, {3.13, 21.65}}}},
    {"D1", 3, {{{6, 25.55}, {30.85, 39.17}, {3.82, 20.77}}}},
    {"D1", 4, {{{5.45, 24.64}, {31.52, 33.67}, {3.18, 20.25}}}},
    {"D1", 5, {{{6.15, 26.11}, {29.38, 35.61}, {3.65, 21.02}}}},
    {"D1", 6, {{{5.77, 30.34}, {29.85, 39.01}, {3.45, 21.84}}}},
    {"D1", 7, {{{5.82, 27.4}, {27.98, 35.11}, {3.58, 20.34}}}},
    {"D1", 8, {{{6.03, 27.49}, {29.62, 36.37}, {3.98, 20.67}}}},
    {"D1", 9, {{{5.35, 27.4}, {27.55, 35.11}, {3.25, 20.14}}}},
    {"D1", 10, {{{5.67, 16.51}, {22.87, 22.31}, {3.33, 13.27}}}},
    {"D1", 11, {{{6.35, 18.2}, {24.65, 23.56}, {4.11, 14.54}}}},
    {"D1", 12, {{{5.82, 24.63}, {28.45, 31.68}, {3.87, 19.51}}}},
    {"D2", 1, {{{6.77, 24.72}, {31.55, 32.64}, {3.87, 20.96}}}},
    {"D2", 2, {{{7.02, 27.65}, {33.25, 36.57}, {4.3, 21.88}}}},
    {"D2", 3, {{{5.87, 27.52}, {30.62, 35.97}, {3.55, 21.24}}}},
    {"D2", 4, {{{6.55, 27.42}, {32.45, 37.43}, {3.67, 19.32}}}},
    {"D2", 5, {{{6.52, 25.23}, {34.21, 34.97}, {3.82, 20.85}}}},
    {"D2", 6, {{{6.32, 28.37}, {33.3, 36.65}, {3.58, 21.98}}}},
    {"D2", 7, {{{6.45, 26.07}, {33.75, 35.78}, {3.45, 20.65}}}},
    {"D2", 8, {{{6.77, 25.74}, {32.25, 33.8}, {3.13, 20.14}}}},
    {"D2", 9, {{{5.98, 27.12}, {29.82, 36.64}, {3.85, 22.54}}}},
    {"D2", 10, {{{6.77, 25.84}, {34.52, 33.75}, {4.03, 20.32}}}},
    {"D2", 11, {{{6.21, 24.51}, {30.85, 31.55}, {4.48, 19.85}}}},
    {"D2", 12, {{{6.13, 25.98}, {29.77, 33.87}, {3.7, 20.66}}}},
    {"D3", 1, {{{6.18, 26.16}, {29.85, 33.43}, {4.14, 23.66}}}},
    {"D3", 2, {{{5.93, 23.94}, {30.03, 30.85}, {3.35, 21.54}}}},
    {"D3", 3, {{{6.1, 28.6}, {23.58, 34.47}, {3.77, 21.72}}}},
    {"D3", 4, {{{6.21, 25.65}, {32.65, 33.95}, {3.68, 19.41}}}},
    {"D3", 5, {{{6.33, 28.61}, {23.68, 34.62}, {4.32, 23.85}}}},
    {"D3", 6, {{{6.17, 17.15}, {23.45, 24.9}, {3.7, 14.32}}}},
    {"D3", 7, {{{5.85, 25.53}, {28.7, 32.55}, {3.82, 20.25}}}},
    {"D3", 8, {{{6.11, 31.1}, {23.48, 36.61}, {3.97, 23.11}}}},
    {"D3", 9, {{{5.87, 26.16}, {28.63, 34.14}, {3.35, 20.74}}}},
    {"D3", 10, {{{5.97, 26.34}, {23.77, 34.93}, {3.55, 20.25}}}},
    {"D3", 11, {{{6.3, 25.96}, {26.97, 32.76}, {3.82, 20.66}}}},
    {"D3", 12, {{{6.18, 24.6}, {27.8, 32.05}, {3.8, 19.58}}}}};

constexpr double kMinute_s = 60;

}  // namespace

std::vector<ScoreRow> published_rows() {
  struct Column {
    const char* method;
    int steps;  ///< the paper gives none of Instant-NGP
  };
  constexpr Column kColumns[] = {
      {kPublishedGaussians, 7000}, {kPublishedGaussians, 30000}, {kPublishedNgp, 0}};
  std::vector<ScoreRow> rows;
  for (const PublishedSample& line : kPublished) {
    for (std::size_t i = 0; i < line.numbers.size(); ++i) {
      ScoreRow row;
      row.suite = kSeedlingsSuite;
      row.scene = line.light;
      row.case_name = "sample S" + std::to_string(line.sample) + ", 30 photographs, RTX 4090";
      if (kColumns[i].steps > 0)
        row.case_name += ", " + std::to_string(kColumns[i].steps) + " steps";
      row.method = kColumns[i].method;
      row.metric = "psnr";
      row.run = line.sample;
      row.views = 30;
      row.light = line.light;
      row.steps = kColumns[i].steps;
      row.value = line.numbers[i].psnr_db;
      row.unit = "dB";
      row.n = 1;
      row.wall_s = kMinute_s * line.numbers[i].minutes;
      rows.push_back(row);
    }
  }
  return rows;
}

}  // namespace cousin
