#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/types/board.h"
#include "sim/types/camera.h"
#include "sim/types/pose.h"

namespace cousin {

/// Private to sim/dataset: strict reading of JSON, and writing in the order given.
using Json = nlohmann::ordered_json;

/// A place in a JSON document that knows its name. Every check that fails is a std::runtime_error
/// "FILE: /json/pointer = value what is wrong and the limit".
class JsonNode {
 public:
  JsonNode(const nlohmann::json& value, const std::string& file, std::string pointer)
      : value_(&value), file_(&file), pointer_(std::move(pointer)) {}

  /// An object with all `required` keys and no others than these and `optional`.
  void expect_keys(std::initializer_list<std::string_view> required,
                   std::initializer_list<std::string_view> optional = {}) const;
  bool has(std::string_view key) const;
  JsonNode operator[](std::string_view key) const;  ///< a missing key is an error
  std::vector<std::pair<std::string, JsonNode>> members(
      std::size_t max_count) const;  ///< of an object, sorted

  std::size_t size(std::size_t max_count) const;  ///< of an array
  JsonNode operator[](std::size_t index) const;
  std::vector<JsonNode> elements(std::size_t max_count) const;

  double number(double min = -std::numeric_limits<double>::infinity(),
                double max = std::numeric_limits<double>::infinity()) const;  ///< finite
  double number_or_nan() const;                                               ///< null is NaN
  std::int64_t integer(std::int64_t min, std::int64_t max) const;
  std::uint64_t unsigned_integer() const;
  bool boolean() const;
  std::string text(std::size_t max_chars = 4096) const;
  bool is_null() const { return value_->is_null(); }
  bool is_object() const { return value_->is_object(); }
  bool is_array() const { return value_->is_array(); }
  bool is_number() const { return value_->is_number(); }
  bool is_text() const { return value_->is_string(); }
  bool is_false() const { return value_->is_boolean() && !value_->get<bool>(); }
  /// Array of finite numbers.
  std::vector<double> numbers(std::size_t min_count, std::size_t max_count) const;
  template <int N>
  Eigen::Matrix<double, N, 1> vector() const {
    return Eigen::Matrix<double, N, 1>(numbers(N, N).data());
  }
  /// Row-major.
  template <int Rows, int Columns>
  Eigen::Matrix<double, Rows, Columns> matrix() const {
    const std::vector<double> values = numbers(Rows * Columns, Rows * Columns);
    return Eigen::Matrix<double, Rows, Columns>(
        Eigen::Map<const Eigen::Matrix<double, Rows, Columns, Eigen::RowMajor>>(values.data()));
  }
  /// The value of a closed set of names; `values` are listed in the error.
  template <class Enum>
  Enum choice(std::initializer_list<Enum> values) const {
    const std::string name = text(64);
    std::string names;
    for (const Enum value : values) {
      if (to_string(value) == name) return value;
      names += (names.empty() ? "" : ", ") + std::string(to_string(value));
    }
    fail("is not one of " + names);
  }

  const std::string& file() const { return *file_; }
  [[noreturn]] void fail(const std::string& what) const;

 private:
  const nlohmann::json* value_;
  const std::string* file_;
  std::string pointer_;
};

/// Owns a parsed document; nodes refer into it.
class JsonDocument {
 public:
  /// @throws std::runtime_error naming `name` and the byte where the text stops being JSON, a key
  /// that stands twice in one object, or the memory that the text asks for.
  JsonDocument(std::string_view text, std::string name);
  static JsonDocument read(const std::filesystem::path& file);
  JsonNode root() const { return {value_, name_, ""}; }

 private:
  nlohmann::json value_;
  std::string name_;
};

/// Text that reads back equal, a key a line, arrays of numbers on one line.
/// @throws std::invalid_argument naming the pointer of a number that is not finite;
/// std::runtime_error naming that of a text or key that is not UTF-8.
std::string to_text(const Json& value);

/// null for NaN, which JSON does not have.
Json nan_to_null(double value);

Json to_json(const Camera& camera);
/// The camera, checked by validate(); the error adds `context` ("frame 3").
Camera read_camera(const JsonNode& node, const std::string& context);
/// {"rotation_wxyz": [...], "translation_m": [...]}.
Json to_json(const Pose& pose);
Pose read_pose(const JsonNode& node);
Json to_json(const SeedBoard& board);
SeedBoard read_board(const JsonNode& node);

template <class Derived>
Json to_json(const Eigen::MatrixBase<Derived>& matrix) {  ///< row-major
  Json array = Json::array();
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    for (Eigen::Index column = 0; column < matrix.cols(); ++column) {
      array.push_back(static_cast<double>(matrix(row, column)));
    }
  }
  return array;
}

/// "000012"
std::string six_digits(std::int64_t number);
/// Number of a name of six digits, or -1.
int number_of_six_digits(std::string_view name);

}  // namespace cousin
