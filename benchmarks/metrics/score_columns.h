#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "benchmarks/metrics/scores.h"

namespace cousin {

/// One column of a table: its name and where its value lives in a row. CSV and JSON, readers and
/// writers, all go by these two lists.
template <class Row>
struct Column {
  const char* name;
  std::variant<std::string Row::*, double Row::*, std::int64_t Row::*, std::uint64_t Row::*,
               ScoreStatus Row::*>
      member;
};

const std::vector<Column<ScoreRow>>& score_columns();
const std::vector<Column<SpecimenRow>>& specimen_columns();

}  // namespace cousin
