"use strict";
// A cloud or mesh that can be turned: three.js where it and WebGL are there, else painted on a plain canvas.
// Positions are 16-bit shares of the bounding box; z is up.
function decodeShape(element) {
  const shape = JSON.parse(document.getElementById(element.dataset.shape).textContent);
  const bytes = text => Uint8Array.from(atob(text), c => c.charCodeAt(0));
  const codes = new Uint16Array(bytes(shape.positions).buffer);
  const count = codes.length / 3;
  const positions = new Float32Array(codes.length);
  const extent = Math.max(...shape.size, 1e-9);
  for (let i = 0; i < count; ++i) {
    for (let k = 0; k < 3; ++k) positions[3 * i + k] = (codes[3 * i + k] / 65535 - 0.5) * shape.size[k] / extent;
  }
  const triangles = shape.triangles ? new Uint32Array(bytes(shape.triangles).buffer) : null;
  return {count, positions, triangles, colors: shape.colors ? bytes(shape.colors) : null, extent,
          covariances: shape.scales ? decodeCovariances(shape, bytes, extent) : null,
          opacities: shape.opacities ? bytes(shape.opacities) : null};
}

// Where a canvas is looked at from, as the mouse turns it.
function turnedBy(canvas, repaint) {
  const view = {azimuth: -0.95, elevation: 0.55, zoom: 1, isTurning: false};
  canvas.addEventListener("pointerdown", event => canvas.setPointerCapture(event.pointerId));
  canvas.addEventListener("pointermove", event => {
    if (!event.buttons) return;
    view.isTurning = true;
    view.azimuth -= 0.01 * event.movementX;
    view.elevation = Math.max(-1.55, Math.min(1.55, view.elevation + 0.01 * event.movementY));
    repaint();
  });
  canvas.addEventListener("pointerup", () => {
    view.isTurning = false;
    repaint();
  });
  canvas.addEventListener("wheel", event => {
    event.preventDefault();
    view.zoom = Math.max(0.2, Math.min(20, view.zoom * Math.exp(-0.001 * event.deltaY)));
    repaint();
  });
  window.addEventListener("resize", repaint);
  return view;
}

// Throws where a shape of something left every pixel as it was. @param pixels  red, green, blue, alpha
function mustBeSeen(shape, pixels) {
  if (shape.count === 0 || pixels.length === 0) return;
  for (let i = 3; i < pixels.length; i += 4) if (pixels[i] > 0) return;
  throw new Error("the view of " + shape.count + " places is empty");
}

function mustBeSeenOn(canvas, shape) {
  const {width, height} = canvas;
  if (width > 0 && height > 0) mustBeSeen(shape, canvas.getContext("2d").getImageData(0, 0, width, height).data);
}

function showWithThree(element, shape) {
  const renderer = new THREE.WebGLRenderer({antialias: true, alpha: true, preserveDrawingBuffer: true});
  renderer.setPixelRatio(window.devicePixelRatio || 1);
  element.appendChild(renderer.domElement);
  const scene = new THREE.Scene();
  const camera = new THREE.PerspectiveCamera(35, 1, 0.01, 20);
  camera.up.set(0, 0, 1);
  camera.position.set(0.9, -1.3, 1.0);
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(shape.positions, 3));
  if (shape.colors) geometry.setAttribute("color", new THREE.BufferAttribute(shape.colors, 3, true));
  const colors = shape.colors ? {vertexColors: THREE.VertexColors} : {color: 0x5a93c4};
  if (shape.triangles) {
    geometry.setIndex(new THREE.BufferAttribute(shape.triangles, 1));
    geometry.computeVertexNormals();
    scene.add(new THREE.Mesh(geometry, new THREE.MeshLambertMaterial({side: THREE.DoubleSide, ...colors})));
    scene.add(new THREE.HemisphereLight(0xffffff, 0x777777, 0.75));
    const lamp = new THREE.DirectionalLight(0xffffff, 0.5);
    lamp.position.set(1, -2, 3);
    scene.add(lamp);
  } else {
    // Points about as large as their spacing, if they lay on a surface.
    const size = Math.min(0.02, Math.max(0.003, 0.9 / Math.sqrt(shape.count)));
    scene.add(new THREE.Points(geometry, new THREE.PointsMaterial({size, ...colors})));
  }
  const controls = new THREE.OrbitControls(camera, renderer.domElement);
  controls.screenSpacePanning = true;
  const repaint = () => {
    const width = element.clientWidth, height = element.clientHeight;
    renderer.setSize(width, height, false);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    renderer.render(scene, camera);
  };
  controls.addEventListener("change", repaint);
  window.addEventListener("resize", repaint);
  repaint();
  const gl = renderer.getContext();
  if (gl.isContextLost()) throw new Error("the WebGL context is lost");
  const pixels = new Uint8Array(4 * gl.drawingBufferWidth * gl.drawingBufferHeight);
  gl.readPixels(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  mustBeSeen(shape, pixels);
  element.dataset.viewOk = "webgl";
  return {repaint};
}

