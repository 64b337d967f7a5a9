#include "tests/places/places.h"

namespace cousin {

std::filesystem::path source_folder() { return COUSIN_SOURCE_DIR; }

std::filesystem::path real_data() { return COUSIN_REAL_DATA; }

}  // namespace cousin
