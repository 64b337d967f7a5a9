// The program starts in milliseconds: this file knows the command line only. Everything that links
// a heavy library is in modules (parts.h), of which one is opened when a verb needs it.
#include <dlfcn.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>

#include "benchmarks/app/jobs.h"
#include "benchmarks/app/options.h"
#include "benchmarks/app/parts.h"

namespace {

/// Where the part that holds the verb lies. The part with every scene has what the first has. A
/// page may have the plots of suites, so `report` takes the suites' part where it is built.
std::filesystem::path module_file(const std::filesystem::path& folder, const std::string& verb) {
  if (verb == "report" && std::filesystem::exists(folder / cousin::kBenchPart.file))
    return folder / cousin::kBenchPart.file;
  const std::filesystem::path file = cousin::part_of(verb).file;
  if (file == cousin::kJobsPart.file && std::filesystem::exists(folder / cousin::kScenesPart.file))
    return folder / cousin::kScenesPart.file;
  return folder / file;
}

}  // namespace

int main(int argc, char** argv) {
  const cousin::ParsedOptions parsed = cousin::parse_options(argc, argv);
  if (parsed.leave) {
    std::fputs(parsed.text.c_str(), parsed.code == cousin::ExitCode::done ? stdout : stderr);
    return static_cast<int>(parsed.code);
  }
  std::error_code error;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::string module = module_file(self.parent_path(), parsed.options.verb).string();
  if (!std::filesystem::exists(module)) {
    const std::string& verb = parsed.options.verb;
    std::fprintf(stderr, "cousin: \"%s\" is %s (%s is absent)\n", verb.c_str(),
                 cousin::how_to_build(cousin::part_of(verb).name).c_str(), module.c_str());
    return static_cast<int>(cousin::ExitCode::usage);
  }
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
