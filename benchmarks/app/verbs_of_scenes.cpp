#include <vector>

#include "benchmarks/app/job_verbs.h"

namespace cousin {

std::span<const Verb> module_verbs() {
  static const std::vector<Verb> kVerbs = [] {
    std::vector<Verb> verbs(kJobVerbs.begin(), kJobVerbs.end());
    verbs.push_back({"import", command_import, Reads::input});
    verbs.push_back({"export", command_export, Reads::input});
    return verbs;
  }();
  return kVerbs;
}

}  // namespace cousin
