#include <cmath>

#include "perception/splats/photometric_band_body.h"

namespace cousin::photometric {
namespace {

/// Eight floats, as the compiler likes to keep them.
struct Plain {
  float v[kLanes];

  struct Sum {
    double parts[kLanes] = {};
  };
  template <class Of>
  static Plain each(const Of& of) {
    Plain result;
    for (int i = 0; i < kLanes; ++i) result.v[i] = of(i);
    return result;
  }
  static Plain load(const float* at) {
    return each([&](int i) { return at[i]; });
  }
  static void store(float* at, const Plain& a) {
    for (int i = 0; i < kLanes; ++i) at[i] = a.v[i];
  }
  static Plain load_first(const float* at, int count) {
    return each([&](int i) { return i < count ? at[i] : 0.0f; });
  }
  static void store_first(float* at, int count, const Plain& a) {
    for (int i = 0; i < count; ++i) at[i] = a.v[i];
  }
  static Plain first_ones(int count) {
    return each([&](int i) { return i < count ? 1.0f : 0.0f; });
  }
  static Plain zero() { return all(0); }
  static Plain all(float a) {
    return each([&](int) { return a; });
  }
  static Plain add(const Plain& a, const Plain& b) {
    return each([&](int i) { return a.v[i] + b.v[i]; });
  }
  static Plain sub(const Plain& a, const Plain& b) {
    return each([&](int i) { return a.v[i] - b.v[i]; });
  }
  static Plain mul(const Plain& a, const Plain& b) {
    return each([&](int i) { return a.v[i] * b.v[i]; });
  }
  static Plain div(const Plain& a, const Plain& b) {
    return each([&](int i) { return a.v[i] / b.v[i]; });
  }
  static Plain fma(const Plain& a, const Plain& b, const Plain& c) {
    return each([&](int i) { return a.v[i] * b.v[i] + c.v[i]; });
  }
  static Plain magnitude(const Plain& a) {
    return each([&](int i) { return std::abs(a.v[i]); });
  }
  /// -1, 0 or 1; 0 for NaN.
  static Plain sign(const Plain& a) {
    return each([&](int i) { return static_cast<float>((a.v[i] > 0) - (a.v[i] < 0)); });
  }
  static Plain keep_where_positive(const Plain& where, const Plain& a) {
    return each([&](int i) { return where.v[i] > 0 ? a.v[i] : 0.0f; });
  }
  static void sum_to(Sum& sum, const Plain& a) {
    for (int i = 0; i < kLanes; ++i) sum.parts[i] += static_cast<double>(a.v[i]);
  }
  static double total(const Sum& sum) {
    double total = 0;
    for (const double part : sum.parts) total += part;
    return total;
  }
};

}  // namespace

void loss_band_portable(const Band& band) { BandRows<Plain>(band).run(); }

}  // namespace cousin::photometric
