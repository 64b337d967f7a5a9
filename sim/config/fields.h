#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace cousin {

/// An enum (or any value) that text names.
struct TextField {
  std::function<std::string()> get;
  std::function<void(const std::string&)> set;  ///< throws std::invalid_argument naming the choices
};

/// One configuration value: where it lives, its key, what it means and its limits.
struct Field {
  std::string key;  ///< dotted for nested structs: "mvs.planes"
  std::variant<double*, int*, std::uint64_t*, bool*, std::string*, std::vector<double>*, TextField>
      value;
  std::string help;
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool optional = false;  ///< may be missing where MissingKeys::error
};

/// The one description of a configuration struct, from which TOML in and out, `--set` and `--help`
/// are made. A struct `FooConfig` has `Fields fields(FooConfig& config);` beside it; the fields
/// point into `config`.
using Fields = std::vector<Field>;

/// `inner` under "prefix." keys, for structs nested by value.
Fields nested(std::string_view prefix, Fields inner);
Fields operator+(Fields a, Fields b);

enum class MissingKeys {
  keep_default,  ///< a user's file or --set
  error          ///< the base TOML of a scene or preset
};

/// Reads a TOML file into the fields. @throws std::runtime_error naming file, line, key, value and
/// limit for an unknown key, a wrong type, a value outside [min, max] or not finite, or a missing
/// key.
void read_toml(const std::filesystem::path& file, const Fields& fields, MissingKeys missing);
void read_toml_text(std::string_view text, std::string_view name, const Fields& fields,
                    MissingKeys missing);

/// Names of the tables that a TOML text has at its top, in the order of their first lines: which
/// parts a file describes, before its fields are known. @throws std::runtime_error as read_toml for
/// what is not TOML.
std::vector<std::string> toml_tables(std::string_view text, std::string_view name);

/// All fields as TOML, one key a line, tables for nested structs; doubles print so that they read
/// back equal.
std::string to_toml(const Fields& fields);

/// "key=value" from the command line; strings need no quotes. @throws std::invalid_argument as
/// read_toml, with the nearest key that exists.
void set_field(const Fields& fields, std::string_view assignment);

/// Lines of "key  default  [min, max]  help" for --help.
std::string describe(const Fields& fields);

}  // namespace cousin
