/**
 * A face on a canvas (WebGL2): lit and coloured as the pictures and videos of `render/model`.
 *
 * Drawing is on demand: `setWeights` moves, `render` draws.
 */

import { openness } from "./ambient.js";
import { FaceShape } from "./face_shape.js";

const VERTEX = `#version 300 es
in vec3 point; in vec3 normal; in vec3 colour; in float open; in vec2 place;
uniform vec3 middle; uniform mat3 turn; uniform float distance, zoom;
out vec3 facing; out vec3 tint; out float reach; out vec2 spot;
void main() {
  vec3 seen = turn * (point - middle);
  float depth = distance - seen.z, near = distance / 20.0, far = distance * 6.0;
  gl_Position = vec4(seen.xy * zoom, ((far + near) * depth - 2.0 * far * near) / (far - near), depth);
  facing = turn * normal; tint = colour; reach = open; spot = place;
}`;

const FRAGMENT = `#version 300 es
precision highp float;
in vec3 facing; in vec3 tint; in float reach; in vec2 spot;
uniform vec4 ways[3]; uniform vec4 lamps[3]; uniform vec3 sky, ground;
uniform float gloss, sharpest, behind, cutoff; uniform bool lit, textured; uniform sampler2D image;
uniform float alpha, lift;
out vec4 pixel;
vec3 encoded(vec3 light) {
  light = clamp(light, 0.0, 1.0);
  return mix(12.92 * light, 1.055 * pow(light, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, light));
}
void main() {
  vec4 texel = textured ? texture(image, spot) : vec4(1.0);
  if (texel.a < cutoff) discard;
  vec3 n = normalize(gl_FrontFacing ? facing : -facing);
  vec3 light = ground + (sky - ground) * (n.y / 2.0 + 0.5);
  float shine = 0.0;
  for (int k = 0; k < 3; k++) {
    vec3 way = ways[k].xyz; float wrap = ways[k].w;
    light += lamps[k].rgb * max((dot(n, way) + wrap) / (1.0 + wrap), 0.0);
    float power = 2.0 + sharpest * gloss * gloss;
    shine += lamps[k].w * gloss * pow(max(dot(n, normalize(way + vec3(0.0, 0.0, 1.0))), 0.0), power);
  }
  float side = mix((gl_FrontFacing ? 1.0 : behind) * reach, 1.0, lift);
  vec3 seen = lit ? tint * texel.rgb * light * side + shine * side : tint * texel.rgb;
  pixel = vec4(encoded(seen), 1.0) * alpha;
}`;

const MAX_PITCH = 80;

/** How solid each kind of triangle is where the mouth is seen through the face, inmost first. */
const SOLID = [1, 0.4, 0.22];
/** Mean light, of 255, of materials inside the mouth, at most. */
const DIM = 128;
/** Share of shade that the inside of the mouth loses then. */
const LIFT = 0.75;

/**
 * Turn a camera about its target.
 * @param {number[][]} turn the model's axes in eye axes, as columns of a product from the right
 * @param {number} yaw degrees to the side
 * @param {number} pitch degrees upwards
 * @returns {Float32Array} nine numbers, column by column, for a vector on the right
 */
export function turned(turn, yaw, pitch) {
  const [a, b] = [yaw, pitch].map((one) => (one * Math.PI) / 180);
  const side = [[Math.cos(a), 0, -Math.sin(a)], [0, 1, 0], [Math.sin(a), 0, Math.cos(a)]];
  const up = [[1, 0, 0], [0, Math.cos(b), Math.sin(b)], [0, -Math.sin(b), Math.cos(b)]];
  const by = (/** @type {number[][]} */ p, /** @type {number[][]} */ q) =>
    p.map((row) => [0, 1, 2].map((k) => row[0] * q[0][k] + row[1] * q[1][k] + row[2] * q[2][k]));
  return Float32Array.from(by(by(turn, side), up).flat());
}

/**
 * Draw a face on a canvas.
 * @param {HTMLCanvasElement} canvas
 * @param {import("../payloads.js").Face} face
 * @returns {GlFace | null} null where the browser has no WebGL2
 */
export function createFace(canvas, face) {
  const gl = canvas.getContext("webgl2", { antialias: true, alpha: true, preserveDrawingBuffer: true });
  return gl ? new GlFace(canvas, gl, face) : null;
}

