#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "benchmarks/score/scores.h"

namespace cousin {

/// The limit of a row of `bench seeds` at the paper's imaging (1920 x 1080, 60 or 270 views): of
/// our method's pooled rows, of its ratio to the paper's, and of the runs with 270 views; and of
/// the models trained on 60 views of 1280 x 720 (suite seeds_splats). Other rows have none.
std::optional<ScoreLimit> seeds_limit(const ScoreRow& row);

/// Adds a number that there is none of, if it has a limit: a limit is not kept by what is missing.
/// @param base  labels
void add_missing(std::vector<ScoreRow>& rows, ScoreRow base, const std::string& metric,
                 const std::string& unit);

/// Gives each row that has a limit the status pass or fail; a number that is missing fails. Numbers
/// over a species, or over all, are held to theirs only where each of its cultivars was measured.
/// @param cultivars  that were
void hold_to_limits(std::vector<ScoreRow>& rows, const std::set<std::string>& cultivars);

/// Limits of rows that kept or broke one and do not say which: files of schema 1 have none.
void add_limits_of_schema_1(std::vector<ScoreRow>& rows);

/// The same of suite seeds_splats: of each capture and method the model of most steps is held, and
/// ratios over all where each cultivar is there.
void hold_trained_to_limits(std::vector<ScoreRow>& rows);

}  // namespace cousin
