#include "calibration/solve/option_fields.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string_view>

namespace cousin {
namespace {

constexpr std::array<std::string_view, 3> kLosses = {"none", "huber", "cauchy"};

}  // namespace

TextField loss_field(RobustLoss& loss) {
  return {
      [&loss] { return std::string(kLosses.at(static_cast<std::size_t>(loss))); },
      [&loss](const std::string& text) {
        const auto at = std::find(kLosses.begin(), kLosses.end(), text);
        if (at == kLosses.end())
          throw std::invalid_argument("loss \"" + text + "\" is not one of none, huber, cauchy");
        loss = static_cast<RobustLoss>(at - kLosses.begin());
      }};
}

TextField names_field(std::vector<std::string>& names) {
  return {[&names] {
            std::string text;
            for (const std::string& name : names) text += (text.empty() ? "" : ",") + name;
            return text;
          },
          [&names](const std::string& text) {
            names.clear();
            for (std::size_t from = 0; from < text.size();) {
              const std::size_t to = std::min(text.find(',', from), text.size());
              if (to > from) names.push_back(text.substr(from, to - from));
              from = to + 1;
            }
          }};
}

}  // namespace cousin
