// raygrid's runtime in browsers and Node: a blob, pixels to rays and back, undistorted frames.
//
//   import {load, Camera} from '@raygrid/runtime';
//   await load();
//   const camera = new Camera(bytesOfABlob);
//   const [direction] = camera.unproject([[320, 240]]);
//
// All arithmetic is the runtime's own, compiled to WebAssembly. Types are in raygrid.d.ts.
import {WASM} from './raygrid_wasm.js';
import {addTable, directionOf} from './view_table.js';

const NO_PIXEL = -(2 ** 31);
const Q12 = 2 ** 12, Q16 = 2 ** 16, Q28 = 2 ** 28, Q30 = 2 ** 30;
const POINT_MAX_BITS = 27;
const PAGE = 65536;
const NO_REMAP = -51, EXTRAPOLATED = -64;
const FAR_M = 1e5;  // of a view of lines

// Each format's number, bits of a sample, then bytes a row of each plane takes, as a fraction of
// the width, and rows of each plane, as a fraction of the height.
export const FORMATS = {
  GREY8: [0, 8, [[1, 1]]],
  GREY16: [1, 16, [[2, 1]]],
  GREY10P: [2, 10, [[1.25, 1]]],
  GREY12P: [3, 12, [[1.5, 1]]],
  RGB24: [4, 8, [[3, 1]]],
  RGB32: [5, 8, [[4, 1]]],
  YUYV: [6, 8, [[2, 1]]],
  UYVY: [7, 8, [[2, 1]]],
  NV12: [8, 8, [[1, 1], [1, 0.5]]],
  YUV420: [9, 8, [[1, 1], [0.5, 0.5], [0.5, 0.5]]],
  BAYER8: [10, 8, [[1, 1]]],
  BAYER16: [11, 16, [[2, 1]]],
  BAYER10P: [12, 10, [[1.25, 1]]],
  BAYER12P: [13, 12, [[1.5, 1]]],
  RGB565: [14, 16, [[2, 1]]],
};
export const PROJECTIONS = ['pinhole', 'cylindrical', 'equirectangular', 'stereographic',
  'equidistant'];
const BORDERS = {value: 0, clamp: 1, keep: 2};
const SAMPLINGS = {bilinear: 0, nearest: 1};
const MATCHES = ['exact', 'mode', 'derivable', 'none'];

// A refusal by the runtime; status is its number.
export class RaygridError extends Error {
  constructor(status, text) {
    super(text);
    this.name = 'RaygridError';
    this.status = status;
  }
}

let compiled = null;

// Compiles the runtime, once; cameras can be made afterwards.
export async function load() {
  if (!compiled) {
    const text = atob(WASM);
    compiled = await WebAssembly.compile(Uint8Array.from(text, (c) => c.charCodeAt(0)));
  }
}

// ---- Numbers ----------------------------------------------------------------

// Too distant positions, and what is no number, become one that is in no camera's area.
const fixed = (value) => {
  const scaled = Number(value) * Q16;
  return Number.isNaN(scaled) ? 1 - 2 ** 31
    : Math.round(Math.max(1 - 2 ** 31, Math.min(2 ** 31 - 1, scaled)));
};

const isFinitePoint = (point) => point.every(Number.isFinite);

// Q30, of a length that the runtime takes; zeros, which no pixel sees, where a coordinate is not
// finite.
const direction = (point) => {
  const largest = Math.max(...point.map(Math.abs));
  if (!isFinitePoint(point) || largest === 0) return [0, 0, 0];
  return point.map((v) => Math.round(v / largest * Q30));
};

// Fixed point below 2^30, and its fraction bits.
const inMetres = (point) => {
  if (!isFinitePoint(point)) return [0, 0, 0, 0];
  const largest = Math.max(...point.map(Math.abs));
  const bits = Math.min(29 - Math.floor(Math.log2(largest || 1)), POINT_MAX_BITS);
  if (bits < 0) return inMetres(point.map((v) => v / largest * 2 ** 29));  // far away
  return [...point.map((v) => Math.max(1 - Q30, Math.min(Q30 - 1, Math.round(v * 2 ** bits)))),
    bits];
};

const frameSize = (planes, width, height) =>
  planes.reduce((sum, [across, down]) =>
    sum + Math.floor(width * across) * Math.floor(height * down), 0);

const named = (name, values) => {
  if (!Object.hasOwn(values, name))
    throw new TypeError(`'${name}': expected one of ${Object.keys(values).join(', ')}`);
  return values[name];
};

const requireSize = (name, value) => {
  if (!Number.isInteger(value) || value < 0 || value > 65535)
    throw new RangeError(`${name} must be an integer up to 65535, not ${value}`);
};

