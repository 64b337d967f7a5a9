#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace cousin {

/// Bytes of the well-formed UTF-8 character at the start of the text (Unicode 15, table 3-7: no
/// overlong form, no surrogate, nothing above U+10FFFF); 0 if there is none.
std::size_t utf8_character_bytes(std::string_view text);

bool is_utf8(std::string_view text);

/// The text with every byte that is no part of UTF-8 shown as "\xe9", so that it can stand in JSON,
/// in HTML and on a terminal. Text that is UTF-8 stays as it is.
std::string readable_utf8(std::string_view text);

/// The longest start of the text that has at most `most_bytes` bytes and cuts no character.
std::string cut_utf8(std::string_view text, std::size_t most_bytes);

/// Text that may hold anything, for a terminal or a log: control characters, marks that turn the
/// direction of writing, line breaks, and bytes that are not UTF-8 are shown ("\x1b", "\u202e"), so
/// that nothing inside the text can begin a line of its own. A tab stays.
std::string terminal_text(std::string_view text);

}  // namespace cousin
