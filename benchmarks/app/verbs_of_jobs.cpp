#include "benchmarks/app/job_verbs.h"

namespace cousin {

std::span<const Verb> module_verbs() { return kJobVerbs; }

}  // namespace cousin
