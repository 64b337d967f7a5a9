#pragma once

namespace cousin {

/// Real spherical harmonics of degree 0..3 as 3DGS orders and signs them, for a unit direction.
/// @param T  a scalar, or lanes of floats: needs + - * and a constructor from double
/// @param degree  0..3; (degree + 1)^2 values are written
template <class T>
inline void sh_basis(int degree, const T& x, const T& y, const T& z, T* basis) {
  basis[0] = T(0.28209479177387814);
  if (degree < 1) return;
  const T c1(0.4886025119029199);
  basis[1] = T(0) - c1 * y;
  basis[2] = c1 * z;
  basis[3] = T(0) - c1 * x;
  if (degree < 2) return;
  const T xx = x * x, yy = y * y, zz = z * z;
  const T xy = x * y, yz = y * z, xz = x * z;
  basis[4] = T(1.0925484305920792) * xy;
  basis[5] = T(-1.0925484305920792) * yz;
  basis[6] = T(0.31539156525252005) * (zz + zz - xx - yy);
  basis[7] = T(-1.0925484305920792) * xz;
  basis[8] = T(0.5462742152960396) * (xx - yy);
  if (degree < 3) return;
  const T xx3 = T(3) * xx, yy3 = T(3) * yy, zz4 = T(4) * zz;
  basis[9] = T(-0.5900435899266435) * y * (xx3 - yy);
  basis[10] = T(2.890611442640554) * xy * z;
  basis[11] = T(-0.4570457994644658) * y * (zz4 - xx - yy);
  basis[12] = T(0.3731763325901154) * z * (zz + zz - xx3 - yy3);
  basis[13] = T(-0.4570457994644658) * x * (zz4 - xx - yy);
  basis[14] = T(1.445305721320277) * z * (xx - yy);
  basis[15] = T(-0.5900435899266435) * x * (xx - yy3);
}

/// Adds sum over k of weight[k] * d basis[k] / d(x, y, z) to `gradient`, where x, y, z count as
/// independent; `weight` has (degree + 1)^2 values.
template <class T>
inline void add_sh_direction_gradient(int degree, const T& x, const T& y, const T& z,
                                      const T* weight, T* gradient) {
  if (degree < 1) return;
  T gx = T(-0.4886025119029199) * weight[3];
  T gy = T(-0.4886025119029199) * weight[1];
  T gz = T(0.4886025119029199) * weight[2];
  if (degree >= 2) {
    const T c(1.0925484305920792), c6(0.31539156525252005);
    const T w4 = c * weight[4], w5 = c * weight[5], w7 = c * weight[7], w8 = c * weight[8];
    const T w6 = c6 * weight[6];
    gx = gx + w4 * y - w7 * z + w8 * x - T(2) * w6 * x;
    gy = gy + w4 * x - w5 * z - w8 * y - T(2) * w6 * y;
    gz = gz - w5 * y - w7 * x + T(4) * w6 * z;
  }
  if (degree >= 3) {
    const T xx = x * x, yy = y * y, zz = z * z;
    const T xy = x * y, yz = y * z, xz = x * z;
    const T w9 = T(-0.5900435899266435) * weight[9], w10 = T(2.890611442640554) * weight[10];
    const T w11 = T(-0.4570457994644658) * weight[11], w12 = T(0.3731763325901154) * weight[12];
    const T w13 = T(-0.4570457994644658) * weight[13], w14 = T(1.445305721320277) * weight[14];
    const T w15 = T(-0.5900435899266435) * weight[15];
    const T six(6), two(2), three(3), four(4), eight(8);
    gx = gx + w9 * six * xy + w10 * yz - w11 * two * xy - w12 * six * xz +
         w13 * (four * zz - three * xx - yy) + w14 * two * xz + w15 * three * (xx - yy);
    gy = gy + w9 * three * (xx - yy) + w10 * xz + w11 * (four * zz - xx - three * yy) -
         w12 * six * yz - w13 * two * xy - w14 * two * yz - w15 * six * xy;
    gz = gz + w10 * xy + w11 * eight * yz + w12 * three * (two * zz - xx - yy) + w13 * eight * xz +
         w14 * (xx - yy);
  }
  gradient[0] = gradient[0] + gx;
  gradient[1] = gradient[1] + gy;
  gradient[2] = gradient[2] + gz;
}

}  // namespace cousin
