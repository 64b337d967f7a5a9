#include <stdexcept>

#include "benchmarks/app/parts.h"
#include "benchmarks/app/suite_plots.h"

namespace cousin {

void add_plots(SeedsReport&) {}

void require_plots(const SeedsReport& report) {
  const auto command = report.scores.header.more.find("command");
  if (command != report.scores.header.more.end() && command->second.starts_with("cousin bench"))
    throw std::invalid_argument("the page of `cousin bench` has plots that are " +
                                how_to_build("bench"));
}

}  // namespace cousin
