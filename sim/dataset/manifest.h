#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace cousin {

std::string sha256_hex(std::string_view bytes);
std::string sha256_hex_of_file(const std::filesystem::path& file);
/// Of the names and bytes of what a manifest hashes below a folder; "absent" if it is none.
std::string sha256_hex_of_folder(const std::filesystem::path& folder);

struct Manifest {
  int schema = 1;
  std::string program_version;
  std::string config_hash;  ///< SHA-256 of what decided the dataset, such as its configuration
  std::string pipeline;
  std::vector<std::pair<std::string, std::string>>
      files;  ///< path below the dataset, SHA-256; sorted by path
};

/// Hashes everything below `dataset` except manifests, timings.json and lists of files
/// (output_folder.h), and writes manifest.json.
void write_manifest(const std::filesystem::path& dataset, Manifest header);
/// The same of `files` alone: what else lies there is somebody's.
void write_manifest(const std::filesystem::path& dataset, Manifest header,
                    const std::vector<std::filesystem::path>& files);
/// For shard i of n: hashes `files` only and writes manifest.i-of-n.json; the shard that completes
/// the set merges all into manifest.json, equal byte for byte to that of one run.
void write_shard_manifest(const std::filesystem::path& dataset, Manifest header, int shard,
                          int shards, const std::vector<std::filesystem::path>& files);
Manifest read_manifest_file(const std::filesystem::path& file);
std::optional<Manifest> read_manifest(const std::filesystem::path& dataset);

struct VerifyProblem {
  std::string path;
  std::string what;  ///< missing, changed, not in the manifest, escapes the dataset
};
/// Re-hashes. A dataset without truth/ is valid; one without a manifest is a real capture: its
/// files are read instead.
std::vector<VerifyProblem> verify(const std::filesystem::path& dataset);

}  // namespace cousin
