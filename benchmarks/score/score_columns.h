#pragma once

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "benchmarks/score/scores.h"

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

/// Only a score and its interval may be infinite: no ruler gives an infinite length, no clock an
/// infinite time. @throws std::invalid_argument saying what the number must be.
template <class Row, class Value>
void check_number(const Column<Row>& column, const Value& value) {
  if constexpr (std::is_same_v<Value, double>) {
    const std::string_view name = column.name;
    if (!std::isinf(value) || name == "value" || name == "ci_low" || name == "ci_high") return;
    throw std::invalid_argument("expected a finite number or none");
  }
}

const std::vector<Column<ScoreRow>>& score_columns();
/// Those of schema 1: the first of them.
inline constexpr std::size_t kColumnsOfSchema1 = 16;
/// What schema 1 says in names alone: fills settings from "RUN 0 60 views 1920x1080, one in 8 held
/// out, poses sfm, 7000 steps" and "sample 0, 30 views, 400x300, 7000 steps". Limits are not known.
/// Nothing else reads names.
void settings_of_schema_1(ScoreRow& row);
const std::vector<Column<SpecimenRow>>& specimen_columns();

}  // namespace cousin
