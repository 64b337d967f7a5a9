#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tests/sim/dataset/temporary_folder.h"

namespace cousin {

/// How the program ended and what it said.
struct Outcome {
  int code = -1;   ///< exit code; -1 if a signal ended it
  int signal = 0;  ///< that signal
  std::string out;
  std::string err;
};

using Words = std::vector<std::string>;

/// Runs in the child before the program starts; false: what the test needs is not allowed here.
using Prepare = std::function<bool()>;
inline constexpr int kNotPrepared = 125;  ///< exit code then

/// The program as the user starts it, in a folder of its own that is removed afterwards.
class Program {
 public:
  Program() = default;
  /// For another command at the same time in the same folder.
  Program(const Program& same_folder) : folder_(same_folder.folder_) {}
  Program& operator=(const Program&) = delete;
  ~Program() = default;

  /// `cousin words...`, to its end.
  Outcome run(const Words& words, const Prepare& prepare = {}) const;
  /// `cousin words...`, ended by SIGKILL as soon as `is_time`; it may end by itself before that.
  Outcome run_until(const Words& words, const std::function<bool()>& is_time) const;

  std::filesystem::path path(const std::string& below = "") const {
    return folder_->path() / below;
  }

 private:
  pid_t start(const Words& words, const Prepare& prepare) const;
  Outcome finish(int wait_status) const;
  std::shared_ptr<const TemporaryFolder> folder_ = std::make_shared<const TemporaryFolder>();
  TemporaryFolder streams_;
};

Words operator+(Words a, const Words& b);

/// Two views of an empty board, 320 x 180, near and in poor light: half a second.
Words tiny_scene();

/// Keys of a tray of four watermelon cells in two small photographs: a second.
Words tiny_tray();

/// The least views and pixels that measure seeds, near and in poor light: a few seconds.
Words measured_scene();
/// For `run` and `perceive`: a coarser search for depth and coarser surfaces.
Words quick_pipeline();

/// Every file below a folder, but seconds and what lists them, as path -> bytes.
std::map<std::string, std::string> contents(const std::filesystem::path& folder);

}  // namespace cousin
