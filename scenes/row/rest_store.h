#pragma once

#include <optional>
#include <string>

namespace cousin {

/// Keeps as text what takes seconds to come to rest.
class RestStore {
 public:
  struct Kept {
    std::string text;
    std::string where;  ///< for messages
  };

  virtual ~RestStore() = default;
  /// @param what  all that decides the text
  /// @throws std::runtime_error naming the file if it is damaged
  virtual std::optional<Kept> find(const std::string& what, const char* extension) const = 0;
  virtual void keep(const std::string& what, const char* extension,
                    const std::string& text) const = 0;
};

}  // namespace cousin
