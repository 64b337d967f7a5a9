#include "sim/types/whole_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <iterator>
#include <mutex>
#include <random>
#include <shared_mutex>
#include <stdexcept>
#include <system_error>
#include <utility>
#include <vector>

namespace cousin {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMark = ".cousin-", kEnding = ".part";
constexpr std::size_t kDigits = 16;

struct Guarded {
  fs::path given, canonical;  ///< two names of the folder
  FolderGuard* guard = nullptr;
};

/// Folders that this process writes its results into, as the system has its table of locks.
struct GuardTable {
  std::shared_mutex mutex;
  std::vector<Guarded> rows;
};
GuardTable& guard_table() {
  static GuardTable table;
  return table;
}

/// Whether `path` lies below `folder`; `below` is the rest then.
bool is_below(const fs::path& folder, const fs::path& path, fs::path& below) {
  const auto [rest, end] = std::mismatch(path.begin(), path.end(), folder.begin(), folder.end());
  if (end != folder.end() || rest == path.end()) return false;
  below.clear();
  for (auto part = rest; part != path.end(); ++part) below /= *part;
  return true;
}

fs::path plain(const fs::path& path) {
  const fs::path whole = fs::absolute(path).lexically_normal();
  return whole.has_filename() ? whole : whole.parent_path();  // "folder/"
}

std::uint64_t random_number() {
  std::uint64_t number = 0;
  if (::getrandom(&number, sizeof number, 0) == static_cast<ssize_t>(sizeof number)) return number;
  std::random_device device;
  return (std::uint64_t{device()} << 32) ^ device();
}

/// Closes on scope exit; `close` reports what closing says (some file systems report a full disk
/// only then).
class Descriptor {
 public:
  explicit Descriptor(int value) : value_(value) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (value_ >= 0) ::close(value_);
  }
  int get() const { return value_; }
  int close() { return ::close(std::exchange(value_, -1)); }

 private:
  int value_;
};

/// Whether locks on this file do not work, rather than that another process holds one.
bool is_without_locks(int error) { return error != EWOULDBLOCK && error != EINTR; }

/// Locks what was just made. @returns whether it is still there: one who clears away may have been
/// faster.
bool lock_new(int descriptor) {
  if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0 && !is_without_locks(errno)) return false;
  struct stat status {};
  return ::fstat(descriptor, &status) == 0 && status.st_nlink > 0;
}