/** A face on a canvas; see `createFace`. */
export class GlFace {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {WebGL2RenderingContext} gl
   * @param {import("../payloads.js").Face} face
   */
  constructor(canvas, gl, face) {
    this.canvas = canvas;
    this.gl = gl;
    this.face = face;
    this.shape = new FaceShape(face);
    /** Light that reaches each point. @type {Uint8Array} */
    this.open = new Uint8Array(face.count).fill(255);
    /** Materials inside the mouth. @type {boolean[]} */
    this.dim = [];
    this.close = false;
    this.yaw = 0;
    this.pitch = 0;
    this.lost = false;
    this.stale = false;
    /** Triangles as they are drawn: material by material, and in each the inmost kind first. */
    this.order = Uint32Array.from(face.triangles);
    /** Kinds of the triangles while the mouth is seen through the face. @type {Uint8Array | null} */
    this.through = null;
    /** Number of triangles of each kind, by material. @type {number[][]} */
    this.counts = [];
    /** Kinds by which the triangles are in order. @type {Uint8Array | null} */
    this.sorted = null;
    this.program = linked(gl);
    /** @type {Map<string, WebGLUniformLocation | null>} */
    this.places = new Map();
    /** @type {Map<string, WebGLBuffer | null>} */
    this.buffers = new Map();
    /** @type {(WebGLTexture | null)[]} */
    this.images = [];
    canvas.addEventListener("webglcontextlost", (event) => { event.preventDefault(); this.lost = true; });
    canvas.addEventListener("webglcontextrestored", () => {
      this.lost = false;
      this.program = linked(gl);
      this.#build();
      this.render();
    });
    this.#build();
  }

  /**
   * Move the face.
   * @param {ArrayLike<number>} weights one for each channel of the model
   */
  setWeights(weights) {
    this.shape.move(weights);
    this.stale = true;
  }

  /**
   * Choose the view.
   * @param {{close?: boolean, yaw?: number, pitch?: number}} view degrees
   */
  setView({ close = this.close, yaw = this.yaw, pitch = this.pitch }) {
    this.close = close;
    this.yaw = yaw;
    this.pitch = Math.max(-MAX_PITCH, Math.min(MAX_PITCH, pitch));
  }

  /**
   * Shade what little light reaches, judged at the widest of some moments.
   * @param {ArrayLike<number>[]} moments weights
   */
  shade(moments) {
    const rest = Float32Array.from(this.shape.points);
    let widest = moments[0], most = -1;
    for (const weights of moments) {
      this.shape.move(weights);
      const far = this.shape.points.reduce((sum, one, n) => sum + Math.abs(one - rest[n]), 0);
      if (far > most) [widest, most] = [weights, far];
    }
    this.shape.move(widest);
    this.open = openness(this.shape);
    this.dim = this.face.materials.map(({ first, count }) => {
      const own = this.order.subarray(3 * first, 3 * (first + count));
      return own.reduce((sum, point) => sum + this.open[point], 0) < DIM * own.length;
    });
    this.#fill("open", this.open, 1, this.gl.UNSIGNED_BYTE, true);
    this.stale = true;
  }

  /**
   * See the inside of the mouth through the face.
   * @param {Uint8Array | null} kinds of the triangles, as from `innerKinds`; null for a solid face
   */
  seeThrough(kinds) {
    this.through = kinds;
    if (!kinds || this.sorted === kinds) return;
    const { face, gl } = this, { triangles } = face;
    this.sorted = kinds;
    this.counts = face.materials.map((one) => {
      const own = Array.from({ length: one.count }, (_, n) => one.first + n);
      const sorted = SOLID.map((_, kind) => own.filter((n) => kinds[n] === kind));
      sorted
        .flat()
        .forEach((from, n) => this.order.set(triangles.subarray(3 * from, 3 * from + 3), 3 * (one.first + n)));
      return sorted.map((some) => some.length);
    });
    gl.bufferSubData(gl.ELEMENT_ARRAY_BUFFER, 0, this.order);
  }

  /** Draw the face as it stands. */
  render() {
    const { gl, canvas, face } = this;
    if (this.lost) return;
    if (this.stale) {
      this.#update("point", this.shape.points);
      this.#update("normal", this.shape.normals);
      this.stale = false;
    }
    const camera = this.close ? face.close : face.camera;
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.uniform3fv(this.at("middle"), camera.middle);
    gl.uniformMatrix3fv(this.at("turn"), false, turned(camera.turn, this.yaw, this.pitch));
    gl.uniform1f(this.at("distance"), camera.distance);
    gl.uniform1f(this.at("zoom"), 1 / Math.tan((camera.field * Math.PI) / 360));
    if (this.through) SOLID.forEach((alpha, kind) => this.#drawKind(alpha, kind));
    else
      face.materials.forEach((one, /** @type {number} */ number) =>
        this.#draw(one, number, 0, one.count),
      );
  }

  /**
   * Draw a kind of triangles over those within; of each pixel the nearest alone.
   * @param {number} alpha
   * @param {number} kind
   */
  #drawKind(alpha, kind) {
    const { gl, face } = this;
    const all = () => face.materials.forEach((one, /** @type {number} */ number) => {
      const counts = this.counts[number];
      this.#draw(one, number, counts.slice(0, kind).reduce((a, b) => a + b, 0), counts[kind]);
    });
    gl.uniform1f(this.at("alpha"), alpha);
    gl.uniform1f(this.at("lift"), kind < SOLID.length - 1 ? LIFT : 0);
    if (alpha < 1) {
      gl.colorMask(false, false, false, false);
      all();
      gl.colorMask(true, true, true, true);
      gl.depthFunc(gl.LEQUAL);
      gl.enable(gl.BLEND);
      gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    }
    all();
    gl.disable(gl.BLEND);
    gl.depthFunc(gl.LESS);
    gl.uniform1f(this.at("alpha"), 1);
    gl.uniform1f(this.at("lift"), 0);
  }

