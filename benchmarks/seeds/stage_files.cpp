#include "benchmarks/seeds/stage_files.h"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <stdexcept>

#include "benchmarks/seeds/truth_stages.h"
#include "sim/dataset/capture_io.h"
#include "sim/dataset/seam_io.h"

extern char** environ;

namespace cousin {
namespace fs = std::filesystem;
namespace {

/// A new folder that is removed with all it holds.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (fs::temp_directory_path() / "cousin-stage-XXXXXX").string();
    if (!mkdtemp(name.data())) {
      throw std::runtime_error("cannot make a folder in " + fs::temp_directory_path().string() +
                               ": " + std::strerror(errno));
    }
    path_ = name;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

void call_program(const fs::path& program, const fs::path& input, const fs::path& output) {
  const std::string name = program.string(), in = input.string(), out = output.string();
  char* const arguments[] = {const_cast<char*>(name.c_str()), const_cast<char*>(in.c_str()),
                             const_cast<char*>(out.c_str()), nullptr};
  // Our stdout is for results (--json): what the program prints there goes to stderr.
  posix_spawn_file_actions_t actions;
  int error = posix_spawn_file_actions_init(&actions);
  if (error != 0) throw std::runtime_error("posix_spawn: " + std::string(std::strerror(error)));
  error = posix_spawn_file_actions_adddup2(&actions, STDERR_FILENO, STDOUT_FILENO);
  pid_t child = 0;
  if (error == 0) {
    error = posix_spawnp(&child, name.c_str(), &actions, nullptr, arguments, environ);
  }
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) {
    throw std::runtime_error("cannot start \"" + name + "\": " + std::strerror(error));
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR)
      throw std::runtime_error("waiting for \"" + name + "\": " + std::strerror(errno));
  }
  if (WIFSIGNALED(status)) {
    throw std::runtime_error("\"" + name + "\" was ended by signal " +
                             std::to_string(WTERMSIG(status)));
  }
  if (WEXITSTATUS(status) != 0) {
    throw std::runtime_error("\"" + name + "\" exited with " + std::to_string(WEXITSTATUS(status)));
  }
}

/// A stage that reads its seam with `read` from files, or from what a program makes of the capture
/// and earlier seams.
template <class Value>
std::function<Value(const Capture&, const SeedsEstimate&)> sourced(const StageSource& source,
                                                                   int scene_index,
                                                                   Value (*read)(const fs::path&)) {
  if (source.kind == StageSource::Kind::directory) {
    return [source, scene_index, read](const Capture&, const SeedsEstimate&) {
      const fs::path below = source.path / scene_id(scene_index);
      return read(fs::is_directory(below) ? below : source.path);
    };
  }
  return [source, scene_index, read](const Capture& capture, const SeedsEstimate& so_far) {
    const TemporaryFolder folder;
    const fs::path input = folder.path() / "input";
    const fs::path output = folder.path() / "output";
    fs::create_directories(output);
    write_capture(input, capture);
    for (const std::string& stage : seeds_stage_names()) {
      if (stage == source.stage) break;
      write_seam(input, stage, so_far, scene_index);
    }
    call_program(source.path, input, output);
    return read(output);
  };
}

/// A path with a slash is the file itself; a bare name is looked up in PATH, as a shell would.
bool can_be_started(const fs::path& program) {
  const auto executable = [](const fs::path& file) {
    return fs::is_regular_file(file) && access(file.c_str(), X_OK) == 0;
  };
  if (program.has_parent_path()) return executable(program);
  const char* path = std::getenv("PATH");
  std::istringstream folders(path ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    if (executable(fs::path(folder) / program)) return true;
  }
  return false;
}

/// Removes a folder's files that are named by six digits and `ending`, and the folder if that was
/// all: it may be somebody's own.
void remove_numbered(const fs::path& folder, const std::string& ending) {
  if (!fs::is_directory(folder)) return;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    const bool is_numbered = name.find_first_not_of("0123456789") == 6;
    if (is_numbered && name.ends_with(ending)) files.push_back(entry.path());
  }
  for (const fs::path& file : files) fs::remove(file);
  std::error_code not_empty;
  fs::remove(folder, not_empty);
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

