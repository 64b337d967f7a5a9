#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace cousin::geometry {

/// Private to sim/geometry: the words of a mesh file that is text, one after another, with the line
/// they stand on.
class MeshWords {
 public:
  /// `name` is the file's, for messages; both must outlive it. @param joins_lines  a line that ends
  /// with a backslash goes on in the next one
  MeshWords(std::string_view text, const std::string& name, bool joins_lines = false)
      : text_(text), name_(name), joins_lines_(joins_lines) {}

  std::string_view next();
  /// The next word of this line; empty at its end.
  std::string_view next_on_line();
  /// What is left of this line, without blanks around it.
  std::string_view rest_of_line();
  void skip_line() { rest_of_line(); }

  /// A finite number. @throws std::runtime_error naming file, line and word
  double number(std::string_view word) const;
  [[noreturn]] void fail(const std::string& what) const;
  std::string where() const { return "line " + std::to_string(line_); }
  const std::string& name() const { return name_; }

 private:
  /// Bytes of a backslash and the line's end behind it; 0 if there is none here.
  std::size_t joint() const;
  void skip_blanks(bool lines_too);

  std::string_view text_;
  const std::string& name_;
  bool joins_lines_;
  std::size_t at_ = 0;
  std::size_t line_ = 1;
};

}  // namespace cousin::geometry
