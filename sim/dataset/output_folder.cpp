#include "sim/dataset/output_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/for_each_frame.h"
#include "sim/dataset/output_list.h"
#include "sim/types/whole_file.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
bool matches(std::string_view name, std::string_view pattern) {
  if (pattern.empty()) return name.empty();
  if (pattern.front() == '*')
    return matches(name, pattern.substr(1)) || (!name.empty() && matches(name.substr(1), pattern));
  if (name.empty()) return false;
  const bool is_digit = name.front() >= '0' && name.front() <= '9';
  return (pattern.front() == '#' ? is_digit : pattern.front() == name.front()) &&
         matches(name.substr(1), pattern.substr(1));
}

[[noreturn]] void refuse(const fs::path& folder, const std::string& path, const std::string& verb,
                         const std::string& why) {
  const std::string other = other_owner(folder, path, verb);
  throw std::invalid_argument(
      (folder / path).string() + " is in the way: " +
      (other.empty() ? why : "`cousin " + other + "` wrote it, not `cousin " + verb + "`") +
      ". Cousin replaces only what the same command wrote there. Move it away, or choose another "
      "--out");
}

std::string not_written(const std::string& verb) {
  return "`cousin " + verb + "` did not write it";
}

/// Looks through what a command would write over.
class Look {
 public:
  Look(const fs::path& folder, const FolderClaim& claim, const Listed& also_own)
      : folder_(folder),
        claim_(claim),
        also_own_(also_own),
        list_(read_list(folder, claim, also_own)) {}

  /// @throws std::invalid_argument naming the first file, by name, that is in the way
  void look() {
    if (!fs::exists(folder_)) return;
    for (const fs::path name : claim_.names) add_named({}, name.begin(), name.end());
    for (const auto& [path, file] : list_.files) {  // these are removed at the end
      if (is_of_other_config(file, claim_)) files_.push_back(path);
    }
    std::sort(files_.begin(), files_.end());
    files_.erase(std::unique(files_.begin(), files_.end()), files_.end());
    std::vector<std::string> why(files_.size());
    for_each_frame(files_.size(), [&](std::size_t i) { why[i] = problem(list_, files_[i]); });
    std::optional<OutputList> newer;  // another process may have written since
    for (std::size_t i = 0; i < files_.size(); ++i) {
      if (why[i].empty()) continue;
      if (!newer) newer = read_list(folder_, claim_, also_own_);
      const std::string still = problem(*newer, files_[i]);
      if (!still.empty()) refuse(folder_, files_[i], claim_.verb, still);
    }
  }

 private:
  /// Names below the folder, sorted, without temporary ones; those of dead processes are removed.
  std::vector<fs::path> entries_of(const fs::path& below) const {
    std::vector<fs::path> entries;
    for (const auto& entry : fs::directory_iterator(folder_ / below)) {
      if (is_own_temporary(entry.path().filename().string()))
        remove_if_stale(entry.path());
      else
        entries.push_back(below / entry.path().filename());
    }
    std::sort(entries.begin(), entries.end());
    return entries;
  }

  /// What has the name whose parts are in [part, end), and what is there in place of a folder on
  /// the way to it.
  void add_named(const fs::path& below, fs::path::iterator part, fs::path::iterator end) {
    const std::string pattern = part->string();
    const bool is_last = ++part == end;
    for (const fs::path& entry : entries_of(below)) {
      const std::string name = entry.filename().string();
      if (!matches(name, pattern) || is_output_list(name)) continue;
      const bool is_folder = fs::symlink_status(folder_ / entry).type() == fs::file_type::directory;
      if (is_folder && !is_last)
        add_named(entry, part, end);
      else
        add_files(entry);
    }
  }

  void add_files(const fs::path& below) {
    const fs::file_type type = fs::symlink_status(folder_ / below).type();
    if (type != fs::file_type::directory) {
      files_.push_back(below.generic_string());
    } else if (!is_in_own_folder(list_, below.generic_string())) {
      for (const fs::path& entry : entries_of(below)) add_files(entry);
    }
  }

