#include "benchmarks/splats/splats_suite.h"

#include "benchmarks/splats/field_rows.h"
#include "benchmarks/splats/kernel_rows.h"
#include "benchmarks/splats/training_rows.h"

namespace cousin {

ScoreFile splats_suite(const std::filesystem::path& photographs, const std::filesystem::path& fox,
                       const std::filesystem::path& chair, std::uint64_t seed, bool quick,
                       const std::function<void(const std::string&, int, int)>& progress) {
  ScoreFile file;
  if (progress) progress("kernels", 0, 3);
  append({.scores = splat_kernel_rows(seed)}, file);
  if (progress) progress("training", 1, 3);
  append({.scores = splat_training_rows(photographs, seed, quick)}, file);
  if (progress) progress("beside a radiance field", 2, 3);
  append({.scores = field_rows(photographs, fox, chair, seed, quick)}, file);
  return file;
}

}  // namespace cousin