  /**
   * @param {import("../payloads.js").FaceMaterial} material
   * @param {number} number
   * @param {number} first of its triangles
   * @param {number} count
   */
  #draw(material, number, first, count) {
    const { gl } = this;
    if (!count) return;
    (material.double ? gl.disable : gl.enable).call(gl, gl.CULL_FACE);
    gl.polygonOffset(Number(this.dim[number] ?? false), 0); // seen edge-on, they would show through skin
    gl.uniform1f(this.at("gloss"), material.gloss);
    gl.uniform1f(this.at("cutoff"), material.cutoff);
    gl.uniform1i(this.at("lit"), Number(material.lit));
    gl.uniform1i(this.at("textured"), Number(Boolean(this.images[number])));
    gl.bindTexture(gl.TEXTURE_2D, this.images[number] ?? null);
    gl.drawElements(gl.TRIANGLES, 3 * count, gl.UNSIGNED_INT, 12 * (material.first + first));
  }

  #build() {
    const { gl, face } = this;
    gl.useProgram(this.program);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.POLYGON_OFFSET_FILL);
    this.places.clear();
    this.buffers.clear();
    this.images = [];
    this.#fill("point", this.shape.points, 3, gl.FLOAT, false);
    this.#fill("normal", this.shape.normals, 3, gl.FLOAT, false);
    this.#fill("colour", rgb(face.colours), 3, gl.UNSIGNED_SHORT, true);
    this.#fill("open", this.open, 1, gl.UNSIGNED_BYTE, true);
    if (face.places) this.#fill("place", face.places, 2, gl.FLOAT, false);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, this.order, gl.DYNAMIC_DRAW);
    const { lamps, sky, ground, sharpest, behind } = face.light;
    gl.uniform4fv(this.at("ways"), lamps.flatMap((/** @type {number[]} */ one) => [...one.slice(0, 3), one[6]]));
    gl.uniform4fv(this.at("lamps"), lamps.flatMap((/** @type {number[]} */ one) => [...one.slice(3, 6), one[7]]));
    gl.uniform3fv(this.at("sky"), sky);
    gl.uniform3fv(this.at("ground"), ground);
    gl.uniform1f(this.at("sharpest"), sharpest);
    gl.uniform1f(this.at("behind"), behind);
    gl.uniform1f(this.at("alpha"), 1);
    this.stale = false;
    face.materials.forEach(
      (one, /** @type {number} */ number) => one.image && this.#texture(one.image, number),
    );
  }

  /** @param {Uint8Array<ArrayBuffer>} content @param {number} number of the material */
  async #texture(content, number) {
    const { gl } = this;
    let image;
    try {
      image = await createImageBitmap(new Blob([content]), { premultiplyAlpha: "none", colorSpaceConversion: "none" });
    } catch {
      return; // the colour of the material stays
    }
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.SRGB8_ALPHA8, gl.RGBA, gl.UNSIGNED_BYTE, image);
    gl.generateMipmap(gl.TEXTURE_2D);
    this.images[number] = texture;
    this.render();
  }

  /** @param {string} name @returns {WebGLUniformLocation | null} */
  at(name) {
    if (!this.places.has(name)) this.places.set(name, this.gl.getUniformLocation(this.program, name));
    return this.places.get(name) ?? null;
  }

  /**
   * @param {string} name
   * @param {ArrayBufferView} values
   * @param {number} width
   * @param {number} type
   * @param {boolean} whole
   */
  #fill(name, values, width, type, whole) {
    const { gl } = this;
    const place = gl.getAttribLocation(this.program, name);
    if (place < 0) return;
    this.buffers.set(name, gl.createBuffer());
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers.get(name) ?? null);
    gl.bufferData(gl.ARRAY_BUFFER, values, gl.DYNAMIC_DRAW);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, width, type, whole, 0, 0);
  }

  /** @param {string} name @param {Float32Array} values */
  #update(name, values) {
    this.gl.bindBuffer(this.gl.ARRAY_BUFFER, this.buffers.get(name) ?? null);
    this.gl.bufferSubData(this.gl.ARRAY_BUFFER, 0, values);
  }
}

/** @param {WebGL2RenderingContext} gl @returns {WebGLProgram} */
function linked(gl) {
  const program = gl.createProgram();
  for (const [kind, source] of /** @type {[number, string][]} */ ([
    [gl.VERTEX_SHADER, VERTEX],
    [gl.FRAGMENT_SHADER, FRAGMENT],
  ])) {
    const shader = /** @type {WebGLShader} */ (gl.createShader(kind));
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
    throw new Error(`the face's shaders do not link: ${gl.getProgramInfoLog(program)}`);
  }
  return program;
}

/** @param {Uint16Array} colours with alpha @returns {Uint16Array} without, padded to rows of 3 */
function rgb(colours) {
  return colours.filter((_, n) => n % 4 !== 3);
}
