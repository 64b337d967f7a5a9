#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace cousin::geometry {

/// The two parts of a PLY file [Turk 1994] that every reader shares: its header, and its numbers
/// one after the other. Files come from elsewhere: nothing is read past their end, and errors are
/// std::runtime_error with the file's name and the line or byte.
enum class PlyEncoding { ascii, little, big };
enum class PlyType { i8, u8, i16, u16, i32, u32, f32, f64 };
std::size_t size_of(PlyType type);  ///< bytes, in the binary encodings

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::f32;  ///< of the value, or of a list's items
  bool is_list = false;
  PlyType count_type = PlyType::u8;  ///< of a list's length
};
struct PlyElementHeader {
  std::string name;
  std::size_t count = 0;  ///< at most 2^26
  std::vector<PlyProperty> properties;
};
struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::ascii;
  std::vector<PlyElementHeader> elements;
  std::vector<std::string> comments;  ///< what follows the word "comment"
  std::size_t body = 0;               ///< offset of the first byte after end_header
};
PlyHeader parse_ply_header(std::string_view bytes, const std::string& name);

/// Reads numbers of any type from the body, text or binary; never past its end. `bytes` and `name`
/// must outlive it.
class PlyBody {
 public:
  PlyBody(std::string_view bytes, std::size_t offset, PlyEncoding encoding, const std::string& name)
      : bytes_(bytes), at_(offset), encoding_(encoding), name_(name) {}

  double number(PlyType type) {
    return encoding_ == PlyEncoding::ascii ? text_number() : binary_number(type);
  }
  /// The length of a list that comes next, which the bytes left can hold.
  std::size_t list_length(const PlyProperty& property);
  /// Ends where the bytes left cannot hold the element's rows: before anything is allocated.
  void require_rows(const PlyElementHeader& element) const;
  std::size_t left() const { return bytes_.size() - at_; }
  /// Bytes left, from the first that is neither a blank nor the end of a line.
  std::size_t left_but_blanks() const;
  std::string where() const { return "byte " + std::to_string(at_); }

 private:
  double text_number();
  double binary_number(PlyType type);
  template <class T>
  double take();

  std::string_view bytes_;
  std::size_t at_;
  PlyEncoding encoding_;
  const std::string& name_;
};

/// Reads past all rows of an element.
void skip_rows(const PlyElementHeader& element, PlyBody& body);

}  // namespace cousin::geometry
