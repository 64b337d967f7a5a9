// The one symbol that a module shows.
#include "benchmarks/app/jobs.h"

extern "C" __attribute__((visibility("default"))) int cousin_run_job(const cousin::Options* options,
                                                                     int argc,
                                                                     const char* const* argv) {
  return cousin::run_and_report(options, argc, argv);
}
