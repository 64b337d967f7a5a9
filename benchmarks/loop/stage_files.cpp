#include "benchmarks/loop/stage_files.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <memory>
#include <stdexcept>
#include <utility>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/capture_io.h"
#include "sim/process/program_run.h"
#include "sim/process/scratch_folder.h"
#include "sim/types/whole_file.h"

namespace cousin {
namespace fs = std::filesystem;
namespace {

void call_program(const StageSource& source, const fs::path& input, const fs::path& output) {
  const ProgramOutcome outcome =
      run_program({.words = {source.path.string(), input.string(), output.string()},
                   .time_limit_s = source.time_limit_s});
  if (succeeded(outcome)) return;
  const bool is_late = outcome.end == ProgramEnd::timed_out;
  throw std::runtime_error(outcome.reason + (is_late ? " (--stage-time-limit)" : ""));
}

/// The input of a stage's program could not be written: a full disk, not the program's fault.
class StageInputError : public std::runtime_error {
 public:
  using runtime_error::runtime_error;
};

/// A scratch folder with input/, the capture and the seams before a stage, and an empty output/.
std::unique_ptr<ScratchFolder> stage_folder(const std::string& stage, StageOrder order,
                                            const Capture& capture, const Estimate& so_far,
                                            int scene_index) {
  try {
    auto folder = std::make_unique<ScratchFolder>("cousin-stage");
    const fs::path input = folder->path() / "input";
    write_capture(input, capture);
    for (const std::string_view earlier : order) {
      if (earlier == stage) break;
      stage_row(earlier).write(input, so_far, scene_index);
    }
    fs::create_directories(folder->path() / "output");
    return folder;
  } catch (const std::runtime_error& error) {
    throw StageInputError("the input of its program could not be written: " +
                          std::string(error.what()));
  }
}

/// The folder of files that somebody gave, or one that a program fills when it is asked for.
SeamFolder folder_of(const StageSource& source, StageOrder order, int scene_index) {
  if (source.kind == StageSource::Kind::directory) {
    return [source, scene_index](const Capture&, const Estimate&) {
      const fs::path below = source.path / scene_id(scene_index);
      return std::make_shared<const fs::path>(fs::is_directory(below) ? below : source.path);
    };
  }
  return [source, order, scene_index](const Capture& capture, const Estimate& so_far) {
    const std::shared_ptr<ScratchFolder> folder =
        stage_folder(source.stage, order, capture, so_far, scene_index);
    const fs::path output = folder->path() / "output";
    call_program(source, folder->path() / "input", output);
    return std::shared_ptr<const fs::path>(new fs::path(output),
                                           [folder](const fs::path* path) { delete path; });
  };
}

}  // namespace

std::string scene_id(int scene_index) {
  char text[16];
  std::snprintf(text, sizeof text, "%06d", scene_index);
  return text;
}

std::string to_text(const StageSource& source) {
  return (source.kind == StageSource::Kind::program ? "exec:" : "dir:") + source.path.string();
}

StageSource parse_stage_source(const std::string& text, double time_limit_s) {
  const auto fail = [&](const std::string& why) {
    throw std::invalid_argument("--stage \"" + text + "\": " + why +
                                "; write NAME=dir:PATH or NAME=exec:PROGRAM");
  };
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) fail("there is no '='");
  StageSource source;
  source.time_limit_s = time_limit_s;
  source.stage = text.substr(0, equals);
  try {
    stage_row(source.stage);
  } catch (const std::invalid_argument& error) {
    fail(error.what());
  }
  const std::string rest = text.substr(equals + 1);
  if (rest.starts_with("dir:")) {
    source.path = rest.substr(4);
    if (!fs::is_directory(source.path))
      fail("folder \"" + source.path.string() + "\" does not exist");
  } else if (rest.starts_with("exec:")) {
    source.kind = StageSource::Kind::program;
    source.path = rest.substr(5);
    if (source.path.empty()) fail("no program is named");
    if (find_program(source.path.string()).empty()) {
      fail("program \"" + source.path.string() + "\" does not exist or may not be executed");
    }
  } else {
    fail("the source is neither dir: nor exec:");
  }
  return source;
}

void check_stages(const std::vector<StageSource>& sources, StageOrder order,
                  std::string_view pipeline) {
  for (const StageSource& source : sources) {
    if (std::find(order.begin(), order.end(), source.stage) != order.end()) continue;
    std::string all;
    for (const std::string_view stage : order)
      all += (all.empty() ? "" : ", ") + std::string(stage);
    throw std::invalid_argument("--stage " + source.stage + ": pipeline " + std::string(pipeline) +
                                " has " + all);
  }
}

bool replaces(const std::vector<StageSource>& sources, std::string_view stage) {
  return std::any_of(sources.begin(), sources.end(),
                     [&](const StageSource& source) { return source.stage == stage; });
}

bool is_fault_of_input(const StageError& error, const std::vector<std::string>& stages) {
  const std::string name = error.stage + "=";
  const auto given = std::find_if(stages.rbegin(), stages.rend(),
                                  [&](const std::string& text) { return text.starts_with(name); });
  if (given == stages.rend()) return false;
  if (given->starts_with(name + "dir:")) return true;
  try {
    std::rethrow_if_nested(error);
  } catch (const StageInputError&) {
    return true;
  } catch (const std::exception&) {
  }
  return false;
}

Stages with_stage_sources(Stages base, const std::vector<StageSource>& sources, StageOrder order,
                          int scene_index, const Warn& warn) {
  for (const StageSource& source : sources) {
    stage_row(source.stage)
        .read_from(base, folder_of(source, order, scene_index), scene_index, warn);
  }
  return base;
}

std::vector<std::string> estimate_names(const fs::path& scene) {
  std::vector<std::string> names;
  const auto add = [&](std::string_view name) { names.push_back((scene / name).generic_string()); };
  for (const StageRow& stage : stage_table()) {
    for (const std::string_view file : stage.files) add(file);
  }
  for (const char* name :
       {"config.toml", "timings.json", "scores.csv", "splats_seen.csv", "exposures.csv",
        "pictures/######.png", "splats.unfinished", "splats.unfinished.colmap"})
    add(name);
  return names;
}

}  // namespace cousin
