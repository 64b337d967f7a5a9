"use strict";
// Gaussians that can be turned, blended nearest first, by the same rule on any machine. For looking: the canvas has
// its own grid, so the low pass of the model's photographs means nothing on it, and rays stop earlier than in training.
// Colours are those of all directions alike (the first coefficient of the spherical harmonics).
const kBlur_px2 = 0.3;           // added to each Gaussian's variances on the canvas, as 3DGS does in photographs
const kLeastAlpha = 1 / 255;     // below it nothing is blended
const kFullTransmittance = 0.004;  // what is behind so little light does not show

// Covariances xx, xy, xz, yy, yz, zz in units of the shape's extent.
function decodeCovariances(json, bytes, extent) {
  const codes = new Uint16Array(bytes(json.scales).buffer), turns = new Int8Array(bytes(json.rotations).buffer);
  const [low, high] = json.log_scale, count = codes.length / 3;
  const result = new Float32Array(6 * count);
  for (let i = 0; i < count; ++i) {
    let [w, x, y, z] = turns.subarray(4 * i, 4 * i + 4);
    const norm = Math.hypot(w, x, y, z) || 1;
    w /= norm; x /= norm; y /= norm; z /= norm;
    const axes = [[1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)],
                  [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
                  [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]];
    for (let k = 0; k < 3; ++k) {
      const size = Math.exp(low + (high - low) * codes[3 * i + k] / 65535) / extent, a = axes[k], s = size * size;
      result[6 * i] += s * a[0] * a[0];
      result[6 * i + 1] += s * a[0] * a[1];
      result[6 * i + 2] += s * a[0] * a[2];
      result[6 * i + 3] += s * a[1] * a[1];
      result[6 * i + 4] += s * a[1] * a[2];
      result[6 * i + 5] += s * a[2] * a[2];
    }
  }
  return result;
}

// Indices by depth, the largest value of `depth` first.
function nearestFirst(depth) {
  let low = Infinity, high = -Infinity;
  for (const d of depth) { low = Math.min(low, d); high = Math.max(high, d); }
  const bins = 65536, starts = new Uint32Array(bins + 1);
  const bin = d => Math.min(bins - 1, Math.floor((high - d) / ((high - low) || 1) * bins));
  for (const d of depth) ++starts[bin(d) + 1];
  for (let b = 0; b < bins; ++b) starts[b + 1] += starts[b];
  const order = new Uint32Array(depth.length);
  for (let i = 0; i < depth.length; ++i) order[starts[bin(depth[i])]++] = i;
  return order;
}

// Blends into `light` (three of each pixel) and `left`, the light that still passes.
function blendSplat(mean, variance, color, opacity, width, height, light, left) {
  const xx = variance[0] + kBlur_px2, xy = variance[1], yy = variance[2] + kBlur_px2;
  const determinant = xx * yy - xy * xy;
  if (!(determinant > 0) || opacity <= kLeastAlpha) return;
  const reach = 2 * Math.log(opacity / kLeastAlpha);  // squared, in deviations
  const rx = Math.sqrt(reach * xx), ry = Math.sqrt(reach * yy);
  const x0 = Math.max(0, Math.ceil(mean[0] - rx)), x1 = Math.min(width - 1, Math.floor(mean[0] + rx));
  const y0 = Math.max(0, Math.ceil(mean[1] - ry)), y1 = Math.min(height - 1, Math.floor(mean[1] + ry));
  const a = yy / determinant, b = -xy / determinant, c = xx / determinant;
  for (let y = y0; y <= y1; ++y) {
    const dy = y - mean[1];
    for (let x = x0; x <= x1; ++x) {
      const at = y * width + x, passes = left[at];
      if (passes < kFullTransmittance) continue;
      const dx = x - mean[0], distance = a * dx * dx + 2 * b * dx * dy + c * dy * dy;
      if (distance > reach) continue;
      const alpha = opacity * Math.exp(-0.5 * distance), share = alpha * passes;
      light[3 * at] += share * color[0];
      light[3 * at + 1] += share * color[1];
      light[3 * at + 2] += share * color[2];
      left[at] = passes - share;
    }
  }
}

function showSplats(element, shape) {
  const canvas = document.createElement("canvas");
  element.appendChild(canvas);
  const context = canvas.getContext("2d");
  const depth = new Float32Array(shape.count);
  const repaint = () => {
    const ratio = view.isTurning ? 0.5 : Math.min(1.5, window.devicePixelRatio || 1);
    const width = canvas.width = Math.round(element.clientWidth * ratio);
    const height = canvas.height = Math.round(element.clientHeight * ratio);
    const scale = 0.8 * view.zoom * Math.min(width, height);
    const ca = Math.cos(view.azimuth), sa = Math.sin(view.azimuth);
    const ce = Math.cos(view.elevation), se = Math.sin(view.elevation);
    const right = [-sa, ca, 0], down = [se * ca, se * sa, -ce], near = [ce * ca, ce * sa, se];
    const p = shape.positions, dot = (v, i) => v[0] * p[3 * i] + v[1] * p[3 * i + 1] + v[2] * p[3 * i + 2];
    for (let i = 0; i < shape.count; ++i) depth[i] = dot(near, i);
    const light = new Float32Array(3 * width * height), left = new Float32Array(width * height).fill(1);
    const form = (c, i, u, v) => c[6 * i] * u[0] * v[0] + c[6 * i + 1] * (u[0] * v[1] + u[1] * v[0]) +
        c[6 * i + 2] * (u[0] * v[2] + u[2] * v[0]) + c[6 * i + 3] * u[1] * v[1] +
        c[6 * i + 4] * (u[1] * v[2] + u[2] * v[1]) + c[6 * i + 5] * u[2] * v[2];
    for (const i of nearestFirst(depth)) {
      const k = shape.covariances, s = scale * scale;
      blendSplat([width / 2 + scale * dot(right, i), height / 2 + scale * dot(down, i)],
                 [s * form(k, i, right, right), s * form(k, i, right, down), s * form(k, i, down, down)],
                 shape.colors.subarray(3 * i, 3 * i + 3), shape.opacities[i] / 255, width, height, light, left);
    }
    const image = context.createImageData(width, height);
    for (let at = 0; at < left.length; ++at) {
      const shown = 1 - left[at];  // the page's own colour is behind
      for (let k = 0; k < 3; ++k) image.data[4 * at + k] = shown > 0 ? light[3 * at + k] / shown : 0;
      image.data[4 * at + 3] = 255 * shown;
    }
    context.putImageData(image, 0, 0);
  };
  const view = turnedBy(canvas, repaint);
  repaint();
  mustBeSeenOn(canvas, shape);
  element.dataset.viewOk = "canvas";
  return {repaint};
}
