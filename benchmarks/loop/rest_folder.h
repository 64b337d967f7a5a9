#pragma once

#include <filesystem>
#include <string>

#include "scenes/row/rest_store.h"

namespace cousin {

/// A folder that keeps plants at rest. Each file is named by a hash of all that decides it, and
/// begins with the hash of all that follows.
class RestFolder final : public RestStore {
 public:
  explicit RestFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

  std::filesystem::path file(const std::string& what, const char* extension) const;
  std::optional<Kept> find(const std::string& what, const char* extension) const override;
  void keep(const std::string& what, const char* extension, const std::string& text) const override;

 private:
  std::filesystem::path folder_;
};

}  // namespace cousin
