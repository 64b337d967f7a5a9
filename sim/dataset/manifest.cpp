// manifest.json
//   {"schema": 1, "program_version": "...", "config_hash": "...", "pipeline": "...",
//    "files": {"000000/rig.json": "SHA-256 in 64 hex digits", ...}}             sorted by path, "/"
//    between folders
// manifest.i-of-n.json is the same for the files of shard i.

#include "sim/dataset/manifest.h"

#include <algorithm>
#include <map>
#include <mutex>
#include <set>
#include <stdexcept>

#include "sim/dataset/atomic_file.h"
#include "sim/dataset/capture_io.h"
#include "sim/dataset/for_each_frame.h"
#include "sim/dataset/json_interop.h"
#include "sim/dataset/links.h"
#include "sim/dataset/output_folder.h"
#include "sim/dataset/verify_progress.h"
#include "sim/types/utf8.h"

namespace cousin {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t kMaxFiles = 50'000'000;

bool is_hashed(const fs::path& relative) {
  const std::string name = relative.filename().string();
  if (is_temporary_name(name) || name == "timings.json") return false;
  const bool at_top = !relative.has_parent_path();
  return !(at_top &&
           (is_output_list(name) || (name.starts_with("manifest.") && name.ends_with(".json"))));
}

/// Hashed files below `dataset`, sorted; links are not followed into folders.
std::vector<std::string> list_files(const fs::path& dataset) {
  std::vector<std::string> result;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(dataset)) {
    if (entry.is_directory() && !entry.is_symlink()) continue;
    const fs::path relative = entry.path().lexically_relative(dataset);
    if (is_hashed(relative)) result.push_back(relative.generic_string());
  }
  std::sort(result.begin(), result.end());
  return result;
}

Manifest with_hashes(const fs::path& dataset, Manifest header, std::vector<std::string> paths) {
  for (const std::string& path : paths) {
    if (is_utf8(path)) continue;
    throw std::runtime_error(dataset.string() + ": the file name \"" + readable_utf8(path) +
                             "\" is not UTF-8, which a manifest is; rename it");
  }
  std::sort(paths.begin(), paths.end());
  paths.erase(std::unique(paths.begin(), paths.end()), paths.end());
  header.files.resize(paths.size());
  for_each_frame(paths.size(), [&](std::size_t i) {
    header.files[i] = {paths[i], sha256_hex_of_file(resolve_inside(dataset, paths[i]))};
  });
  return header;
}

std::string to_text(const Manifest& manifest) {
  const auto quoted = [](const std::string& text) {
    return Json(text).dump(-1, ' ', false, Json::error_handler_t::replace);
  };
  std::string text = "{\n \"schema\": " + std::to_string(manifest.schema);
  text += ",\n \"program_version\": " + quoted(manifest.program_version);
  text += ",\n \"config_hash\": " + quoted(manifest.config_hash);
  text += ",\n \"pipeline\": " + quoted(manifest.pipeline) + ",\n \"files\": {";
  for (std::size_t i = 0; i < manifest.files.size(); ++i) {
    const auto& [path, hash] = manifest.files[i];
    text += (i == 0 ? "\n  " : ",\n  ") + quoted(path) + ": " + quoted(hash);
  }
  return text + "\n }\n}\n";
}

Manifest parse_manifest(const JsonNode& root) {
  root.expect_keys({"schema", "program_version", "config_hash", "pipeline", "files"});
  Manifest manifest;
  manifest.schema = static_cast<int>(root["schema"].integer(1, 1));
  manifest.program_version = root["program_version"].text();
  manifest.config_hash = root["config_hash"].text();
  manifest.pipeline = root["pipeline"].text();
  for (const auto& [path, node] : root["files"].members(kMaxFiles)) {
    const std::string hash = node.text();
    if (hash.size() != 64 || hash.find_first_not_of("0123456789abcdef") != std::string::npos) {
      node.fail("is not a SHA-256 of 64 hex digits");
    }
    manifest.files.emplace_back(path, hash);
  }
  std::sort(manifest.files.begin(), manifest.files.end());
  return manifest;
}

/// Those of `files` that manifests list, as paths below the dataset.
std::vector<std::string> hashed_of(const fs::path& dataset, const std::vector<fs::path>& files) {
  std::vector<std::string> paths;
  for (const fs::path& file : files) {
    const fs::path relative =
        file.is_absolute()
            ? fs::weakly_canonical(file).lexically_relative(fs::weakly_canonical(dataset))
            : file.lexically_normal();
    if (is_hashed(relative)) paths.push_back(relative.generic_string());
  }
  return paths;
}

fs::path shard_file(const fs::path& dataset, int shard, int shards) {
  return dataset /
         ("manifest." + std::to_string(shard) + "-of-" + std::to_string(shards) + ".json");
}

/// One manifest from those of all shards.
Manifest merge(const fs::path& dataset, int shards) {
  Manifest merged;
  std::map<std::string, std::string> files;
  for (int i = 0; i < shards; ++i) {
    const fs::path file = shard_file(dataset, i, shards);
    const JsonDocument document = JsonDocument::read(file);
    const Manifest part = parse_manifest(document.root());
    if (i == 0) {
      merged = part;
    } else if (part.program_version != merged.program_version ||
               part.config_hash != merged.config_hash || part.pipeline != merged.pipeline) {
      throw std::runtime_error(
          file.string() +
          ": program version, configuration or pipeline differ from shard 0's; the shards are of "
          "different runs");
    }
    for (const auto& [path, hash] : part.files) {
      const auto [found, is_new] = files.emplace(path, hash);
      if (!is_new && found->second != hash) {
        throw std::runtime_error(file.string() + ": " + path +
                                 " has another hash in an earlier shard");
      }
    }
  }
  merged.files.assign(files.begin(), files.end());
  return merged;
}

