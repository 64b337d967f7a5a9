#include "benchmarks/app/run_folder.h"

#include <utility>

#include "benchmarks/loop/seeds_report.h"
#include "benchmarks/loop/stage_files.h"
#include "sim/dataset/categories.h"
#include "sim/dataset/manifest.h"
#include "sim/types/whole_file.h"

namespace cousin {
namespace fs = std::filesystem;

namespace {

FolderClaim run_claim(const std::string& key, int scenes) {
  FolderClaim claim{
      .verb = "run",
      .version = COUSIN_VERSION,
      .config = sha256_hex(key),
      .names = report_names({"parts/######.json", std::string("estimate/") + kCategoriesFile})};
  for (int scene = 0; scene < scenes; ++scene) {
    for (std::string& name : estimate_names(fs::path("estimate") / scene_id(scene)))
      claim.names.push_back(std::move(name));
  }
  return claim;
}

}  // namespace

void check_run_folder(const fs::path& out, const std::string& key, int scenes) {
  check_output_folder(out, run_claim(key, scenes));
}

OutputFolder run_folder(const fs::path& out, const std::string& key, int scenes) {
  OutputFolder folder(out, run_claim(key, scenes));
  for (const std::string& file : folder.files_of_other_configs()) {
    if (*fs::path(file).begin() != "estimate") remove_own(out / file);
  }
  return folder;
}

}  // namespace cousin