const bytesOf = (data, name) => {
  if (ArrayBuffer.isView(data)) return new Uint8Array(data.buffer, data.byteOffset, data.byteLength);
  if (data instanceof ArrayBuffer) return new Uint8Array(data);
  throw new TypeError(`${name} must be a Uint8Array or another array of bytes`);
};

// A view with square pixels around the middle of the image; hfov is in radians.
export function makeView({projection = 'pinhole', width, height, hfov}) {
  const half = hfov / 2;
  const reach = {pinhole: Math.tan(half), cylindrical: half, equirectangular: half,
    stereographic: 2 * Math.tan(half / 2), equidistant: half};
  const focal = width / 2 / named(projection, reach);
  const limit = projection === 'pinhole' ? Math.PI : 2 * Math.PI;
  if (!(hfov > 0 && hfov < limit) || !(focal > 0))
    throw new RangeError(`hfov of a ${projection} view must be above 0 and below ${limit} radians`);
  return {projection, width, height, fx: focal, fy: focal, cx: (width - 1) / 2,
    cy: (height - 1) / 2, rotation: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]};
}

// The direction, in camera axes, that a pixel of a view looks along; of any length.
export function viewDirection(view, [x, y]) {
  return directionOf(view, PROJECTIONS.indexOf(view.projection), x, y);
}

// ---- Memory -----------------------------------------------------------------

// The memory of one instance: the blob, then what a call needs. It grows, and goes with its camera.
class Memory {
  constructor() {
    if (!compiled) throw new Error('the runtime is not loaded; await load() first');
    this.calls = new WebAssembly.Instance(compiled).exports;
    this.blobStart = Math.ceil(this.calls.free_memory() / 16) * 16;
    this.free = this.blobStart;
  }

  // Room for each of these numbers of bytes, at multiples of 16.
  take(...sizes) {
    let end = this.free;
    const places = sizes.map((size) => {
      const place = end;
      end += Math.ceil(size / 16) * 16;
      return place;
    });
    const {memory} = this.calls, missing = end - memory.buffer.byteLength;
    if (missing > 0) {
      try {
        memory.grow(Math.ceil(missing / PAGE));
      } catch {
        throw new RangeError(`${end} bytes exceed the memory of a WebAssembly module`);
      }
    }
    return places;
  }

  bytes(place, size) { return new Uint8Array(this.calls.memory.buffer, place, size); }
  words(place, size) { return new Int32Array(this.calls.memory.buffer, place, size); }

  check(status) {
    if (status === 0) return;
    const start = this.calls.status_text(status);
    const bytes = new Uint8Array(this.calls.memory.buffer, start);
    throw new RaygridError(status, String.fromCharCode(...bytes.subarray(0, bytes.indexOf(0))));
  }
}

// ---- Camera -----------------------------------------------------------------

const positions = (words) => {
  const found = [];
  for (let k = 0; k < words.length; k += 2)
    found.push(words[k] === NO_PIXEL ? null : [words[k] / Q16, words[k + 1] / Q16]);
  return found;
};

// A blob, of which a copy is kept. Its first remap table is in use, if it has any.
export class Camera {
  #memory;
  #packed;       // the blob as it was given
  #blobSize = 0;
  #table = -1;   // the index of the table in use
  #tables = [];
  #sizes = [];   // of calibrated frames, the table's frames, undistorted ones

  constructor(blob) {
    this.#packed = bytesOf(blob, 'a blob').slice();
    this.#open(this.#packed);
    this.#listTables();
    if (this.numTables > 0) this.selectTable(0);
  }