  /// Why a file may not be replaced; empty if it may.
  std::string problem(const OutputList& list, const std::string& path) const {
    const fs::path file = folder_ / path;
    for (fs::path way = fs::path(path).parent_path(); !way.empty(); way = way.parent_path()) {
      if (fs::is_symlink(fs::symlink_status(folder_ / way)))
        return "it is behind the link " + way.generic_string() + ", and links are not followed";
    }
    const fs::file_type type = fs::symlink_status(file).type();
    if (type == fs::file_type::not_found) return {};  // gone since it was listed
    if (type == fs::file_type::symlink) return "it is a link, and links are not followed";
    if (type != fs::file_type::regular) return "it is neither a file nor a folder";
    const auto listed = list.files.find(path);
    if (listed == list.files.end())
      return is_in_own_folder(list, path) ? "" : not_written(claim_.verb);
    if (!claim_.check_bytes || has_listed_bytes(listed->second, path, file)) return {};
    return "it was changed since `cousin " + claim_.verb + "` wrote it";
  }

  const fs::path& folder_;
  const FolderClaim& claim_;
  const Listed& also_own_;
  OutputList list_;
  std::vector<std::string> files_;
};

/// @throws std::invalid_argument if the list is of a configuration that may not be replaced
void check_config(const fs::path& folder, const FolderClaim& claim, const OutputList& list) {
  if (list.config.empty() || claim.other_config == FolderClaim::OtherConfig::replace) return;
  if (list.config == claim.config) return;
  throw std::invalid_argument(
      list_file(folder, claim.verb).string() +
      " belongs to another configuration, seed or choice of truth, or to another version of the "
      "program (SHA-256 " +
      list.config + " there, " + claim.config + " here); choose another --out");
}

[[noreturn]] void fail(const fs::path& file, const char* doing, int code) {
  throw std::runtime_error(file.string() + ": " + doing + ": " +
                           std::system_category().message(code));
}

/// Makes a file with `text`, in one step, unless it is there. @returns whether it did
bool make_list(const fs::path& file, const std::string& text) {
  const fs::path beside = file.parent_path() / temporary_name(file.filename().string());
  write_file(beside, text);
  const int code = ::link(beside.c_str(), file.c_str()) == 0 ? 0 : errno;
  ::unlink(beside.c_str());
  if (code == 0 || code == EEXIST) return code == 0;
  // A file system without links.
  const int made = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (made < 0 && errno == EEXIST) return false;
  if (made < 0) fail(file, "cannot write", errno);
  const bool written = ::write(made, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  ::close(made);
  if (!written) fail(file, "cannot write", EIO);
  return true;
}

}  // namespace

struct OutputFolder::Impl final : FolderGuard {
  fs::path folder;
  FolderClaim claim;
  int descriptor = -1;
  bool released = false;
  mutable std::mutex mutex;
  OutputList list;
  std::set<std::string> written;
  std::optional<GuardedFolder> guard;

  ~Impl() override {
    guard.reset();
    if (descriptor < 0) return;
    if (claim.sharing == FolderClaim::Sharing::alone && !released) tidy();
    ::close(descriptor);
  }

  /// The list of what is there, sorted; none where nothing was written. Until the last step the
  /// longer list stands, so nothing is lost if this fails.
  void tidy() noexcept {
    const fs::path file = list_file(folder, claim.verb);
    try {
      OutputList whole = read_list(folder, claim, {});
      if (whole.config.empty()) whole.config = config_of(claim), whole.version = claim.version;
      std::map<std::string, std::string> lines;  // by configuration
      bool is_empty = whole.folders.empty();
      for (auto& [path, listed] : whole.files) {
        if (!fs::is_regular_file(fs::symlink_status(folder / path))) continue;
        is_empty = false;
        if (listed.hashes.size() > 1 && written.contains(path))
          listed.hashes = {hash_of(path, read_file(folder / path))};
        for (const std::string& hash : listed.hashes) lines[listed.config] += file_line(hash, path);
      }
      std::string text;
      for (const auto& [config, of_config] : lines) {
        if (config != whole.config)
          text += claim_line(claim.verb, config, whole.version) + of_config;
      }
      text += claim_line(claim.verb, whole.config, whole.version);
      for (const std::string& path : whole.folders) text += folder_line(path);
      text += lines[whole.config];
      if (is_empty) {
        ::unlink(file.c_str());
      } else if (read_file(file, kListLimit_bytes) != text) {
        write_file(file, text);
      }
    } catch (const std::exception&) {
      return;
    }
  }

