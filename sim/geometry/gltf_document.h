#pragma once

#include <cstdint>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "sim/geometry/mesh_formats.h"

namespace cousin::geometry {

/// Private to sim/geometry: the JSON of a glTF file and the numbers behind its accessors. Every
/// check that fails is a std::runtime_error "FILE: /accessors/3/count = value what and the limit".
class GltfDocument {
 public:
  /// JSON text, or the binary container with its JSON and one buffer.
  GltfDocument(std::string_view bytes, std::string name, OpenFile open);

  const nlohmann::json& root() const { return root_; }
  const std::string& name() const { return name_; }  ///< of the file
  std::size_t count(const char* list) const;         ///< of a list at the top; 0 if there is none
  /// An entry of a list at the top. @param from  who names it, for the message
  const nlohmann::json& entry(const char* list, std::size_t index, const std::string& from) const;

  /// Numbers of an accessor, row by row, as the file normalises them.
  struct Values {
    std::size_t count = 0;       ///< rows
    std::size_t components = 0;  ///< numbers a row
    std::vector<float> numbers;
  };
  /// @param types  allowed, as "VEC3"  @param most_rows  more are refused
  Values read(std::size_t accessor, std::initializer_list<std::string_view> types,
              std::size_t most_rows);
  /// Whole numbers of a SCALAR accessor.
  std::vector<std::uint32_t> read_indices(std::size_t accessor, std::size_t most_rows);

  /// A whole number of an object, at most `most`; `otherwise` where it has no such key.
  std::size_t whole(const nlohmann::json& object, const char* key, const std::string& where,
                    std::size_t most, std::size_t otherwise) const;
  bool has(const nlohmann::json& object, const char* key) const;
  /// Numbers of an array of that many; `otherwise` where there is no such key.
  std::vector<double> numbers(const nlohmann::json& object, const char* key,
                              const std::string& where, std::size_t count,
                              std::vector<double> otherwise) const;
  [[noreturn]] void fail(const std::string& where, const std::string& what) const;

 private:
  /// Where an accessor's rows lie.
  struct Rows {
    std::size_t count = 0, components = 0, stride = 0;
    std::string_view bytes;  ///< from the first row on
    int component_type = 0;
    bool is_normalized = false;
  };
  Rows rows_of(std::size_t accessor, std::initializer_list<std::string_view> types,
               std::size_t most_rows);
  std::string_view buffer(std::size_t index);
  void parse_container(std::string_view bytes);
  nlohmann::json parse_json(std::string_view text) const;

  std::string name_;
  OpenFile open_;
  nlohmann::json root_;
  std::string_view binary_;  ///< of the container
  bool has_binary_ = false;
  std::vector<std::string> buffers_;
  std::vector<bool> is_loaded_;
  std::uint64_t loaded_bytes_ = 0;  ///< of all buffers
};

/// Bytes of base 64 [RFC 4648]; false for a character that has no place there.
bool decode_base64(std::string_view text, std::string& bytes);

}  // namespace cousin::geometry
