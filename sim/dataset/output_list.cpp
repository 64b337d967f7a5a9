// OUT/.cousin.VERB, a record a line; a line that a kill cut off counts for nothing:
//   = VERB CONFIG VERSION     who writes from here on; CONFIG is SHA-256, or - for any
//   + SHA-256 PATH            a file is about to get its name
//   / PATH                    a folder is the verb's with all it holds
//   - PATH                    a file or such a folder was removed
// In PATH a line's end is \n and a backslash is \\. SHA-256 is * for timings.json, which may
// change. A path may have several hashes: a process that was killed between the line and the rename
// leaves the file as it was. A file is of the configuration that the last = before its last +
// names.

#include "sim/dataset/output_list.h"

#include <sstream>
#include <stdexcept>
#include <system_error>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/manifest.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;

std::string escaped(const std::string& path) {
  std::string text;
  for (const char c : path) text += c == '\n' ? "\\n" : c == '\\' ? "\\\\" : std::string(1, c);
  return text;
}

std::string unescaped(const std::string& text) {
  std::string path;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool is_escape = text[i] == '\\' && i + 1 < text.size();
    path += !is_escape ? text[i] : text[i + 1] == 'n' ? '\n' : text[i + 1];
    if (is_escape) ++i;
  }
  return path;
}

/// Whether a path leads to a place below the folder, however it is written.
bool is_inside(const fs::path& path) {
  return !path.empty() && path.is_relative() && path == path.lexically_normal() &&
         *path.begin() != ".." && *path.begin() != ".";
}

/// Seconds change with every run: the name is enough.
bool is_by_name(const fs::path& path) { return path.filename() == "timings.json"; }

}  // namespace

OutputList parse_list(const std::string& text) {
  OutputList list;
  std::istringstream lines(text.substr(0, text.rfind('\n') + 1));
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string kind, hash, path;
    words >> kind;
    if (kind == "=") {
      std::string verb;
      words >> verb >> list.config;
      words.get();
      std::getline(words, list.version);
      continue;
    }
    if (kind == "+") words >> hash;
    words.get();
    if (!std::getline(words, path)) continue;
    path = unescaped(path);
    if (!is_inside(path)) continue;
    if (kind == "+") {
      list.files[path].hashes.insert(hash);
      list.files[path].config = list.config;
    }
    if (kind == "/") list.folders.insert(path);
    if (kind != "-") continue;
    list.files.erase(path);
    list.folders.erase(path);
  }
  return list;
}

std::string config_of(const FolderClaim& claim) {
  return claim.config.empty() ? "-" : claim.config;
}

std::string claim_line(const std::string& verb, const std::string& config,
                       const std::string& version) {
  return "= " + verb + " " + config + " " + version + "\n";
}
std::string claim_line(const FolderClaim& claim) {
  return claim_line(claim.verb, config_of(claim), claim.version);
}

bool is_of_other_config(const ListedFile& file, const FolderClaim& claim) {
  return !claim.config.empty() && file.config != claim.config;
}

std::string file_line(const std::string& hash, const std::string& path) {
  return "+ " + hash + " " + escaped(path) + "\n";
}

std::string folder_line(const std::string& path) { return "/ " + escaped(path) + "\n"; }

std::string removed_line(const std::string& path) { return "- " + escaped(path) + "\n"; }

std::string hash_of(const fs::path& path, std::string_view bytes) {
  return is_by_name(path) ? "*" : sha256_hex(bytes);
}

bool has_listed_bytes(const ListedFile& listed, const std::string& path, const fs::path& file) {
  return (is_by_name(path) && listed.hashes.contains("*")) ||
         listed.hashes.contains(sha256_hex_of_file(file));
}

fs::path list_file(const fs::path& folder, const std::string& verb) {
  return folder / (std::string(kListPrefix) + verb);
}

std::string text_of_list(const fs::path& folder, const std::string& verb) {
  const fs::path file = list_file(folder, verb);
  const fs::file_type type = fs::symlink_status(file).type();
  if (type == fs::file_type::not_found) return {};
  std::string text;
  if (type == fs::file_type::regular) text = read_file(file, kListLimit_bytes);
  const std::string first = "= " + verb + " ";  // of which a kill may have left a part
  if (type == fs::file_type::regular &&
      (text.starts_with(first) || first.starts_with(std::string_view(text))))
    return text;
  throw std::invalid_argument(file.string() +
                              " is in the way: it is not the list of files that `cousin " + verb +
                              "` keeps there. Move it away, or choose another --out");
}

OutputList read_list(const fs::path& folder, const FolderClaim& claim, const Listed& also_own) {
  OutputList list = parse_list(text_of_list(folder, claim.verb));
  for (const auto& [path, hash] : also_own) {
    ListedFile& file = list.files[path];
    file.hashes.insert(hash);
    if (file.config.empty()) file.config = config_of(claim);
  }
  return list;
}

bool is_in_own_folder(const OutputList& list, const std::string& path) {
  fs::path above = path;
  while (!above.empty() && !list.folders.contains(above.generic_string()))
    above = above.parent_path();
  return !above.empty();
}

std::string other_owner(const fs::path& folder, const std::string& path, const std::string& verb) {
  std::error_code unreadable;
  for (const auto& entry : fs::directory_iterator(folder, unreadable)) {
    const std::string name = entry.path().filename().string();
    if (!is_output_list(name) || name.substr(kListPrefix.size()) == verb) continue;
    if (!fs::is_regular_file(fs::symlink_status(entry.path()))) continue;  // no list of ours
    if (parse_list(read_file(entry.path(), kListLimit_bytes)).files.contains(path))
      return name.substr(kListPrefix.size());
  }
  return {};
}

}  // namespace cousin
