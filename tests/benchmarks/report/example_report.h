#pragma once

#include "benchmarks/report/report.h"

namespace cousin {

/// A report with something in every section, made up but plausible.
ReportInput example_report();

}  // namespace cousin
