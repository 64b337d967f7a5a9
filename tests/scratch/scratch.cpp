#include "benchmarks/calibration/studies.h"
#include "benchmarks/calibration/study_points.h"
#include <cstdio>
#include <cstring>
using namespace cousin;
int main(int argc, char** argv) {
  StudiesConfig c; c.quick = true;
  for (const ShardJob& job : study_jobs(c)) {
    if (argc > 1 && !std::strstr(job.name.c_str(), argv[1])) continue;
    try {
      const ScoreFile f = scores_from_json(job.run(), "x");
      for (const ScoreRow& r : f.scores) if (r.metric == "projection.rms" || r.metric == "reprojection.rms_coordinate" || r.metric == "fruit.position" || r.metric == "seed.length")
        std::printf("%-40s %-40s %-30s %g %s n %ld %.2f s status %s\n", r.case_name.c_str(), r.method.c_str(), r.metric.c_str(), r.value, r.unit.c_str(), (long)r.n, r.wall_s, std::string(to_string(r.status)).c_str());
    } catch (const std::exception& e) { std::printf("%s: %s\n", job.name.c_str(), e.what()); }
    std::fflush(stdout);
  }
}