  /// Opens the list of this verb, which is made where there is none, and locks it.
  /// @returns whether it was made
  bool open_list() {
    const fs::path file = list_file(folder, claim.verb);
    for (;;) {
      const bool is_new = make_list(file, claim_line(claim));
      descriptor = ::open(file.c_str(), O_RDWR | O_APPEND | O_NOFOLLOW | O_CLOEXEC);
      if (descriptor < 0 && errno == ENOENT) continue;  // released since
      if (descriptor < 0) fail(file, "cannot be opened", errno);
      const int how = claim.sharing == FolderClaim::Sharing::alone ? LOCK_EX : LOCK_SH;
      if (::flock(descriptor, how | LOCK_NB) != 0 && errno == EWOULDBLOCK)
        throw std::invalid_argument(folder.string() + ": another `cousin " + claim.verb +
                                    "` is writing there at this moment; wait until it has ended, "
                                    "or choose another --out");
      struct stat ours {
      }, there{};
      const bool is_same = ::fstat(descriptor, &ours) == 0 && ::stat(file.c_str(), &there) == 0 &&
                           ours.st_ino == there.st_ino && ours.st_dev == there.st_dev;
      if (is_same) return is_new;
      ::close(std::exchange(descriptor, -1));
    }
  }

  /// As all processes have written it that hold it open, though one of them may have removed it.
  std::string whole_list() const {
    std::string text;
    std::array<char, 1 << 16> block;
    for (;;) {
      const ssize_t count =
          ::pread(descriptor, block.data(), block.size(), static_cast<off_t>(text.size()));
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) fail(list_file(folder, claim.verb), "cannot read", errno);
      if (count == 0) return text;
      text.append(block.data(), static_cast<std::size_t>(count));
    }
  }

  /// One write for a record: those of other processes come before or after it.
  void append(const std::string& record) {
    const auto size = static_cast<ssize_t>(record.size());
    if (::write(descriptor, record.data(), record.size()) != size)
      fail(list_file(folder, claim.verb), "cannot write", errno);
  }

  bool is_temporary(const fs::path& below) const {
    return std::any_of(below.begin(), below.end(), [](const fs::path& part) {
      return is_own_temporary(part.string()) || is_output_list(part.string());
    });
  }

  /// @throws std::invalid_argument if a folder on the way to the file is a link or a file
  void check_way(const fs::path& below) const {
    fs::path way;
    for (const fs::path& part : below.parent_path()) {
      way /= part;
      const fs::file_type type = fs::symlink_status(folder / way).type();
      if (type == fs::file_type::not_found) return;
      if (type == fs::file_type::directory) continue;
      refuse(folder, way.generic_string(), claim.verb,
             type == fs::file_type::symlink ? "it is a link, and links are not followed"
                                            : "it is no folder");
    }
  }

  bool before_write(const fs::path& below, std::string_view bytes) override {
    check_way(below);
    if (is_temporary(below)) return false;
    const std::string path = below.generic_string();
    const std::string hash = hash_of(below, bytes);
    const std::lock_guard lock(mutex);
    bool own = list.files.contains(path) || is_in_own_folder(list, path);
    const fs::file_type type = fs::symlink_status(folder / below).type();
    if (type != fs::file_type::not_found) {
      // Another process that shares the folder may have written it.
      if (!own && claim.sharing == FolderClaim::Sharing::shards)
        own = parse_list(whole_list()).files.contains(path);
      if (type == fs::file_type::symlink)
        refuse(folder, path, claim.verb, "it is a link, and links are not followed");
      if (!own || type != fs::file_type::regular)
        refuse(folder, path, claim.verb, not_written(claim.verb));
    }
    ListedFile& listed = list.files[path];
    const bool is_new = listed.hashes.insert(hash).second;
    if (is_new || listed.config != config_of(claim)) append(file_line(hash, path));
    listed.config = config_of(claim);
    written.insert(path);
    return own || claim.sharing == FolderClaim::Sharing::shards;
  }

  void was_in_the_way(const fs::path& below) override {
    if (is_temporary(below)) return;
    after_remove(below);  // the file there is not the one that was listed
    refuse(folder, below.generic_string(), claim.verb, not_written(claim.verb));
  }

  bool is_own(const fs::path& below) override {
    if (is_temporary(below)) return true;
    const std::string path = below.generic_string();
    const std::lock_guard lock(mutex);
    fs::path way = below.parent_path();
    for (; !way.empty(); way = way.parent_path()) {
      if (fs::is_symlink(fs::symlink_status(folder / way))) return false;
    }
    if (is_in_own_folder(list, path)) return true;
    return list.files.contains(path) && !fs::is_symlink(fs::symlink_status(folder / below));
  }

  void after_remove(const fs::path& below) override {
    const std::string path = below.generic_string();
    const std::lock_guard lock(mutex);
    if (list.files.erase(path) + list.folders.erase(path) == 0) return;
    written.erase(path);
    append(removed_line(path));
  }

  void own_all_in(const fs::path& below) override {
    check_way(below / "any");
    const std::string path = below.generic_string();
    const std::lock_guard lock(mutex);
    if (is_in_own_folder(list, path)) return;
    list.folders.insert(path);
    append(folder_line(path));
  }

  /// Whether a file is as it was listed: a list may be a stranger's, and a file changed since.
  bool is_as_listed(const std::string& path) const {
    const fs::path file = folder / path;
    if (fs::symlink_status(file).type() != fs::file_type::regular) return false;
    const auto listed = list.files.find(path);
    return listed != list.files.end() && has_listed_bytes(listed->second, path, file);
  }

  /// Removes files that are as they were listed, and folders that hold nothing then.
  void remove(const std::vector<std::string>& paths) const {
    for (const std::string& path : paths) {
      if (!is_as_listed(path) || !remove_own(folder / path)) continue;
      std::error_code error;  // a folder that is not empty stays
      for (fs::path above = fs::path(path).parent_path(); !above.empty();
           above = above.parent_path()) {
        if (!fs::is_directory(fs::symlink_status(folder / above))) break;
        if (!fs::remove(folder / above, error)) break;
      }
    }
  }
};

