#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "sim/config/fields.h"

namespace cousin {

/// What a file or a command line gave for a key, before it is checked against the field. Private to
/// sim/config.
using FieldValue = std::variant<bool, std::int64_t, double, std::string, std::vector<double>>;

/// Writes `value` through the field. Integers pass as doubles, never the other way round.
/// @throws std::invalid_argument "key = value: must be ..." with the limit.
void assign(const Field& field, const FieldValue& value);

/// The field whose key is `key`, or nullptr.
const Field* find(const Fields& fields, std::string_view key);

/// "unknown key 'x'; the nearest key is 'y'", or what there is where no key has nearly that name.
std::string unknown_key_message(const Fields& fields, std::string_view key);

/// Shortest decimal text that reads back to the same double.
std::string shortest(double value);
/// The field's present value as TOML.
std::string value_as_toml(const Field& field);

}  // namespace cousin
