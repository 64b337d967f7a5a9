#include "benchmarks/real/real_suite.h"

#include <array>
#include <exception>

#include "benchmarks/real/fox_stereo.h"
#include "benchmarks/real/maize_carving.h"
#include "benchmarks/real/real_rows.h"
#include "benchmarks/real/rice_grains.h"

namespace cousin {
namespace {

struct Part {
  const char* name;
  std::vector<ScoreRow> (*run)(const std::filesystem::path& real_data,
                               const std::filesystem::path& out, bool quick);
};
constexpr std::array<Part, 3> kParts = {
    {{"maize", maize_carving_rows}, {"rice", rice_grain_rows}, {"fox", fox_stereo_rows}}};

}  // namespace

ScoreFile real_suite(const std::filesystem::path& real_data, const std::filesystem::path& out,
                     bool quick, const Progress& progress) {
  ScoreFile file;
  int done = 0;
  for (const Part& part : kParts) {
    if (progress) progress(part.name, done++, static_cast<int>(kParts.size()));
    try {
      for (ScoreRow& row : part.run(real_data, out, quick)) file.scores.push_back(std::move(row));
    } catch (const std::exception& error) {
      ScoreRow row = not_solved_row(part.name, part.name, error.what());
      row.status = ScoreStatus::error;
      file.scores.push_back(row);
    }
  }
  return file;
}

}  // namespace cousin
