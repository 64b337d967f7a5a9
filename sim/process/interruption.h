#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>

namespace cousin {

/// From now on SIGINT, SIGTERM and SIGHUP, those that are not ignored (as nohup does), end the
/// programs that `run_program` has started, with all that these started, remove every
/// `ScratchFolder`, and then end this process as they would have. The program calls it once.
void clean_up_when_interrupted();

/// What an interruption ends and removes. While it does so, none of these returns.
namespace interruption {

/// Runs `start`, which gives the number of the process group that it made, or -1, and notes it.
void note_group(const std::function<pid_t()>& start);
/// Runs `end`, which leaves nothing of the group, and forgets it.
void forget_group(pid_t group, const std::function<void()>& end);
/// Runs `make`, which gives the folder that it made, or an empty path, and notes it.
void note_folder(const std::function<std::filesystem::path()>& make);
void forget_folder(const std::filesystem::path& folder);

}  // namespace interruption
}  // namespace cousin
