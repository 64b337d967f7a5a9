#pragma once

#include <filesystem>
#include <string>

namespace cousin {

/// Readers call this before they take memory for a file, so that a program that runs out of memory
/// can say what it was reading. Any thread may.
void note_reading(const std::filesystem::path& file);

/// The file that was noted last; "" if none was.
std::string last_read();

}  // namespace cousin
