#include "sim/dataset/links.h"

#include <algorithm>
#include <set>
#include <stdexcept>
#include <system_error>

namespace cousin {
namespace fs = std::filesystem;
namespace {

class LinkCheck {
 public:
  LinkCheck(const fs::path& folder, fs::path without)
      : folder_(folder), base_(fs::weakly_canonical(folder)), without_(std::move(without)) {}

  void look_at(const fs::path& file) {
    std::error_code error;
    const fs::path there = target_of(file, error);
    const bool leads_out =
        error ||
        std::mismatch(base_.begin(), base_.end(), there.begin(), there.end()).first != base_.end();
    if (leads_out) {
      throw std::runtime_error(file.string() + ": a symbolic link that leads to " +
                               (error ? error.message() : there.string()) + ", outside of " +
                               folder_.string() + "; copy what is there into the folder");
    }
    // A folder that a link leads to is looked at too, and only once.
    if (!fs::is_directory(there, error) || !seen_.insert(there).second) return;
    for (const fs::directory_entry& entry : fs::directory_iterator(there)) {
      const bool matters = entry.is_symlink(error) || entry.is_directory(error);
      if (matters && entry.path().filename() != without_) look_at(entry.path());
    }
  }

 private:
  /// Where a file is; of a link to nothing, where that would be.
  static fs::path target_of(const fs::path& file, std::error_code& error) {
    const bool leads_nowhere = fs::is_symlink(fs::symlink_status(file)) && !fs::exists(file, error);
    error.clear();
    return fs::weakly_canonical(
        leads_nowhere ? file.parent_path() / fs::read_symlink(file, error) : file, error);
  }

  fs::path folder_, base_, without_;
  std::set<fs::path> seen_;
};

}  // namespace

void refuse_links_out(const fs::path& folder, const fs::path& part, const fs::path& without) {
  if (fs::exists(fs::symlink_status(folder / part)))
    LinkCheck(folder, without).look_at(folder / part);
}

}  // namespace cousin
