#include "benchmarks/suites/sensors/sensors_suite.h"

#include <functional>
#include <string>
#include <utility>

#include "benchmarks/suites/sensors/colour_rows.h"
#include "benchmarks/suites/sensors/depth_rows.h"
#include "benchmarks/suites/sensors/fit_sensor_rows.h"
#include "benchmarks/suites/sensors/passive_rows.h"
#include "benchmarks/suites/sensors/ranging_rows.h"
#include "benchmarks/suites/sensors/sensor_row.h"
#include "sim/sensors/active_stereo.h"
#include "sim/types/stage_clock.h"

namespace cousin {
namespace {

struct Part {
  std::string name;  ///< of its result's file, too
  std::function<std::vector<ScoreRow>(std::uint64_t seed, bool quick)> run;
};

std::vector<Part> list_parts() {
  std::vector<Part> parts = {{"colour-cameras", colour_rows}};
  for (const std::string& rig : active_stereo_preset_names()) {
    parts.push_back({"depth-" + rig, [rig](std::uint64_t seed, bool quick) {
                       return depth_rows_of(rig, seed, quick);
                     }});
  }
  parts.push_back({"depth-speed", depth_speed_rows});
  parts.push_back({"passive-stereo", passive_stereo_rows});
  parts.push_back({"fit-sensor", fit_sensor_rows});
  parts.push_back({"ranging", ranging_rows});
  return parts;
}

std::string run_part(const Part& part, std::uint64_t seed, bool quick) {
  const StageClock clock(part.name);
  ScoreFile file;
  file.scores = part.run(seed, quick);
  const double wall_s = clock.finish().wall_s;
  ScoreRow seconds = sensor_row({part.name, seed}, "all", "seconds", wall_s, "s", 1);
  seconds.wall_s = wall_s;
  file.scores.push_back(std::move(seconds));
  return to_json(file);
}

}  // namespace

std::vector<ShardJob> sensors_suite_jobs(std::uint64_t seed, bool quick) {
  const std::vector<Part> parts = list_parts();
  Factor part_factor{"part", {}};
  for (const Part& part : parts) part_factor.levels.push_back({part.name});
  const std::string ending = quick ? ".quick" : "";
  std::vector<ShardJob> jobs;
  for (GridJob& place : jobs_of({{"{part}" + ending, {part_factor}}})) {
    const Part& part = parts[place.at("part").level];
    const std::string key = std::string(COUSIN_VERSION) + "/" + std::to_string(seed) +
                            (quick ? "/quick" : "") + "/" + part.name;
    jobs.push_back(shard_of(std::move(place), key,
                            [part, seed, quick] { return run_part(part, seed, quick); }));
  }
  return jobs;
}

}  // namespace cousin
