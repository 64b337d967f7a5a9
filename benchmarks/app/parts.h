#pragma once

#include <string>
#include <string_view>

namespace cousin {

/// A module of the program. The first holds what a first report needs; the others are built when
/// somebody asks for them.
struct Part {
  const char* name;  ///< as `scripts/build` takes it
  const char* file;  ///< beside the program
};
inline constexpr Part kJobsPart = {"jobs", "libcousin_jobs.so"};
/// The first part's verbs with every scene and with poses by COLMAP, and import and export.
inline constexpr Part kScenesPart = {"scenes", "libcousin_scenes.so"};
inline constexpr Part kBenchPart = {"bench", "libcousin_bench.so"};
inline constexpr Part kCalibratePart = {"calibrate", "libcousin_calibrate.so"};
inline constexpr Part kFitSensorPart = {"fit-sensor", "libcousin_fit_sensor.so"};

/// "not built in; build them with: scripts/build NAME"
inline std::string how_to_build(std::string_view part) {
  return "not built in; build it with: scripts/build " + std::string(part);
}

/// The part that holds a verb.
constexpr Part part_of(std::string_view verb) {
  if (verb == "import" || verb == "export") return kScenesPart;
  if (verb == "bench") return kBenchPart;
  if (verb == "calibrate" || verb == "board") return kCalibratePart;
  if (verb == "fit-sensor") return kFitSensorPart;
  return kJobsPart;
}

}  // namespace cousin