/// 0, or the error number of the first step that failed.
int write_and_flush(Descriptor& out, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(out.get(), bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  // EINVAL: a pipe or a device has no flush.
  return ::fsync(out.get()) == 0 || errno == EINVAL ? 0 : errno;
}

/// Renames where nothing has the name yet. 0 or the error number, EEXIST among them.
int rename_to_free_name(const fs::path& from, const fs::path& to) {
  if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return 0;
  if (errno != EINVAL && errno != ENOSYS) return errno;
  // A file system that cannot do so in one step.
  struct stat status {};
  if (::lstat(to.c_str(), &status) == 0) return EEXIST;
  return ::rename(from.c_str(), to.c_str()) == 0 ? 0 : errno;
}

/// Writes the temporary file and gives it its name, while it is locked.
int write_and_rename(const fs::path& file, std::string_view bytes, bool may_replace) {
  constexpr int kTries = 100;
  for (int i = 0; i < kTries; ++i) {
    const fs::path beside = file.parent_path() / temporary_name(file.filename().string());
    Descriptor out(::open(beside.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
    if (out.get() < 0 && errno == EEXIST) continue;
    if (out.get() < 0) return errno;
    if (!lock_new(out.get())) continue;
    int code = write_and_flush(out, bytes);
    // The lock ends with the descriptor, so the name comes first.
    if (code == 0)
      code = !may_replace                                  ? rename_to_free_name(beside, file)
             : ::rename(beside.c_str(), file.c_str()) == 0 ? 0
                                                           : errno;
    if (code != 0) {
      ::unlink(beside.c_str());
      return code;
    }
    return out.close() == 0 ? 0 : errno;
  }
  return EEXIST;
}

bool is_day_old(const struct stat& status) {
  constexpr std::time_t kDay_s = 24 * 60 * 60;
  return std::time(nullptr) - status.st_mtime > kDay_s;
}

std::string bytes_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

GuardedFolder::GuardedFolder(const fs::path& folder, FolderGuard& guard) : guard_(&guard) {
  GuardTable& table = guard_table();
  const std::unique_lock lock(table.mutex);
  table.rows.push_back({plain(folder), fs::weakly_canonical(folder), &guard});
}

GuardedFolder::~GuardedFolder() {
  GuardTable& table = guard_table();
  const std::unique_lock lock(table.mutex);
  std::erase_if(table.rows, [&](const Guarded& row) { return row.guard == guard_; });
}

GuardedPath guarded(const fs::path& path) {
  GuardTable& table = guard_table();
  const std::shared_lock lock(table.mutex);
  if (table.rows.empty()) return {};
  const fs::path given = plain(path);
  const fs::path canonical = fs::weakly_canonical(given.parent_path()) / given.filename();
  GuardedPath result;
  std::size_t depth = 0;
  for (const Guarded& row : table.rows) {
    fs::path below;
    // By its given name first: a link on the way is the guard's to see.
    if (!is_below(row.given, given, below) && !is_below(row.canonical, canonical, below)) continue;
    const auto own_depth =
        static_cast<std::size_t>(std::distance(row.canonical.begin(), row.canonical.end()));
    if (result.guard != nullptr && own_depth <= depth) continue;
    result = {row.guard, below};
    depth = own_depth;
  }
  return result;
}

std::string temporary_name(std::string_view file_name) {
  constexpr std::size_t kMostOfName = 200;  // of the 255 bytes that a name may have
  char digits[kDigits + 1];
  std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(random_number()));
  std::string name = ".";
  name += file_name.substr(0, kMostOfName);
  return name.append(kMark).append(digits).append(kEnding);
}

bool is_own_temporary(std::string_view file_name) {
  const std::size_t tail = kMark.size() + kDigits + kEnding.size();
  if (file_name.size() < tail + 1 || file_name.front() != '.') return false;
  const std::string_view end = file_name.substr(file_name.size() - tail);
  return end.starts_with(kMark) && end.ends_with(kEnding) &&
         end.substr(kMark.size(), kDigits).find_first_not_of("0123456789abcdef") ==
             std::string_view::npos;
}

WriteOutcome write_whole_file(const fs::path& file, std::string_view bytes) {
  const GuardedPath place = guarded(file);
  const bool may_replace = place.guard == nullptr || place.guard->before_write(place.below, bytes);
  if (file.has_parent_path()) {
    std::error_code error;
    fs::create_directories(file.parent_path(), error);
    if (error) return {error.value(), true};
  }
  const int code = write_and_rename(file, bytes, may_replace);
  if (code == EEXIST && place.guard != nullptr) place.guard->was_in_the_way(place.below);
  return {code, false};
}

bool remove_if_stale(const fs::path& temporary) {
  if (!is_own_temporary(temporary.filename().string())) return false;
  struct stat status {};
  if (::lstat(temporary.c_str(), &status) != 0) return errno == ENOENT;
  const bool is_folder = S_ISDIR(status.st_mode);
  if (!is_folder && !S_ISREG(status.st_mode)) return false;
  const int how = is_folder ? O_RDONLY | O_DIRECTORY : O_WRONLY;
  const Descriptor held(::open(temporary.c_str(), how | O_NOFOLLOW | O_CLOEXEC));
  if (held.get() < 0) return errno == ENOENT;
  if (::flock(held.get(), LOCK_EX | LOCK_NB) != 0 &&
      (!is_without_locks(errno) || !is_day_old(status)))
    return false;
  std::error_code failed;
  fs::remove_all(temporary, failed);
  return !failed;
}

PartFolder::PartFolder(const fs::path& final_name) : final_name_(final_name) {
  constexpr int kTries = 100;
  std::error_code error;
  if (final_name.has_parent_path()) fs::create_directories(final_name.parent_path(), error);
  for (int i = 0; !error && i < kTries; ++i) {
    path_ = final_name.parent_path() / temporary_name(final_name.filename().string());
    if (::mkdir(path_.c_str(), 0777) != 0) {
      if (errno != EEXIST) error.assign(errno, std::system_category());
      continue;
    }
    lock_ = ::open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (lock_ >= 0 && lock_new(lock_)) return;
    if (lock_ >= 0) ::close(std::exchange(lock_, -1));
  }
  throw std::runtime_error(final_name.string() + ": cannot make a folder beside it: " +
                           (error ? error.message() : "it is removed as soon as it is made"));
}

PartFolder::~PartFolder() {
  std::error_code ignored;
  if (!path_.empty()) fs::remove_all(path_, ignored);
  if (lock_ >= 0) ::close(lock_);
}

bool PartFolder::take_free_name() {
  const int code = rename_to_free_name(path_, final_name_);
  if (code == EEXIST || code == ENOTEMPTY) return false;
  if (code != 0)
    throw std::runtime_error(final_name_.string() + ": " + std::system_category().message(code));
  path_.clear();
  return true;
}

void PartFolder::replace() {
  const GuardedPath place = guarded(final_name_);
  if (place.guard != nullptr) {
    // As if each file were written under its final name.
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(path_)) {
      if (entry.is_regular_file())
        place.guard->before_write(place.below / entry.path().lexically_relative(path_),
                                  bytes_of(entry.path()));
    }
    for (const auto& entry : fs::symlink_status(final_name_).type() == fs::file_type::directory
                                 ? fs::recursive_directory_iterator(final_name_)
                                 : fs::recursive_directory_iterator()) {
      const fs::path below = place.below / entry.path().lexically_relative(final_name_);
      const bool is_folder = entry.is_directory() && !entry.is_symlink();
      if (!is_folder && !place.guard->is_own(below)) place.guard->was_in_the_way(below);
    }
  }
  const fs::path earlier =
      final_name_.parent_path() / temporary_name(final_name_.filename().string());
  std::error_code absent;
  fs::rename(final_name_, earlier, absent);
  if (!take_free_name())
    throw std::runtime_error(final_name_.string() + ": another process took the name");
  std::error_code left;  // what cannot be removed costs room, not the result
  fs::remove_all(earlier, left);
}

void own_all_in(const fs::path& folder) {
  const GuardedPath place = guarded(folder);
  if (place.guard != nullptr) place.guard->own_all_in(place.below);
}

bool remove_own(const fs::path& file) {
  const GuardedPath place = guarded(file);
  if (place.guard != nullptr && !place.guard->is_own(place.below)) return false;
  std::error_code failed;
  const bool was_there = fs::remove(file, failed);
  if (failed && fs::exists(fs::symlink_status(file)))
    throw std::runtime_error(file.string() + ": cannot be removed: " + failed.message());
  if (place.guard != nullptr) place.guard->after_remove(place.below);
  return was_there;
}

void remove_own_folder(const fs::path& folder) {
  if (fs::symlink_status(folder).type() != fs::file_type::directory) return;
  const GuardedPath place = guarded(folder);
  if (place.guard != nullptr && place.guard->is_own(place.below)) {
    fs::remove_all(folder);
    place.guard->after_remove(place.below);
    return;
  }
  std::vector<fs::path> entries;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    entries.push_back(entry.path());
  for (const fs::path& entry : entries) {
    if (fs::symlink_status(entry).type() == fs::file_type::directory)
      remove_own_folder(entry);
    else
      remove_own(entry);
  }
  std::error_code not_empty;  // then it holds what is somebody's
  fs::remove(folder, not_empty);
}

}  // namespace cousin
