#include "benchmarks/sensors/sensors_suite.h"

#include <exception>
#include <functional>
#include <vector>

#include "benchmarks/sensors/colour_rows.h"
#include "benchmarks/sensors/depth_rows.h"
#include "benchmarks/sensors/fit_sensor_rows.h"
#include "benchmarks/sensors/passive_rows.h"
#include "benchmarks/sensors/ranging_rows.h"
#include "benchmarks/sensors/sensor_row.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

struct Part {
  const char* name;
  std::function<std::vector<ScoreRow>(std::uint64_t seed, bool quick)> run;
};

}  // namespace

ScoreFile sensors_suite(std::uint64_t seed, bool quick, const Progress& progress) {
  const std::vector<Part> parts = {{"colour cameras", colour_rows},
                                   {"depth cameras", depth_rows},
                                   {"passive stereo", passive_stereo_rows},
                                   {"fit-sensor", fit_sensor_rows},
                                   {"time of flight, structured light", ranging_rows}};
  ScoreFile file;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (progress) progress(parts[i].name, static_cast<int>(i), static_cast<int>(parts.size()));
    const StageClock clock(parts[i].name);
    const SensorRows of{parts[i].name, seed};
    try {
      const std::vector<ScoreRow> rows = parts[i].run(seed, quick);
      file.scores.insert(file.scores.end(), rows.begin(), rows.end());
    } catch (const std::exception& error) {
      ScoreRow row = sensor_row(of, "all", error.what(), ScoreRow::kNone, "1", 0);
      row.status = ScoreStatus::error;
      file.scores.push_back(row);
    }
    const double wall_s = clock.finish().wall_s;
    ScoreRow seconds = sensor_row(of, "all", "seconds", wall_s, "s", 1);
    seconds.wall_s = wall_s;
    file.scores.push_back(seconds);
  }
  return file;
}

}  // namespace cousin
