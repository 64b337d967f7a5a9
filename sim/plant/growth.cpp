#include "sim/plant/growth.h"

#include <cmath>
#include <stdexcept>
#include <string>

namespace cousin {

double size_at(const BetaGrowth& growth, double age_days) {
  const double te = growth.duration_days, tm = growth.fastest_days;
  if (!(te > 0 && tm >= 0 && tm < te)) {
    throw std::invalid_argument("growth: fastest_days = " + std::to_string(tm) +
                                " must be in [0, duration_days = " + std::to_string(te) + ")");
  }
  if (age_days <= 0) return 0;
  if (age_days >= te) return growth.final;
  return growth.final * (1 + (te - age_days) / (te - tm)) * std::pow(age_days / te, te / (te - tm));
}

double logistic(double days, double middle_days, double scale_days) {
  return 1 / (1 + std::exp(-(days - middle_days) / scale_days));
}

void check_day(double day, double last_day, const char* what) {
  if (day >= 0 && day <= last_day) return;
  throw std::invalid_argument("day = " + std::to_string(day) + " is not in [0, " +
                              std::to_string(last_day) + "], the days that " + what +
                              " are grown for");
}

}  // namespace cousin