OutputFolder::OutputFolder(const fs::path& folder, FolderClaim claim, const Listed& also_own)
    : impl_(std::make_unique<Impl>()) {
  impl_->folder = folder;
  impl_->claim = std::move(claim);
  const FolderClaim& own = impl_->claim;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) fail(folder, "cannot make the folder", error.value());
  text_of_list(folder, own.verb);  // says so where something else has its name
  const bool is_new = impl_->open_list();
  try {
    const OutputList before = read_list(folder, own, {});
    if (before.config.empty() && own.other_config == FolderClaim::OtherConfig::refuse)
      throw std::invalid_argument(list_file(folder, own.verb).string() +
                                  " has no first line: another process takes the folder at this "
                                  "moment, or was stopped while it did. If none runs, remove it");
    check_config(folder, own, before);
    Look(folder, own, also_own).look();
    // Where a kill has cut off the last line, the next one begins anew.
    const std::string text = text_of_list(folder, own.verb);
    if (!text.empty() && text.back() != '\n') impl_->append("\n");
    if (before.config != config_of(own)) impl_->append(claim_line(own));
    for (const auto& [path, hash] : also_own) {
      const auto listed = before.files.find(path);
      if (listed == before.files.end() || !listed->second.hashes.contains(hash))
        impl_->append(file_line(hash, path));
    }
  } catch (...) {
    if (is_new) ::unlink(list_file(folder, own.verb).c_str());
    throw;
  }
  impl_->list = read_list(folder, own, also_own);
  impl_->guard.emplace(folder, *impl_);
}

OutputFolder::~OutputFolder() = default;
OutputFolder::OutputFolder(OutputFolder&&) noexcept = default;

std::vector<std::string> OutputFolder::files() const {
  const std::lock_guard lock(impl_->mutex);
  std::vector<std::string> files;
  for (const auto& [path, listed] : parse_list(impl_->whole_list()).files) files.push_back(path);
  return files;
}

std::vector<std::string> OutputFolder::files_of_other_configs() const {
  const std::lock_guard lock(impl_->mutex);
  std::vector<std::string> files;
  for (const auto& [path, listed] : impl_->list.files) {
    if (is_of_other_config(listed, impl_->claim)) files.push_back(path);
  }
  return files;
}

void OutputFolder::remove_other_configs() { impl_->remove(files_of_other_configs()); }

void OutputFolder::remove_earlier() {
  std::vector<std::string> earlier;
  {
    const std::lock_guard lock(impl_->mutex);
    for (const auto& [path, listed] : impl_->list.files) {
      if (!impl_->written.contains(path)) earlier.push_back(path);
    }
  }
  impl_->remove(earlier);
}

void OutputFolder::release() {
  impl_->released = true;
  ::unlink(list_file(impl_->folder, impl_->claim.verb).c_str());
}

void check_output_folder(const fs::path& folder, const FolderClaim& claim, const Listed& also_own) {
  check_config(folder, claim, read_list(folder, claim, {}));
  Look(folder, claim, also_own).look();
}

std::string owner_of(const fs::path& folder, const std::string& file) {
  return other_owner(folder, file, "");
}

bool is_output_list(std::string_view file_name) {
  return file_name.starts_with(kListPrefix) && !is_own_temporary(file_name);
}

}  // namespace cousin