  #open(bytes) {
    const memory = new Memory();
    const [place] = memory.take(bytes.length);
    memory.bytes(place, bytes.length).set(bytes);
    memory.check(memory.calls.open(place, bytes.length));
    memory.free = place + Math.ceil(bytes.length / 16) * 16;
    this.#memory = memory;
    this.#blobSize = bytes.length;
    this.#table = -1;
    this.#readSizes();
  }

  #readSizes() {
    const [place] = this.#memory.take(24);
    this.#memory.calls.sizes(place);
    this.#sizes = [...this.#memory.words(place, 6)];
  }

  // Every table's size, view and mode; of a faulty one the error.
  #listTables() {
    this.#tables = [];
    for (let index = 0; ; ++index) {
      const status = this.#memory.calls.select_remap(index);
      if (status === NO_REMAP) break;
      try {
        this.#memory.check(status);
        this.#readSizes();
        this.#tables.push({frameSize: this.frameSize, view: this.view, mode: this.mode});
      } catch (error) {
        this.#tables.push({error});
      }
    }
  }

  get width() { return this.#sizes[0]; }
  get height() { return this.#sizes[1]; }
  get isCentral() { return this.#memory.calls.is_central() !== 0; }
  get canProject() { return this.#memory.calls.can_project() !== 0; }

  // The bytes of the blob, with the table of useView().
  get blob() { return this.#memory.bytes(this.#memory.blobStart, this.#blobSize).slice(); }

  // ---- Points ----

  // Pixels in the module, and room for words of an answer beside each.
  #pixels(points, words) {
    const [from, to] = this.#memory.take(8 * points.length, 4 * words * points.length);
    const values = this.#memory.words(from, 2 * points.length);
    points.forEach(([x, y], k) => {
      values[2 * k] = fixed(x);
      values[2 * k + 1] = fixed(y);
    });
    return [from, to, points.length];
  }

  unproject(points) {
    if (!this.isCentral) return this.unprojectLines(points).map((line) => line && line.direction);
    const [from, to, count] = this.#pixels(points, 3);
    this.#memory.calls.unproject(from, to, count);
    const rays = this.#memory.words(to, 3 * count);
    return points.map((_, k) => {
      const ray = [rays[3 * k] / Q30, rays[3 * k + 1] / Q30, rays[3 * k + 2] / Q30];
      return ray.some((v) => v !== 0) ? ray : null;
    });
  }

  unprojectLines(points) {
    const [from, to, count] = this.#pixels(points, 6);
    this.#memory.calls.unproject_lines(from, to, count);
    const lines = this.#memory.words(to, 6 * count);
    return points.map((_, k) => {
      const line = [...lines.subarray(6 * k, 6 * k + 6)];
      if (line.slice(3).every((v) => v === 0)) return null;
      return {point: line.slice(0, 3).map((v) => v / Q28),
        direction: line.slice(3).map((v) => v / Q30)};
    });
  }

  project(points) {
    if (!this.canProject) this.#memory.check(-60);
    const words = this.isCentral ? 3 : 4;
    const [from, to] = this.#memory.take(4 * words * points.length, 8 * points.length);
    const values = this.#memory.words(from, words * points.length);
    points.forEach((point, k) => {
      const numbers = [...point].map(Number);
      values.set(this.isCentral ? direction(numbers) : inMetres(numbers), words * k);
    });
    const {project, project_points: projectPoints} = this.#memory.calls;
    (this.isCentral ? project : projectPoints)(from, to, points.length);
    return positions(this.#memory.words(to, 2 * points.length));
  }

  isValid(points) {
    const [from, to, count] = this.#pixels(points, 1);
    this.#memory.calls.is_valid(from, to, count);
    return [...this.#memory.words(to, count)].map((v) => v !== 0);
  }

  uncertainty(points) {
    const [from, to, count] = this.#pixels(points, 1);
    this.#memory.check(this.#memory.calls.uncertainty(from, to, count));
    return [...this.#memory.words(to, count)].map((v) => (v < 0 ? null : v / Q12));
  }

  undistortPoints(points) {
    this.#requireTable();
    const [from, to, count] = this.#pixels(points, 2);
    this.#memory.calls.undistort_points(from, to, count);
    return positions(this.#memory.words(to, 2 * count));
  }

  // ---- Tables ----

  get numTables() { return this.#tables.length; }
  get tables() { return this.#tables.slice(); }
  get table() { return this.#table; }

  selectTable(index) {
    if (!Number.isInteger(index) || index < 0 || index >= this.numTables) this.#memory.check(NO_REMAP);
    this.#memory.check(this.#memory.calls.select_remap(index));
    this.#table = index;
    this.#readSizes();
  }

  // Makes the camera that of a lens position in dioptres, or of a temperature in degrees Celsius, as
  // the blob's stack has it; from then on, with all of the blob's tables. False: the value lies
  // outside the stack's range, and the camera is that of the nearest end.
  setCondition(value) {
    if (typeof value !== 'number' || Number.isNaN(value))
      throw new TypeError(`the operating point must be a number, not ${value}`);
    const q16 = Math.round(Math.max(-32767, Math.min(value, 32767)) * Q16);
    const status = this.#memory.calls.set_condition(q16);
    if (status !== EXTRAPOLATED) this.#memory.check(status);
    return status !== EXTRAPOLATED;
  }

  #requireTable() {
    if (this.#table < 0) this.#memory.check(NO_REMAP);
  }

  get frameSize() { return this.#sizes.slice(2, 4); }

  get size() {
    this.#requireTable();
    return this.#sizes.slice(4, 6);
  }

  get view() {
    const [place] = this.#memory.take(60);
    this.#memory.check(this.#memory.calls.view(place));
    const [projection, fx, fy, cx, cy, distorts, ...rotation] = this.#memory.words(place, 15);
    const numbers = rotation.map((v) => v / Q30), sizes = this.#sizes;
    // The source of a table that distorts is the view.
    const [width, height] = distorts ? sizes.slice(2, 4) : sizes.slice(4, 6);
    return {projection: PROJECTIONS[projection], width, height, fx: (fx >>> 0) / Q16,
      fy: (fy >>> 0) / Q16, cx: cx / Q16, cy: cy / Q16,
      rotation: [numbers.slice(0, 3), numbers.slice(3, 6), numbers.slice(6, 9)],
      distorts: distorts !== 0};
  }

  get mode() {
    const [place] = this.#memory.take(32);
    this.#memory.check(this.#memory.calls.mode(place));
    const [width, height, x, y, scaleX, scaleY, flipX, flipY] = this.#memory.words(place, 8);
    return {width, height, offset: [x / Q16, y / Q16],
      scale: [(scaleX >>> 0) / Q16, (scaleY >>> 0) / Q16], flips: [flipX !== 0, flipY !== 0]};
  }

  match({width, height, mode = null, serial = null}) {
    requireSize('width', width);
    requireSize('height', height);
    const text = serial === null ? [] : [...new TextEncoder().encode(serial), 0];
    const [modePlace, textPlace, tablePlace] = this.#memory.take(32, text.length, 4);
    this.#memory.bytes(textPlace, text.length).set(text);
    if (mode) {
      requireSize('mode.width', mode.width);
      requireSize('mode.height', mode.height);
      this.#memory.words(modePlace, 8).set([mode.width, mode.height,
        ...[...mode.offset, ...mode.scale].map((v) => Math.round(v * Q16)),
        ...mode.flips.map(Number)]);
    }
    const result = this.#memory.calls.match(mode ? modePlace : 0, width, height,
      serial === null ? 0 : textPlace, tablePlace);
    const [table] = this.#memory.words(tablePlace, 1);
    return {result: MATCHES[result], table: table < 0 ? null : table};
  }

  useView(view) {
    const bytes = addTable(this.#packed, view, PROJECTIONS.indexOf(view.projection), {
      project: (rays) => this.project(
        this.isCentral ? rays : rays.map((ray) => ray.map((v) => v * FAR_M))),
      crc32: (data) => {
        const [place] = this.#memory.take(data.length);
        this.#memory.bytes(place, data.length).set(data);
        return this.#memory.calls.crc32(place, data.length) >>> 0;
      }});
    this.#open(bytes);
    this.#listTables();
    this.selectTable(this.numTables - 1);
  }

  // ---- Frames ----

  undistort(frame, out = null, {format = 'GREY8', border = 'value', borderValues = [],
    sampling = 'bilinear'} = {}) {
    const [number, bits, planes] = named(format, FORMATS);
    const borderNumber = named(border, BORDERS), samplingNumber = named(sampling, SAMPLINGS);
    if (borderValues.length > 4 ||
        !borderValues.every((v) => Number.isInteger(v) && v >= 0 && v < 2 ** bits))
      throw new RangeError(`border values must be up to 4 integers below ${2 ** bits}`);
    const size = this.size, source = bytesOf(frame, 'a frame');
    const needed = frameSize(planes, ...this.frameSize), made = frameSize(planes, ...size);
    if (source.length !== needed)
      throw new RangeError(`a frame of ${this.frameSize.join(' x ')} has ${needed} bytes in ` +
        `${format}, not ${source.length}`);
    if (out && bytesOf(out, 'out').length !== made)
      throw new RangeError(`an undistorted frame of ${size.join(' x ')} has ${made} bytes in ` +
        `${format}, not ${out.byteLength}`);
    const [from, to, list, values] = this.#memory.take(source.length, made, 48, 16);
    this.#memory.bytes(from, source.length).set(source);
    if (border === 'keep') this.#memory.bytes(to, made).set(out ? bytesOf(out) : new Uint8Array(made));
    this.#memory.words(list, 12).set(this.#planePairs(planes, size, from, to));
    this.#memory.words(values, 4).set([...borderValues, 0, 0, 0, 0].slice(0, 4));
    this.#memory.check(
      this.#memory.calls.undistort(number, list, borderNumber, samplingNumber, values));
    const result = out || new Uint8Array(made);
    bytesOf(result).set(this.#memory.bytes(to, made));
    return result;
  }

  // Address and stride of each plane of a frame and of the undistorted one.
  #planePairs(planes, size, from, to) {
    const pairs = [], frame = this.frameSize;
    for (const [across, down] of planes) {
      const strides = [Math.floor(frame[0] * across), Math.floor(size[0] * across)];
      pairs.push(from, strides[0], to, strides[1]);
      from += strides[0] * Math.floor(frame[1] * down);
      to += strides[1] * Math.floor(size[1] * down);
    }
    return pairs;
  }
}
