#include "sim/process/keeper.h"

#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>

#include "sim/process/spawn.h"

namespace cousin {

Keeper::Keeper(const std::string& script, const std::string& argument) {
  // No child of ours may hold our end, nor a pipe that would end us where it is broken.
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
    throw std::runtime_error("socketpair: " + std::string(std::strerror(errno)));
  line_ = ends[0];
  SpawnFiles files;
  files.copy(ends[1], STDIN_FILENO);
  files.open(STDOUT_FILENO, "/dev/null", O_WRONLY);
  files.open(STDERR_FILENO, "/dev/null", O_WRONLY);
  const int error =
      spawn({"/bin/sh", "-c", "trap '' INT HUP TERM; read -r line || { " + script + "; }", "sh",
             argument},
            {}, files, shell_);
  close(ends[1]);
  if (error == 0) return;
  close(line_);
  throw std::runtime_error("cannot start /bin/sh: " + std::string(std::strerror(error)));
}

Keeper::~Keeper() {
  [[maybe_unused]] const auto sent = send(line_, "\n", 1, MSG_NOSIGNAL);
  close(line_);
  while (waitpid(shell_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

}  // namespace cousin
