#pragma once

namespace cousin {

/// How an organ's size goes from 0 at age 0 to `final` at `duration_days`, where it stays: the beta
/// function, fastest at `fastest_days` [Yin, Goudriaan, Lantinga, Vos & Spiertz, Annals of Botany
/// 91 (2003), eq. 8]: w = final (1 + (te - t) / (te - tm)) (t / te)^(te / (te - tm)).
struct BetaGrowth {
  double final = 1;
  double duration_days = 10;  ///< te
  double fastest_days = 5;    ///< tm, in [0, te)
};
/// 0 for ages below 0. @throws std::invalid_argument for durations that are not in order.
double size_at(const BetaGrowth& growth, double age_days);

/// Logistic passage from 0 to 1 about `middle_days`; a quarter of the way below and above lie
/// 2.2 `scale_days` apart [Verhulst].
double logistic(double days, double middle_days, double scale_days);

/// @throws std::invalid_argument naming the day and the limits, for a day that is not in [0, last].
void check_day(double day, double last_day, const char* what);

}  // namespace cousin