StageSource parse_stage_source(const std::string& text) {
  const auto fail = [&](const std::string& why) {
    throw std::invalid_argument("--stage \"" + text + "\": " + why +
                                "; write NAME=dir:PATH or NAME=exec:PROGRAM");
  };
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) fail("there is no '='");
  StageSource source;
  source.stage = text.substr(0, equals);
  bool known = false;
  std::string names;
  for (const std::string& stage : seeds_stage_names()) {
    known = known || stage == source.stage;
    names += (names.empty() ? "" : ", ") + stage;
  }
  if (!known) fail("stage \"" + source.stage + "\" is not one of " + names);
  const std::string rest = text.substr(equals + 1);
  if (rest.starts_with("dir:")) {
    source.path = rest.substr(4);
    if (!fs::is_directory(source.path))
      fail("folder \"" + source.path.string() + "\" does not exist");
  } else if (rest.starts_with("exec:")) {
    source.kind = StageSource::Kind::program;
    source.path = rest.substr(5);
    if (source.path.empty()) fail("no program is named");
    if (!can_be_started(source.path)) {
      fail("program \"" + source.path.string() + "\" does not exist or may not be executed");
    }
  } else {
    fail("the source is neither dir: nor exec:");
  }
  return source;
}

SeedsStages with_stage_sources(SeedsStages base, const std::vector<StageSource>& sources,
                               int scene_index) {
  for (const StageSource& source : sources) {
    if (source.stage == "corners") base.corners = sourced(source, scene_index, read_corners);
    if (source.stage == "poses") base.poses = sourced(source, scene_index, read_poses);
    if (source.stage == "depth") base.depth = sourced(source, scene_index, read_depths);
    if (source.stage == "cloud") base.cloud = sourced(source, scene_index, read_cloud);
    if (source.stage == "clusters") base.clusters = sourced(source, scene_index, read_clusters);
    if (source.stage == "masks") base.masks = sourced(source, scene_index, read_silhouettes);
    if (source.stage == "surfaces") base.surfaces = sourced(source, scene_index, read_surfaces);
    if (source.stage == "traits") base.traits = sourced(source, scene_index, read_traits);
  }
  return base;
}

void remove_seam(const fs::path& dir, const std::string& stage) {
  if (stage == "corners") fs::remove(dir / "corners.json");
  if (stage == "poses") fs::remove(dir / "poses.json");
  if (stage == "depth") {
    fs::remove(dir / "depth" / "frames.json");
    remove_numbered(dir / "depth", ".exr");
    remove_numbered(dir / "depth_sigma", ".exr");
  }
  if (stage == "cloud") fs::remove(dir / "cloud.ply");
  if (stage == "clusters") fs::remove(dir / "clusters.ply");
  if (stage == "masks") fs::remove(dir / "masks.json");
  if (stage == "surfaces") {
    fs::remove(dir / "surfaces.json");
    remove_numbered(dir / "meshes", ".ply");
  }
  if (stage == "traits") fs::remove(dir / "traits.json");
}

void write_seam(const fs::path& dir, const std::string& stage, const SeedsEstimate& estimate,
                int scene_index) {
  if (stage == "corners") write_corners(dir, estimate.corners);
  if (stage == "poses") write_poses(dir, estimate.poses);
  if (stage == "depth") write_depths(dir, estimate.depths);
  if (stage == "cloud") write_cloud(dir, estimate.cloud);
  if (stage == "clusters") write_clusters(dir, estimate.clusters);
  if (stage == "masks" && !estimate.silhouettes.empty()) {
    write_silhouettes(dir, estimate.silhouettes, scene_index);
  }
  if (stage == "surfaces") write_surfaces(dir, estimate.surfaces);
  if (stage == "traits") write_traits(dir, estimate.traits);
}

}  // namespace cousin
