#include <filesystem>
#include <sstream>
#include <string>

#include "perception/sfm/colmap_run.h"
#include "sim/dataset/atomic_file.h"
#include "sim/process/program_run.h"
#include "sim/process/scratch_folder.h"

namespace cousin {
namespace fs = std::filesystem;

std::string colmap_version(const std::string& program) {
  if (find_program(program).empty()) return "";
  const ScratchFolder scratch("cousin-colmap");
  const fs::path log = scratch.path() / "help.log";
  constexpr double kLimit_s = 60;
  const ProgramOutcome outcome = run_program({.words = {program, "help"},
                                              .environment = {{"QT_QPA_PLATFORM", "offscreen"}},
                                              .log = log,
                                              .time_limit_s = kLimit_s});
  if (!succeeded(outcome)) return "";
  // "COLMAP 3.8 -- Structure-from-Motion and Multi-View Stereo"
  std::istringstream words(read_file(log));
  std::string name, version;
  words >> name >> version;
  return name == "COLMAP" ? version.substr(0, 40) : "";
}

}  // namespace cousin
