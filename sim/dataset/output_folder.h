#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace cousin {

/// What a command says of the folder that it writes into.
struct FolderClaim {
  std::string verb;     ///< "calibrate": letters, digits, -
  std::string version;  ///< of the program
  /// SHA-256 of all that decides the files; empty if any configuration may add to the folder.
  std::string config;
  /// Files and folders ("a", "a/b") that the command writes there: none may be somebody's. # stands
  /// for a digit, * for any letters.
  std::vector<std::string> names;
  enum class OtherConfig { refuse, replace };
  OtherConfig other_config = OtherConfig::replace;  ///< if a run of the verb had another one
  enum class Sharing { alone, shards };
  Sharing sharing = Sharing::alone;  ///< whether processes write there at the same time
  bool check_bytes = true;           ///< else files that are listed are taken to be unchanged
};

/// A folder while a command writes into it. OUT/.cousin.VERB lists what the verb has written there,
/// with SHA-256, a line before each file gets its name; only what it lists, and what still has the
/// listed bytes, is replaced or removed. Links are never followed. Every writer of files and
/// remove_own (whole_file.h) keep to it while this lives.
class OutputFolder {
 public:
  /// Makes the folder and takes it, in one step of the file system: of two commands that do not go
  /// together one is refused. Temporary files that killed processes left are cleared away.
  /// @param also_own  files (path below the folder, SHA-256) that another list says are the verb's
  /// @throws std::invalid_argument naming the file that is in the way, the configuration that the
  /// folder belongs to, or the command that is writing there
  OutputFolder(const std::filesystem::path& folder, FolderClaim claim,
               const std::vector<std::pair<std::string, std::string>>& also_own = {});
  ~OutputFolder();
  OutputFolder(OutputFolder&&) noexcept;

  /// Files that are the verb's own, below the folder; sorted.
  std::vector<std::string> files() const;
  /// Those of them that no process has written under the claim's configuration; sorted.
  std::vector<std::string> files_of_other_configs() const;
  /// Removes these: what is left of a run of another configuration, whoever stopped when.
  void remove_other_configs();
  /// Removes the verb's own files that this process has not written: an earlier run's.
  void remove_earlier();
  /// The folder has another list of its files from now on: .cousin.VERB goes.
  void release();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// What the constructor would refuse of what lies in the folder now, before any work; makes
/// nothing. @throws as that
void check_output_folder(const std::filesystem::path& folder, const FolderClaim& claim,
                         const std::vector<std::pair<std::string, std::string>>& also_own = {});

/// The verb whose list has a file of the folder; empty if there is none.
std::string owner_of(const std::filesystem::path& folder, const std::string& file);

/// Whether a file name is of a list of files (".cousin.VERB").
bool is_output_list(std::string_view file_name);

}  // namespace cousin
