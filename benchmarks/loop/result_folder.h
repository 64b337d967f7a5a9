#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "benchmarks/score/scores.h"

namespace cousin {

/// Makes the folder and writes a file there that is removed again: a folder that cannot take
/// results is an error before minutes are spent on them. @throws std::runtime_error naming the
/// path.
void require_writable(const std::filesystem::path& folder);

/// What write_result_tables writes, and `more`: names for a FolderClaim.
std::vector<std::string> result_names(std::vector<std::string> more = {});

/// scores.csv, specimens.csv and scores.json of a run or benchmark, whole or not at all each.
void write_result_tables(const std::filesystem::path& folder, const ScoreFile& file);

/// scores.json back. @throws std::runtime_error naming the file.
ScoreFile read_result_tables(const std::filesystem::path& folder);

/// Processor name, cores and memory of this machine, for score headers.
std::string machine_text();

/// Total rows that a person wants to see first, as aligned text in millimetres: pooled RMSE, bias,
/// MAPE, slope, coverage.
std::string summary_table(const std::vector<ScoreRow>& rows);

}  // namespace cousin
