#pragma once

#include <string_view>

namespace cousin {

/// The files of assets/, compiled in at configure time.
extern const std::string_view kReportCss;
extern const std::string_view kErrorsJs;
extern const std::string_view kReportJs;
extern const std::string_view kView3dJs;
extern const std::string_view kSplats3dJs;

}  // namespace cousin
