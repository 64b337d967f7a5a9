#include "tests/benchmarks/app/program.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <stdexcept>
#include <thread>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/output_folder.h"

namespace cousin {

namespace fs = std::filesystem;

pid_t Program::start(const Words& words, const Prepare& prepare) const {
  std::string program = COUSIN_PROGRAM;
  std::vector<std::string> copies = words;
  std::vector<char*> arguments = {program.data()};
  for (std::string& word : copies) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const std::string out = streams_.path() / "out", err = streams_.path() / "err";
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("fork failed");
  if (child > 0) return child;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  dup2(open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666), STDOUT_FILENO);
  dup2(open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666), STDERR_FILENO);
  if (chdir(folder_->path().c_str()) != 0) _exit(126);
  if (prepare && !prepare()) _exit(kNotPrepared);
  execv(program.c_str(), arguments.data());
  _exit(127);
}

Outcome Program::finish(int wait_status) const {
  Outcome outcome;
  if (WIFEXITED(wait_status)) outcome.code = WEXITSTATUS(wait_status);
  if (WIFSIGNALED(wait_status)) outcome.signal = WTERMSIG(wait_status);
  outcome.out = read_file(streams_.path() / "out");
  outcome.err = read_file(streams_.path() / "err");
  return outcome;
}

Outcome Program::run(const Words& words, const Prepare& prepare) const {
  const pid_t child = start(words, prepare);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return finish(status);
}

Outcome Program::run_until(const Words& words, const std::function<bool()>& is_time) const {
  const pid_t child = start(words, {});
  int status = 0;
  while (waitpid(child, &status, WNOHANG) == 0) {
    if (is_time()) kill(child, SIGKILL);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return finish(status);
}

Words operator+(Words a, const Words& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

Words tiny_scene() {
  return {"--set", "views=2",
          "--set", "seeds=0",
          "--set", "rig.width_px=320",
          "--set", "rig.height_px=180",
          "--set", "distance_min_m=0.2",
          "--set", "ring_distances_m=[0.2,0.2,0.2]",
          "--set", "render.irradiance_samples=16",
          "--set", "render.edge_samples=16",
          "--set", "render.board_texel_m=0.005",
          "--set", "render.max_bounces=0"};
}

Words tiny_tray() {
  return {"--set", "tray.columns=2",
          "--set", "tray.rows=2",
          "--set", "views=2",
          "--set", "coverage=0.2",
          "--set", "rig.width_px=160",
          "--set", "rig.height_px=90",
          "--set", "render.pixel_samples=2",
          "--set", "substrate.detail_m=0.004"};
}

Words measured_scene() {
  return {"--set", "views=18",
          "--set", "rig.width_px=480",
          "--set", "rig.height_px=360",
          "--set", "rig.focal_px_per_width=1.7",
          "--set", "ring_distances_m=[0.3,0.3,0.3]",
          "--set", "render.irradiance_samples=16",
          "--set", "render.edge_samples=16",
          "--set", "render.board_texel_m=0.002",
          "--set", "render.max_bounces=0"};
}

Words quick_pipeline() {
  return {"--set", "pipeline.mvs.step_px=1.5",        "--set", "pipeline.tallest_m=0.008",
          "--set", "pipeline.surface.subdivisions=3", "--set", "pipeline.surface.samples=8"};
}

std::map<std::string, std::string> contents(const fs::path& folder) {
  std::map<std::string, std::string> result;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (!entry.is_regular_file() || name == "timings.json" || is_output_list(name)) continue;
    result[fs::relative(entry.path(), folder).string()] = read_file(entry.path());
  }
  return result;
}

}  // namespace cousin
