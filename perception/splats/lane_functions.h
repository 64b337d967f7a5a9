#pragma once

namespace cousin {

/// 2^x for x in [-126, 127], to 3e-6 relative, any number elsewhere: the blending kernels' own,
/// where 1/255 is the unit.
template <class L>
inline L exp2_blending(const L& x) {
  const L whole = round_nearest(x);
  const L f = x - whole;
  L p = multiply_add(L(0.00957010201), f, L(0.0559178603));
  p = multiply_add(p, f, L(0.240247448));
  p = multiply_add(p, f, L(0.693121815));
  p = multiply_add(p, f, L(0.999999261));
  return times_power_unchecked(p, whole);
}

/// e^x to 2e-7 relative; x is clamped to [-87, 88].
template <class L>
inline L exponential(const L& x) {
  const L bounded = smaller(larger(x, L(-87)), L(88));
  const L whole = round_nearest(bounded * L(1.44269504088896));
  // ln 2 in two parts: the remainder keeps its digits.
  L f = multiply_subtract(whole, L(0.693145751953125), bounded);
  f = multiply_subtract(whole, L(1.42860682030942e-6), f) * L(1.44269504088896);
  L p = multiply_add(L(0.000153458122), f, L(0.00133999312));
  p = multiply_add(p, f, L(0.00961848896));
  p = multiply_add(p, f, L(0.0555032878));
  p = multiply_add(p, f, L(0.240226469));
  p = multiply_add(p, f, L(0.693147206));
  p = multiply_add(p, f, L(1));
  return times_power_of_two(p, whole);
}

/// log2 of x > 0 (not subnormal), to 3e-7 absolute near 1 and relative elsewhere.
template <class L>
inline L logarithm2(const L& x) {
  L mantissa, exponent;
  split_exponent(x, mantissa, exponent);
  const L f = mantissa - L(1);
  L p = multiply_add(L(-0.149733278), f, L(0.235709636));
  p = multiply_add(p, f, L(-0.248322808));
  p = multiply_add(p, f, L(0.286868877));
  p = multiply_add(p, f, L(-0.360263462));
  p = multiply_add(p, f, L(0.480931162));
  p = multiply_add(p, f, L(-0.721352487));
  p = multiply_add(p, f, L(1.44269492));
  return multiply_add(p, f, exponent);
}

/// 1 / (1 + e^-x)
template <class L>
inline L sigmoid_of(const L& x) {
  return L(1) / (L(1) + exponential(-x));
}

}  // namespace cousin