/// SCENE/truth for a path below it, else empty.
std::string truth_folder(const std::string& path) {
  const std::size_t slash = path.find('/');
  if (slash == std::string::npos || path.compare(slash, 7, "/truth/") != 0) return {};
  return path.substr(0, slash + 6);
}

using StepsDone = std::function<void(int done, int total)>;

/// A dataset without a manifest: what reading it says.
std::vector<VerifyProblem> verify_by_reading(const fs::path& dataset, const StepsDone& progress) {
  std::vector<VerifyProblem> problems;
  std::vector<fs::path> scenes = scene_folders(dataset);
  if (scenes.empty()) scenes.push_back(dataset);
  int done = 0;
  for (const fs::path& scene : scenes) {
    if (progress) progress(done++, static_cast<int>(scenes.size()));
    try {
      refuse_links_out(dataset, scene.lexically_relative(dataset));
      read_capture(scene);
    } catch (const std::runtime_error& error) {
      const fs::path relative = scene.lexically_relative(dataset);
      problems.push_back({relative.generic_string(), error.what()});
    }
  }
  return problems;
}

}  // namespace

std::string sha256_hex_of_folder(const fs::path& folder) {
  if (!fs::is_directory(folder)) return "absent";
  std::string hashes;
  for (const std::string& file : list_files(folder))
    hashes += file + " " + sha256_hex_of_file(folder / file) + "\n";
  return sha256_hex(hashes);
}

void write_manifest(const fs::path& dataset, Manifest header) {
  write_file(dataset / "manifest.json",
             to_text(with_hashes(dataset, std::move(header), list_files(dataset))));
}

void write_manifest(const fs::path& dataset, Manifest header, const std::vector<fs::path>& files) {
  write_file(dataset / "manifest.json",
             to_text(with_hashes(dataset, std::move(header), hashed_of(dataset, files))));
}

void write_shard_manifest(const fs::path& dataset, Manifest header, int shard, int shards,
                          const std::vector<fs::path>& files) {
  if (shards < 1 || shard < 0 || shard >= shards) {
    throw std::invalid_argument("shard " + std::to_string(shard) + " of " + std::to_string(shards) +
                                " is outside 0 <= i < n");
  }
  write_file(shard_file(dataset, shard, shards),
             to_text(with_hashes(dataset, std::move(header), hashed_of(dataset, files))));
  for (int i = 0; i < shards; ++i) {
    if (!fs::exists(shard_file(dataset, i, shards))) return;
  }
  write_file(dataset / "manifest.json", to_text(merge(dataset, shards)));
}

Manifest read_manifest_file(const fs::path& file) {
  const JsonDocument document = JsonDocument::read(file);
  return parse_manifest(document.root());
}

std::optional<Manifest> read_manifest(const fs::path& dataset) {
  const fs::path file = dataset / "manifest.json";
  if (!fs::exists(file)) return std::nullopt;
  return read_manifest_file(file);
}

std::vector<VerifyProblem> verify(const fs::path& dataset) { return verify(dataset, {}); }

std::vector<VerifyProblem> verify(const fs::path& dataset,
                                  const std::function<void(int done, int total)>& progress) {
  if (!fs::is_directory(dataset)) throw std::runtime_error(dataset.string() + ": not a folder");
  refuse_links_out(dataset, "manifest.json");
  const std::optional<Manifest> manifest = read_manifest(dataset);
  if (!manifest) return verify_by_reading(dataset, progress);

  std::vector<std::string> what(manifest->files.size());  // empty = as listed
  std::mutex telling;
  int done = 0;
  for_each_frame(manifest->files.size(), [&](std::size_t i) {
    if (progress) {
      const std::lock_guard lock(telling);
      progress(done++, static_cast<int>(what.size()));
    }
    const auto& [path, hash] = manifest->files[i];
    fs::path file;
    try {
      file = resolve_inside(dataset, path);
    } catch (const std::runtime_error&) {
      what[i] = "escapes the dataset";
      return;
    }
    if (fs::is_regular_file(file)) {
      if (sha256_hex_of_file(file) != hash) what[i] = "changed";
      return;
    }
    const std::string truth = truth_folder(path);
    if (truth.empty() || fs::exists(dataset / truth)) what[i] = "missing";
  });

  std::vector<VerifyProblem> problems;
  std::set<std::string> listed;
  for (std::size_t i = 0; i < what.size(); ++i) {
    listed.insert(manifest->files[i].first);
    if (!what[i].empty()) problems.push_back({manifest->files[i].first, what[i]});
  }
  for (const std::string& path : list_files(dataset)) {
    if (!listed.contains(path)) problems.push_back({path, "not in the manifest"});
  }
  std::sort(problems.begin(), problems.end(),
            [](const VerifyProblem& a, const VerifyProblem& b) { return a.path < b.path; });
  return problems;
}

}  // namespace cousin
