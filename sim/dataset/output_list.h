#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/dataset/output_folder.h"

namespace cousin {

/// Private to sim/dataset: OUT/.cousin.VERB, the list of what a verb wrote into a folder. Its lines
/// are in output_list.cpp.
using Listed = std::vector<std::pair<std::string, std::string>>;  ///< path, SHA-256

inline constexpr std::string_view kListPrefix = ".cousin.";
inline constexpr std::size_t kListLimit_bytes = std::size_t{1} << 32;

struct ListedFile {
  std::set<std::string> hashes;
  std::string config;  ///< of the claim that wrote it last
};

struct OutputList {
  std::string config, version;  ///< of the last claim
  std::map<std::string, ListedFile> files;
  std::set<std::string> folders;  ///< the verb's with all they hold
};

/// A line that a kill cut off counts for nothing; a path that leads out of the folder is passed
/// over.
OutputList parse_list(const std::string& text);

/// The lines that a list is made of, each with its end.
std::string claim_line(const std::string& verb, const std::string& config,
                       const std::string& version);
std::string claim_line(const FolderClaim& claim);
std::string file_line(const std::string& hash, const std::string& path);
std::string folder_line(const std::string& path);
std::string removed_line(const std::string& path);

std::string config_of(const FolderClaim& claim);  ///< as lists have it
/// Whether a file is of another configuration than the claim's, which the claim's replaces.
bool is_of_other_config(const ListedFile& file, const FolderClaim& claim);

/// What a list says of a file with these bytes.
std::string hash_of(const std::filesystem::path& path, std::string_view bytes);
/// Whether `file` has bytes that the list has for `path`.
bool has_listed_bytes(const ListedFile& listed, const std::string& path,
                      const std::filesystem::path& file);
bool is_in_own_folder(const OutputList& list, const std::string& path);

std::filesystem::path list_file(const std::filesystem::path& folder, const std::string& verb);
/// The text of a verb's list; empty if there is none.
/// @throws std::invalid_argument where something else has its name
std::string text_of_list(const std::filesystem::path& folder, const std::string& verb);
/// Empty if there is no list. @param also_own  as OutputFolder's
OutputList read_list(const std::filesystem::path& folder, const FolderClaim& claim,
                     const Listed& also_own);
/// Another verb whose list has the file; empty if there is none.
std::string other_owner(const std::filesystem::path& folder, const std::string& path,
                        const std::string& verb);

}  // namespace cousin
