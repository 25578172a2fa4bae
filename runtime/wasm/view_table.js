// Makes a remap table for a view, as formats/SPEC.md has it, and adds it to a blob. Blocks are
// straight and of 8 x 8 pixels; `raygrid pack` makes smaller tables whose error it measures.
const BLOCK_LOG2 = 3, BLOCK = 8;
const Q12 = 2 ** 12, Q16 = 2 ** 16, Q30 = 2 ** 30;
const MAX_SIZE = 8192;
const FARTHEST_PX = 8000;  // of a vertex; the format allows 8192
const HEADER = 32, ENTRY = 16, FIELDS = 124;
const CAMERA = 1, CENTRAL_GRID = 2, REMAP = 3, STACK = 12, MAX_SECTIONS = 16;
const MINOR_OF_VIEWS = 5;

// ---- Directions -------------------------------------------------------------

// What a place (a, b) of a view looks along, in its own axes; null where it shows nothing.
const DIRECTIONS = [
  (a, b) => [a, b, 1],
  (a, b) => (Math.abs(a) > Math.PI ? null : [Math.sin(a), b, Math.cos(a)]),
  (a, b) => (Math.abs(a) > Math.PI || Math.abs(b) > Math.PI / 2 ? null
    : [Math.sin(a) * Math.cos(b), Math.sin(b), Math.cos(a) * Math.cos(b)]),
  (a, b) => [a, b, 1 - (a * a + b * b) / 4],
  (a, b) => {
    const r = Math.hypot(a, b);
    if (r > Math.PI) return null;
    return r === 0 ? [0, 0, 1] : [a * Math.sin(r) / r, b * Math.sin(r) / r, Math.cos(r)];
  },
];

const turn = (rotation, ray) => rotation.map((row) =>
  row[0] * ray[0] + row[1] * ray[1] + row[2] * ray[2]);

// The direction, in camera axes, of a view's pixel (u, v).
export function directionOf(view, projection, u, v) {
  const ray = DIRECTIONS[projection]((u - view.cx) / view.fx, (v - view.cy) / view.fy);
  return ray && turn(view.rotation, ray);
}

// ---- Vertices ---------------------------------------------------------------

