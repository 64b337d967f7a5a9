#include "benchmarks/score/learned/learned_distance.h"

#include <dlfcn.h>

#include <stdexcept>
#include <system_error>

#include "sim/types/not_built.h"

namespace cousin {
namespace fs = std::filesystem;

std::shared_ptr<const LearnedDistance> load_learned_distance(const fs::path& network) {
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  return load_learned_distance(network, self.parent_path() / COUSIN_LEARNED_MODULE);
}

std::shared_ptr<const LearnedDistance> load_learned_distance(const fs::path& network,
                                                             const fs::path& module) {
  std::error_code error;
  if (!fs::is_regular_file(network, error))
    throw std::runtime_error(network.string() + ": is no file");
  const std::uintmax_t bytes = fs::file_size(network, error);
  if (error || bytes > kMostNetworkBytes) {
    throw std::runtime_error(network.string() + ": has " + std::to_string(bytes) +
                             " bytes; at most " + std::to_string(kMostNetworkBytes) +
                             " are read as a network");
  }
  if (!fs::exists(module, error)) {
    throw NotBuilt(network.string() +
                   ": this build reads no networks; `scripts/build torch` builds what does");
  }
  void* handle = dlopen(module.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!handle) throw std::runtime_error(module.string() + ": " + dlerror());
  const auto load = reinterpret_cast<LoadLearnedDistance*>(dlsym(handle, kLoadLearnedDistance));
  if (!load) throw std::runtime_error(module.string() + ": has no " + kLoadLearnedDistance);
  return std::shared_ptr<const LearnedDistance>(load(network.c_str()));
}

}  // namespace cousin
