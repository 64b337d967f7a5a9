#include <stdexcept>
#include <string>

#include "benchmarks/study/shard.h"
#include "tests/fuzz/fuzz_folder.h"

/// Any bytes as a finished part of long work: taken as it is or made anew, and nothing is thrown.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cousin;
  fuzz_file("shards/part.json", data, size);
  const std::vector<ShardJob> jobs = {{"part.json", "key", [] { return std::string("made"); }, {}}};
  is_finished(fuzz_folder() / "shards", jobs.front());
  run_shards(fuzz_folder() / "shards", jobs, Shard{}, {});
  return 0;
}
