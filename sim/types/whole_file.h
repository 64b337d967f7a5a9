#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace cousin {

/// Keeps what lies in a folder that a command writes into from being replaced.
class FolderGuard {
 public:
  FolderGuard() = default;
  FolderGuard(const FolderGuard&) = delete;
  FolderGuard& operator=(const FolderGuard&) = delete;
  virtual ~FolderGuard() = default;

  /// Told of a file before it is made. @param below  its path below the folder
  /// @returns whether a file of this name is the command's own, and may be replaced
  /// @throws std::invalid_argument naming what is in the way
  virtual bool before_write(const std::filesystem::path& below, std::string_view bytes) = 0;
  /// A file of that name turned up between `before_write` and the rename; throws as that.
  virtual void was_in_the_way(const std::filesystem::path& below) = 0;
  /// Whether a file or folder is the command's own, and may be removed.
  virtual bool is_own(const std::filesystem::path& below) = 0;
  virtual void after_remove(const std::filesystem::path& below) = 0;
  /// All in this folder is the command's own from now on, as what another program writes for it.
  virtual void own_all_in(const std::filesystem::path& below) = 0;
};

/// Lets `guard` answer for `folder` in this process, from any thread and through every writer of
/// files, while this lives. Writers that are handed a path alone find it here.
class GuardedFolder {
 public:
  GuardedFolder(const std::filesystem::path& folder, FolderGuard& guard);
  GuardedFolder(const GuardedFolder&) = delete;
  GuardedFolder& operator=(const GuardedFolder&) = delete;
  ~GuardedFolder();

 private:
  FolderGuard* guard_;
};

/// The innermost guarded folder that a path lies in.
struct GuardedPath {
  FolderGuard* guard = nullptr;  ///< none: the path is in no guarded folder
  std::filesystem::path below;
};
GuardedPath guarded(const std::filesystem::path& path);

/// ".NAME.cousin-0123456789abcdef.part": unlike any other, also of processes with the same number.
std::string temporary_name(std::string_view file_name);
/// Whether temporary_name made it.
bool is_own_temporary(std::string_view file_name);

/// 0, or what failed and the system's number for it.
struct WriteOutcome {
  int error = 0;
  bool making_folder = false;  ///< the parent folder could not be made
};
/// Makes the parent folder, writes beside the final name, flushes, checks every error (a full disk
/// too), then renames; whatever fails, nothing new stays. The temporary file is locked while its
/// process lives. A link of the final name is replaced, not followed.
/// @throws as the guard of the file's folder
WriteOutcome write_whole_file(const std::filesystem::path& file, std::string_view bytes);

/// Removes a temporary file or folder of ours whose process is gone; where locks do not work (some
/// network disks), one that is a day old. @returns whether it is gone
bool remove_if_stale(const std::filesystem::path& temporary);

/// A folder under a temporary name beside the final one, for what is whole only together. Removed
/// with what it holds unless it took its name.
class PartFolder {
 public:
  /// @throws std::runtime_error naming the folder
  explicit PartFolder(const std::filesystem::path& final_name);
  PartFolder(const PartFolder&) = delete;
  PartFolder& operator=(const PartFolder&) = delete;
  ~PartFolder();
  const std::filesystem::path& path() const { return path_; }

  /// Takes the final name if nothing has it. @returns whether it did
  bool take_free_name();
  /// Takes the final name from a folder whose files are all the command's own; that is removed.
  /// @throws std::invalid_argument naming what is in the way
  void replace();

 private:
  std::filesystem::path final_name_;
  std::filesystem::path path_;
  int lock_ = -1;
};

/// Tells the guard of the folder's place, if there is one, that a folder which the caller has made,
/// or has found to be its own, is the command's with all it holds.
void own_all_in(const std::filesystem::path& folder);
/// Removes a file that is the command's own, or that lies in no guarded folder. A link is removed
/// in place of what it leads to. @returns whether it was there and is gone
bool remove_own(const std::filesystem::path& file);
/// The same for all files below a folder, and for folders that are empty then. Links to folders are
/// not followed.
void remove_own_folder(const std::filesystem::path& folder);

}  // namespace cousin