function showOnCanvas(element, shape) {
  const canvas = document.createElement("canvas");
  element.appendChild(canvas);
  const context = canvas.getContext("2d");
  const screen = new Float32Array(3 * shape.count);
  const repaint = () => {
    const ratio = window.devicePixelRatio || 1;
    const width = canvas.width = Math.round(element.clientWidth * ratio);
    const height = canvas.height = Math.round(element.clientHeight * ratio);
    const scale = 0.8 * view.zoom * Math.min(width, height);
    const ca = Math.cos(view.azimuth), sa = Math.sin(view.azimuth), ce = Math.cos(view.elevation), se = Math.sin(view.elevation);
    for (let i = 0; i < shape.count; ++i) {
      const x = shape.positions[3 * i], y = shape.positions[3 * i + 1], z = shape.positions[3 * i + 2];
      const right = -sa * x + ca * y, towards = ca * x + sa * y;
      screen[3 * i] = width / 2 + scale * right;
      screen[3 * i + 1] = height / 2 - scale * (ce * z - se * towards);
      screen[3 * i + 2] = ce * towards + se * z;  // larger is nearer
    }
    const paint = (i, shade) => {
      const c = shape.colors, base = c ? [c[3 * i], c[3 * i + 1], c[3 * i + 2]] : [90, 147, 196];
      return "rgb(" + base.map(v => Math.round(v * shade)).join(",") + ")";
    };
    context.clearRect(0, 0, width, height);
    if (shape.triangles) {
      const t = shape.triangles, faces = t.length / 3;
      const depth = f => screen[3 * t[3 * f] + 2] + screen[3 * t[3 * f + 1] + 2] + screen[3 * t[3 * f + 2] + 2];
      const order = Array.from({length: faces}, (_, f) => f).sort((a, b) => depth(a) - depth(b));
      for (const f of order) {
        const [a, b, c] = [3 * t[3 * f], 3 * t[3 * f + 1], 3 * t[3 * f + 2]];
        const ux = screen[b] - screen[a], uy = screen[b + 1] - screen[a + 1], uz = scale * (screen[b + 2] - screen[a + 2]);
        const vx = screen[c] - screen[a], vy = screen[c + 1] - screen[a + 1], vz = scale * (screen[c + 2] - screen[a + 2]);
        const nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
        const shade = 0.35 + 0.65 * Math.abs(nz) / (Math.hypot(nx, ny, nz) || 1);
        context.fillStyle = context.strokeStyle = paint(t[3 * f], shade);
        context.beginPath();
        context.moveTo(screen[a], screen[a + 1]);
        context.lineTo(screen[b], screen[b + 1]);
        context.lineTo(screen[c], screen[c + 1]);
        context.fill();
        context.stroke();
      }
    } else {
      const order = Array.from({length: shape.count}, (_, i) => i).sort((a, b) => screen[3 * a + 2] - screen[3 * b + 2]);
      const size = Math.max(1, 0.5 * scale / Math.sqrt(shape.count));
      for (const i of order) {
        context.fillStyle = paint(i, 1);
        context.fillRect(screen[3 * i] - size / 2, screen[3 * i + 1] - size / 2, size, size);
      }
    }
  };
  const view = turnedBy(canvas, repaint);
  repaint();
  mustBeSeenOn(canvas, shape);
  element.dataset.viewOk = "canvas";
  return {repaint};
}

// Whether WebGL works is asked on a canvas of its own: three.js would print errors.
function webglWorks() {
  if (typeof THREE === "undefined" || !THREE.OrbitControls) return false;
  const context = document.createElement("canvas").getContext("webgl");
  if (!context) return false;
  const lose = context.getExtension("WEBGL_lose_context");
  if (lose) lose.loseContext();
  return true;
}

function showShape(element) {
  const shape = decodeShape(element);
  if (shape.covariances) return showSplats(element, shape);
  if (webglWorks()) {
    try {
      return showWithThree(element, shape);
    } catch (error) {
      console.warn("WebGL failed, painting on a canvas instead: " + error.message);
      for (const canvas of element.querySelectorAll("canvas")) canvas.remove();
    }
  }
  return showOnCanvas(element, shape);
}