const DIRECTIONS_ON_GRID = [[1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [1, -1], [-1, 1], [-1, -1]];

// A grid of positions in the source; null where the camera sees nothing.
class Vertices {
  constructor(columns, rows, places) {
    this.columns = columns;
    this.rows = rows;
    this.places = places;
  }

  at(i, j) {
    return i < 0 || j < 0 || i >= this.columns || j >= this.rows ? null
      : this.places[j * this.columns + i];
  }

  // On along a parabola through three neighbours in a line: the mean of such lines; or straight on
  // from two, where there are not three.
  extrapolated(i, j) {
    const lines = [2, 1].map((degree) => DIRECTIONS_ON_GRID.flatMap(([di, dj]) => {
      const [a, b, c] = [1, 2, 3].map((k) => this.at(i + k * di, j + k * dj));
      if (!a || !b || (degree === 2 && !c)) return [];
      return [a.map((v, axis) => (degree === 2 ? 3 * (v - b[axis]) + c[axis] : 2 * v - b[axis]))];
    })).find((places) => places.length > 0);
    if (!lines) return null;
    const place = [0, 1].map((axis) =>
      lines.reduce((sum, line) => sum + line[axis], 0) / lines.length);
    return place.every((v) => Math.abs(v) < FARTHEST_PX) ? place : null;
  }

  // Blocks at the edge of what is seen get their outer corners.
  withEdge() {
    const places = this.places.map((place, k) =>
      place || this.extrapolated(k % this.columns, Math.floor(k / this.columns)));
    return new Vertices(this.columns, this.rows, places);
  }

  corners(i, j) {
    return [this.at(i, j), this.at(i + 1, j), this.at(i, j + 1), this.at(i + 1, j + 1)];
  }
}

const findVertices = (view, projection, project) => {
  const columns = Math.ceil(view.width / BLOCK) + 1, rows = Math.ceil(view.height / BLOCK) + 1;
  const rays = [];
  for (let j = 0; j < rows; ++j)
    for (let i = 0; i < columns; ++i)
      rays.push(directionOf(view, projection, BLOCK * i, BLOCK * j) || [0, 0, 0]);
  return new Vertices(columns, rows, project(rays));
};

// 1 for blocks without a source: no corner is seen, or one is not known.
const findEmptyBlocks = (seen, vertices) => {
  const empty = [];
  for (let j = 0; j + 1 < vertices.rows; ++j)
    for (let i = 0; i + 1 < vertices.columns; ++i)
      empty.push(!seen.corners(i, j).some(Boolean) || !vertices.corners(i, j).every(Boolean));
  return empty;
};

// ---- A plane ----------------------------------------------------------------

// Least squares of one coordinate: constant + column i + row j.
const fitPlane = (vertices, axis) => {
  const sums = Array.from({length: 3}, () => [0, 0, 0, 0]);
  vertices.places.forEach((place, k) => {
    if (!place) return;
    const terms = [1, k % vertices.columns, Math.floor(k / vertices.columns)];
    terms.forEach((a, r) => {
      terms.forEach((b, c) => { sums[r][c] += a * b; });
      sums[r][3] += a * place[axis];
    });
  });
  return solve(sums);
};

// Gaussian elimination; unknowns that nothing determines are 0.
const solve = (rows) => {
  for (let k = 0; k < 3; ++k) {
    const best = [0, 1, 2].slice(k).reduce((a, b) =>
      (Math.abs(rows[b][k]) > Math.abs(rows[a][k]) ? b : a));
    [rows[k], rows[best]] = [rows[best], rows[k]];
    for (let r = k + 1; r < 3; ++r) {
      const factor = Math.abs(rows[k][k]) > 1e-9 ? rows[r][k] / rows[k][k] : 0;
      for (let c = k; c < 4; ++c) rows[r][c] -= factor * rows[k][c];
    }
  }
  const unknowns = [0, 0, 0];
  for (let k = 2; k >= 0; --k) {
    let rest = rows[k][3];
    for (let c = k + 1; c < 3; ++c) rest -= rows[k][c] * unknowns[c];
    unknowns[k] = Math.abs(rows[k][k]) > 1e-9 ? rest / rows[k][k] : 0;
  }
  return unknowns;
};

// Plane in q12, and what vertices have beyond it, shifted to fit 16 bits.
const quantize = (vertices) => {
  const planes = [0, 1].map((axis) => fitPlane(vertices, axis).map((v) => Math.round(v * Q12)));
  const beyond = vertices.places.map((place, k) => planes.map((plane, axis) => (place === null ? 0
    : Math.round(place[axis] * Q12) - plane[0] - plane[1] * (k % vertices.columns) -
      plane[2] * Math.floor(k / vertices.columns))));
  const largest = beyond.reduce((most, pair) => Math.max(most, ...pair.map(Math.abs)), 0);
  let shift = 0;
  while (largest / 2 ** shift > 32767) ++shift;
  return {planes, shift, residuals: beyond.map((pair) => pair.map((v) => Math.round(v / 2 ** shift)))};
};

// ---- Bytes ------------------------------------------------------------------

const clampTo = (value, most) => Math.max(0, Math.min(most, value));

// The calibrated area within the pixels of the source, in q12.
const sourceRectangle = (blob, grid, width, height) => {
  const area = [0, 4, 8, 12].map((at) => blob.getInt32(grid + at, true) / 16);
  return [clampTo(Math.ceil(area[0]), (width - 1) * Q12), clampTo(Math.ceil(area[1]), (height - 1) * Q12),
    clampTo(Math.floor(area[2]), (width - 1) * Q12), clampTo(Math.floor(area[3]), (height - 1) * Q12)];
};

const sectionBytes = (view, projection, source, rectangle, vertices, empty) => {
  const {planes, shift, residuals} = quantize(vertices);
  const maskAt = FIELDS + 4 * residuals.length;
  const bytes = new Uint8Array(maskAt + Math.ceil(empty.length / 32) * 4);
  const out = new DataView(bytes.buffer);
  const setWords = (at, values) =>
    values.forEach((value, k) => out.setInt32(at + 4 * k, value, true));
  const setHalves = (at, values) =>
    values.forEach((value, k) => out.setUint16(at + 2 * k, value, true));
  setHalves(0, [view.width, view.height, vertices.columns, vertices.rows]);
  bytes.set([BLOCK_LOG2, shift, 0, 128], 8);
  setWords(12, rectangle);
  [0, 1, 2].forEach((k) => setWords(28 + 8 * k, [planes[0][k], planes[1][k]]));
  setWords(52, [view.fx, view.fy, view.cx, view.cy].map((v) => Math.round(v * Q16)));
  setWords(76, [FIELDS]);
  bytes.set([projection, 0, 0, 0], 80);
  setWords(84, view.rotation.flat().map((v) => Math.round(v * Q30)));
  setHalves(120, source);
  residuals.forEach((pair, k) => setHalves(FIELDS + 4 * k, pair));
  empty.forEach((flag, k) => { if (flag) bytes[maskAt + (k >> 3)] |= 1 << (k & 7); });
  return bytes;
};

// The blob with one more section, the last one.
const withSection = (bytes, section, crc32) => {
  const old = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const count = old.getUint16(16, true), total = old.getUint32(12, true);
  if (count >= MAX_SECTIONS) throw new RangeError(`the blob has ${count} sections, the maximum`);
  const tableEnd = HEADER + ENTRY * count;
  const made = new Uint8Array(total + ENTRY + section.length);
  const out = new DataView(made.buffer);
  made.set(bytes.subarray(0, tableEnd));
  made.set(bytes.subarray(tableEnd, total), tableEnd + ENTRY);
  made.set(section, total + ENTRY);
  for (let k = 0; k < count; ++k) {
    const at = HEADER + ENTRY * k + 4;
    out.setUint32(at, out.getUint32(at, true) + ENTRY, true);
  }
  out.setUint16(tableEnd, REMAP, true);
  [total + ENTRY, section.length, crc32(section)].forEach((value, k) =>
    out.setUint32(tableEnd + 4 + 4 * k, value, true));
  out.setUint16(10, Math.max(MINOR_OF_VIEWS, out.getUint16(10, true)), true);
  out.setUint32(12, made.length, true);
  out.setUint16(16, count + 1, true);
  const checked = new Uint8Array([...made.subarray(0, 28), ...made.subarray(HEADER, tableEnd + ENTRY)]);
  out.setUint32(28, crc32(checked), true);
  return made;
};

// Where a section begins; undefined where there is none.
const findSection = (blob, type) => {
  const end = HEADER + ENTRY * blob.getUint16(16, true);
  for (let at = HEADER; at !== end; at += ENTRY)
    if (blob.getUint16(at, true) === type) return blob.getUint32(at + 4, true);
  return undefined;
};

const requireView = (view, projection) => {
  if (projection < 0) throw new TypeError(`unknown projection of a view: '${view.projection}'`);
  for (const name of ['width', 'height'])
    if (!Number.isInteger(view[name]) || view[name] < 1 || view[name] > MAX_SIZE)
      throw new RangeError(`a view's ${name} must be 1 to ${MAX_SIZE}, not ${view[name]}`);
  for (const name of ['fx', 'fy'])
    if (!(view[name] >= 1 / Q16 && view[name] < 65536))
      throw new RangeError(`a view's ${name} must be above 0 and below 65536, not ${view[name]}`);
  for (const name of ['cx', 'cy'])
    if (!(Math.abs(view[name]) < 32768))
      throw new RangeError(`a view's ${name} must be within 32767 px, not ${view[name]}`);
  requireRotation(view.rotation);
};

// No mirror image, and no shear.
const requireRotation = (m) => {
  const products = [0, 1, 2].flatMap((r) => [0, 1, 2].map((c) =>
    m[r][0] * m[c][0] + m[r][1] * m[c][1] + m[r][2] * m[c][2] - (r === c ? 1 : 0)));
  const third = m[0][0] * m[1][1] - m[0][1] * m[1][0];
  if (!products.every((v) => Math.abs(v) < 1e-7) || !(Math.abs(third - m[2][2]) < 1e-7))
    throw new RangeError("a view's rotation must be a 3 x 3 rotation matrix");
};

// The blob with a table for a view; project() gives pixels of directions.
export function addTable(bytes, view, projection, {project, crc32}) {
  requireView(view, projection);
  const blob = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  if (findSection(blob, STACK) !== undefined)
    throw new RangeError('tables cannot be added to a blob with a range of operating points; ' +
      'pack one operating point with raygrid pack --at');
  const cameraAt = findSection(blob, CAMERA);
  const source = [blob.getUint16(cameraAt, true), blob.getUint16(cameraAt + 2, true)];
  if (source.some((size) => size < 2 || size > MAX_SIZE))
    throw new RangeError(`frames must have 2 to ${MAX_SIZE} px per side, not ${source.join(' x ')}`);
  const seen = findVertices(view, projection, project);
  const vertices = seen.withEdge();
  const empty = findEmptyBlocks(seen, vertices);
  const rectangle = sourceRectangle(blob, findSection(blob, CENTRAL_GRID), ...source);
  return withSection(bytes, sectionBytes(view, projection, source, rectangle, vertices, empty), crc32);
}
