#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace cousin {

/// Private to sim/dataset: files of words and numbers, a record a line (COLMAP, TUM).

/// Shortest decimal text that reads back to the same double: at most 17 digits.
std::string exact_text(double value);
/// At most four digits, for messages.
std::string short_text(double value);
/// The exact texts of numbers, with `between` between them.
std::string exact_text(const std::vector<double>& values, std::string_view between = " ");

/// One line of a file that knows its place. Errors are std::runtime_error "NAME: line 3: ...".
class TextLine {
 public:
  TextLine(std::string_view text, const std::string& name, int number);

  std::size_t size() const { return words_.size(); }
  std::string text(std::size_t word) const;  ///< a missing word is an error
  /// From that word to the end of the line, blanks inside kept.
  std::string rest(std::size_t word) const;
  double number(std::size_t word) const;                      ///< finite
  double number_within(std::size_t word, double most) const;  ///< of at most that size
  bool is_number(std::size_t word) const;                     ///< there, and finite
  bool is_integer(std::size_t word) const;  ///< there, with a sign or without, of any size
  long long integer(std::size_t word, long long min, long long max) const;
  [[noreturn]] void fail(const std::string& what) const;
  std::string where() const;  ///< "NAME: line 3: "
  int line_number() const { return number_; }

 private:
  std::string_view text_;
  const std::string* name_;
  int number_;
  std::vector<std::string_view> words_;
};

/// Lines of a text with what ends them (newline, carriage return) cut off.
class TextLines {
 public:
  TextLines(std::string_view text, const std::string& name) : rest_(text), name_(&name) {}
  bool at_end() const { return rest_.empty(); }
  TextLine next();

 private:
  std::string_view rest_;
  const std::string* name_;
  int number_ = 0;
};

/// All lines but empty ones and those that start with "#".
std::vector<TextLine> records(std::string_view text, const std::string& name);

}  // namespace cousin
