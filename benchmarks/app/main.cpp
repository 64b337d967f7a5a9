// The program starts in milliseconds: this file knows the command line only. Everything that links
// a heavy library is in the module cousin_jobs, which is opened when a verb needs it.
#include <dlfcn.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>

#include "benchmarks/app/jobs.h"
#include "benchmarks/app/options.h"

int main(int argc, char** argv) {
  const cousin::ParsedOptions parsed = cousin::parse_options(argc, argv);
  if (parsed.leave) {
    std::fputs(parsed.text.c_str(), parsed.code == cousin::ExitCode::done ? stdout : stderr);
    return static_cast<int>(parsed.code);
  }
  std::error_code error;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::string module = (self.parent_path() / COUSIN_JOBS_FILE).string();
  void* handle = dlopen(module.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!handle) {
    std::fprintf(stderr, "cousin: cannot open %s: %s\n", module.c_str(), dlerror());
    return static_cast<int>(cousin::ExitCode::internal);
  }
  const auto run = reinterpret_cast<cousin::RunJob*>(dlsym(handle, cousin::kRunJobSymbol));
  if (!run) {
    std::fprintf(stderr, "cousin: %s has no %s\n", module.c_str(), cousin::kRunJobSymbol);
    return static_cast<int>(cousin::ExitCode::internal);
  }
  const int code = run(&parsed.options, argc, argv);
  // Results that end in a full disk or a closed pipe are not results.
  errno = 0;
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
    std::fprintf(stderr, "cousin: cannot write the output: %s\n",
                 errno != 0 ? std::strerror(errno) : "write error");
    return static_cast<int>(cousin::ExitCode::bad_input);
  }
  return code;
}
