#include "benchmarks/suites/real/real_suite.h"

#include <algorithm>
#include <array>
#include <exception>
#include <iterator>

#include "benchmarks/suites/real/cones_stereo.h"
#include "benchmarks/suites/real/fox_stereo.h"
#include "benchmarks/suites/real/maize_carving.h"
#include "benchmarks/suites/real/real_rows.h"
#include "benchmarks/suites/real/rice_grains.h"

namespace cousin {
namespace {

struct Part {
  const char* name;
  RealPart (*run)(const std::filesystem::path& real_data, const std::filesystem::path& out,
                  bool quick);
};
constexpr std::array<Part, 4> kParts = {{{"maize", maize_carving},
                                         {"rice", rice_grains},
                                         {"fox", fox_stereo},
                                         {"cones", cones_stereo}}};

template <class T>
void append(std::vector<T>& all, std::vector<T>& some) {
  std::move(some.begin(), some.end(), std::back_inserter(all));
}

}  // namespace

RealResult real_suite(const std::filesystem::path& real_data, const std::filesystem::path& out,
                      bool quick, const Progress& progress) {
  RealResult result;
  int done = 0;
  for (const Part& part : kParts) {
    if (progress) progress(part.name, done++, static_cast<int>(kParts.size()));
    try {
      RealPart made = part.run(real_data, out, quick);
      append(result.file.scores, made.rows);
      append(result.page.images, made.images);
      append(result.page.shapes, made.shapes);
      append(result.page.distributions, made.distributions);
    } catch (const std::exception& error) {
      ScoreRow row = not_solved_row(part.name, part.name, error.what());
      row.status = ScoreStatus::error;
      result.file.scores.push_back(row);
    }
  }
  return result;
}

}  // namespace cousin
