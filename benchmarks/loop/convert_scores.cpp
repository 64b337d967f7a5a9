// Writes scores.csv files of schema 1 anew: settings out of names, and the limits of seeds.
//   convert_scores FILE...
#include <cstdio>
#include <exception>

#include "benchmarks/loop/limits.h"
#include "sim/dataset/atomic_file.h"
#include "sim/types/whole_file.h"

int main(int argc, char** argv) {
  try {
    for (int i = 1; i < argc; ++i) {
      std::vector<cousin::ScoreRow> rows =
          cousin::scores_from_csv(cousin::read_file(argv[i]), argv[i]);
      cousin::add_limits_of_schema_1(rows);
      cousin::write_file(argv[i], cousin::to_csv(rows));
      std::printf("%s: %zu rows\n", argv[i], rows.size());
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 3;
  }
  return 0;
}
