// The npm package with the golden blobs: node wasm_package_test.mjs GOLDEN_BLOBS_H PACKAGE_FOLDER
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {pathToFileURL} from 'node:url';
import {crc32 as zlibCrc} from 'node:zlib';
import test from 'node:test';

const [header, folder] = process.argv.slice(2);
const {Camera, FORMATS, PROJECTIONS, RaygridError, load, makeView, viewDirection} =
  await import(pathToFileURL(`${folder}/raygrid.js`));
const golden = readFileSync(header, 'utf8');

// ---- Golden values ----------------------------------------------------------

const numbersOf = (name) => {
  const body = golden.match(new RegExp(`\\b${name}\\[[^=]*= \\{([\\s\\S]*?)\\};`))[1];
  return body.match(/-?0x[0-9a-f]+|-?\d+|INT32_MIN/g)
    .map((word) => (word === 'INT32_MIN' ? -(2 ** 31) : Number(word)));
};
const blobOf = (name) => Uint8Array.from(numbersOf(name));
const rows = (values, count) =>
  Array.from({length: values.length / count}, (_, k) => values.slice(count * k, count * k + count));

const crcTable = Uint32Array.from({length: 256}, (_, k) => {
  for (let bit = 0; bit < 8; ++bit) k = k & 1 ? 0xedb88320 ^ (k >>> 1) : k >>> 1;
  return k;
});
const crc32 = zlibCrc || ((bytes) => {
  let crc = 0xffffffff;
  for (const byte of bytes) crc = crcTable[(crc ^ byte) & 255] ^ (crc >>> 8);
  return (crc ^ 0xffffffff) >>> 0;
});

let state = 0;
const random = () => (state = (Math.imul(state, 1664525) + 1013904223) >>> 0);
const testPlane = (width, height) => {
  state = 2025;
  const bytes = new Uint8Array(width * height);
  for (let k = 0; k < bytes.length; ++k)
    bytes[k] = 2 * (k % width) + Math.floor(k / width) + (random() >>> 27);
  return bytes;
};
const testFrame = (format, [width, height]) => {
  const planes = FORMATS[format][2].map(([across, down]) =>
    testPlane(width * across, height * down));
  return new Uint8Array(Buffer.concat(planes));
};
const isClose = (values, expected, delta) => values.length === expected.length &&
  values.every((value, k) => Math.abs(value - expected[k]) <= delta);

// A blob's bytes changed, with CRCs that say nothing of it.
const damaged = (blob) => {
  const bytes = blob.slice(), view = new DataView(bytes.buffer);
  for (let k = random() % 4; k >= 0; --k)
    bytes[32 + (random() >>> 8) % (bytes.length - 32)] = random() >>> 24;
  const count = Math.min(16, view.getUint16(16, true)), end = 32 + 16 * count;
  for (let at = 32; at < end; at += 16) {
    const start = view.getUint32(at + 4, true), size = view.getUint32(at + 8, true);
    if (start + size <= bytes.length)
      view.setUint32(at + 12, crc32(bytes.subarray(start, start + size)), true);
  }
  view.setUint32(28, crc32(Uint8Array.from([...bytes.subarray(0, 28), ...bytes.subarray(32, end)])),
    true);
  return bytes;
};

// ---- Tests ------------------------------------------------------------------

test('a camera wants the runtime loaded', async () => {
  assert.throws(() => new Camera(blobOf('kWideBlob')), /await load/);
  await load();
  await load();
});

test('frames have the CRCs of all targets', () => {
  const border = [['value', 'bilinear'], ['clamp', 'bilinear'], ['keep', 'nearest']];
  for (const [blob, table, crcs] of [['kWideBlob', 0, 'kFormatCrcs'],
    ['kBentBlob', 0, 'kBentFormatCrcs'], ['kBentBlob', 1, 'kMoreBentFormatCrcs']]) {
    const camera = new Camera(blobOf(blob));
    camera.selectTable(table);
    const expected = rows(numbersOf(crcs), 3);
    Object.keys(FORMATS).forEach((format, f) => {
      const frame = testFrame(format, camera.frameSize);
      const made = camera.undistort(frame, null, {format}).length;
      border.forEach(([word, sampling], k) => {
        const out = new Uint8Array(made).fill(0xa5);
        const same = camera.undistort(frame, out,
          {format, border: word, sampling, borderValues: [201, 17, 130, 66]});
        assert.equal(same, out);
        assert.equal(crc32(out), expected[f][k], `${blob} ${format} ${word}`);
      });
    });
  }
  const lens = new Camera(blobOf('kLensBlob'));
  const crc = crc32(lens.undistort(testFrame('GREY8', [160, 120]), null, {borderValues: [201]}));
  console.log(`remap CRC ${crc.toString(16)}`);
  assert.ok(golden.includes(`GOLDEN_LENS_REMAP_CRC 0x${crc.toString(16).padStart(8, '0')}u`));
});

test('tables of views and of modes have theirs', () => {
  for (const [blob, crcs] of [['kViewsBlob', 'kViewsCrcs'], ['kModesBlob', 'kModesCrcs']]) {
    const camera = new Camera(blobOf(blob));
    const expected = numbersOf(crcs);
    assert.equal(camera.numTables, expected.length);
    expected.forEach((crc, index) => {
      camera.selectTable(index);
      assert.equal(camera.table, index);
      assert.deepEqual(camera.view, camera.tables[index].view);
      const frame = testFrame('GREY8', camera.frameSize);
      assert.equal(crc32(camera.undistort(frame, null, {borderValues: [201]})), crc,
        `${blob} ${index}`);
      const {result, table} = camera.match({...camera.mode, mode: camera.mode});
      if (!camera.view.distorts) assert.equal(table, camera.tables.findIndex(
        (other) => !other.view.distorts && isClose(other.frameSize, camera.frameSize, 0)
          && isClose([...other.mode.offset], camera.mode.offset, 0)));
      assert.ok(['exact', 'mode'].includes(result));
    });
  }
  const camera = new Camera(blobOf('kExampleBlob'));
  assert.deepEqual(camera.match({width: 64, height: 48, serial: '0001'}),
    {result: 'exact', table: 0});
  assert.equal(camera.match({width: 64, height: 48, serial: '0002'}).result, 'none');
  assert.deepEqual(camera.match({width: 100, height: 100}), {result: 'none', table: null});
});

test('frames at a condition have theirs', () => {
  const camera = new Camera(blobOf('kStackBlob'));
  const frame = testFrame('GREY8', camera.frameSize);
  const conditions = rows(numbersOf('kStackCrcs'), 1 + camera.numTables);
  assert.equal(conditions.length, 9);
  const values = conditions.map(([value]) => value | 0);
  const inside = [1, 7];  // the first and the last value of the range
  conditions.forEach(([, ...crcs], n) => {
    const isInside = n >= inside[0] && n <= inside[1];
    assert.equal(camera.setCondition(values[n] / 65536), isInside, `${values[n]}`);
    crcs.forEach((crc, index) => {
      camera.selectTable(index);
      assert.equal(crc32(camera.undistort(frame, null, {borderValues: [201]})), crc,
        `${values[n]} ${index}`);
    });
  });
  assert.equal(camera.setCondition(Infinity), false);
  for (const none of [NaN, undefined, null, '5'])
    assert.throws(() => camera.setCondition(none), TypeError);
  assert.throws(() => camera.useView(makeView({width: 64, height: 48, hfov: 1})), /--at/);
  assert.throws(() => new Camera(blobOf('kWideBlob')).setCondition(1), {status: -63});
});

test('points have the golden rays and pixels', () => {
  const lens = new Camera(blobOf('kLensBlob'));
  for (const [x, y, ...ray] of rows(numbersOf('kLensRays'), 5)) {
    const [found] = lens.unproject([[x / 65536, y / 65536]]);
    assert.ok(isClose(found, ray.map((v) => v / 2 ** 30), 1e-7));
  }
  const wide = new Camera(blobOf('kWideBlob'));
  for (const [x, y, ...ray] of rows(numbersOf('kWideProjections'), 5)) {
    const [found] = wide.project([ray]);
    if (x === -(2 ** 31)) assert.equal(found, null);
    else assert.ok(isClose(found, [x / 65536, y / 65536], 0.002));
  }
  const places = rows(numbersOf('kLensUndistorted'), 2);
  lens.undistortPoints(rows(numbersOf('kLensRays'), 5).map(([x, y]) => [x / 65536, y / 65536]))
    .forEach((found, k) => {
      if (places[k][0] === -(2 ** 31)) assert.equal(found, null);
      else assert.ok(isClose(found, places[k].map((v) => v / 65536), 0.003));
    });
  assert.deepEqual(lens.unproject([[-1, 0], [NaN, 3], [1e9, -Infinity]]), [null, null, null]);
  assert.deepEqual(lens.isValid([[-1, 0], [80, 60]]), [false, true]);
  assert.deepEqual(lens.uncertainty([[80, 60]]), [null]);
});

test('lines have the golden points', () => {
  const lines = new Camera(blobOf('kLinesBlob'));
  assert.equal(lines.isCentral, false);
  for (const [x, y, ...point] of rows(numbersOf('kLinePoints'), 5)) {
    const [line] = lines.unprojectLines([[x / 65536, y / 65536]]);
    assert.ok(isClose(line.point, point.map((v) => v / 2 ** 28), 7e-8));
  }
  assert.throws(() => lines.project([[0, 0, 1]]), {name: 'RaygridError', status: -60});
  const seen = new Camera(blobOf('kSeenLinesBlob'));
  for (const [x, y, ...point] of rows(numbersOf('kSeenPoints'), 5)) {
    const [found] = seen.project([point.map((v) => v / 2 ** 24)]);
    if (x === -(2 ** 31)) assert.equal(found, null);
    else assert.ok(isClose(found, [x / 65536, y / 65536], 0.002));
  }
  assert.deepEqual(seen.project([[0, 0, 0], [NaN, 0, 1], [0, 0, -1]]), [null, null, null]);
});

// Sources of all pixels of the view in use, by frames that say x and y of their pixels: 16 bits,
// 64 a pixel. Nothing where there is border.
const sourcesOf = (camera) => {
  const {width, height} = camera;
  const read = (value) => {
    const ramp = Uint16Array.from({length: width * height}, (_, k) => 64 * value(k));
    return new Uint16Array(camera.undistort(ramp, null,
      {format: 'GREY16', borderValues: [65535]}).buffer);
  };
  const xs = read((k) => k % width), ys = read((k) => Math.floor(k / width));
  return [...xs].map((x, k) => (x === 65535 ? null : [x / 64, ys[k] / 64]));
};

test('a table made for a view has the exact sources, up to the edge', () => {
  const [width, height] = [320, 240];
  for (const [name, angles] of [['kWideBlob', [1.6, 4, 4, 4, 4]],
    ['kSeenLinesBlob', [0.9, 0.9]]]) {
    const camera = new Camera(blobOf(name)), tables = camera.numTables;
    angles.forEach((hfov, p) => {
      const projection = PROJECTIONS[p], view = makeView({projection, width, height, hfov});
      camera.useView(view);
      assert.equal(camera.numTables, tables + 1);
      assert.deepEqual(camera.size, [width, height]);
      const pixels = Array.from({length: width * height}, (_, k) => [k % width, Math.floor(k / width)]);
      const rays = pixels.map((pixel) => viewDirection(view, pixel) || [0, 0, 0]);
      const exact = camera.project(rays.map((ray) => ray.map((v) => 1e5 * v)));
      const found = sourcesOf(camera);
      const differs = (k) => !exact[k] !== !found[k];
      const atEdge = (k) => [1, -1, width, -width, width + 1, width - 1, 1 - width, -1 - width]
        .some((step) => !exact[k + step] !== !exact[k]);
      const all = [...pixels.keys()];
      const seen = all.filter((k) => exact[k] && found[k]);
      const error = (k) => Math.max(...exact[k].map((v, axis) => Math.abs(v - found[k][axis])));
      // What a frame shows ends half a pixel before the area does.
      const inner = (k) => exact[k].every((v, axis) =>
        v > 0.1 && v < [camera.width, camera.height][axis] - 1.1);
      const errors = Float64Array.from(seen.filter(inner).map(error)).sort();
      const [median, largest] = [0.5, 1].map((part) => errors[Math.floor(part * (errors.length - 1))]);
      const wrong = all.filter((k) => differs(k) && !atEdge(k) && (!exact[k] || inner(k)));
      console.log(`${name} ${projection}: ${seen.length} pixels, ${median.toFixed(3)}, ${largest.toFixed(3)} px`);
      assert.ok(seen.length > 10000);
      assert.equal(wrong.length, 0);
      assert.ok(median < 1 / 16);
      assert.ok(largest < 1 / 2);
    });
    assert.deepEqual(new Camera(camera.blob).blob, camera.blob);
  }
});

test('what is wrong is refused with a text', () => {
  const camera = new Camera(blobOf('kWideBlob')), frame = testFrame('GREY8', [320, 240]);
  assert.throws(() => new Camera(Uint8Array.of(1, 2, 3)), RaygridError);
  assert.throws(() => new Camera('camera.raygrid'), TypeError);
  const blob = blobOf('kWideBlob');
  blob[blob.length - 1] ^= 1;
  assert.throws(() => new Camera(blob), {status: -17, message: /section/});
  assert.throws(() => camera.selectTable(2), {status: -51});
  assert.throws(() => camera.undistort(frame.subarray(1)), /76800 bytes in GREY8, not 76799/);
  assert.throws(() => camera.undistort(frame, new Uint8Array(3)), /undistorted frame/);
  for (const options of [{format: 'GREY9'}, {border: 'none'}, {sampling: 'cubic'}])
    assert.throws(() => camera.undistort(frame, null, options), /expected one of/);
  for (const borderValues of [[-1], [256], [1, 2, 3, 4, 5], [1.5]])
    assert.throws(() => camera.undistort(frame, null, {borderValues}), RangeError);
  for (const wrong of [{width: 0}, {height: 9000}, {fx: 0}, {cx: NaN}, {projection: 'fish'}])
    assert.throws(() => camera.useView({...makeView({width: 64, height: 48, hfov: 1}), ...wrong}));
  const mirrored = {...makeView({width: 64, height: 48, hfov: 1}),
    rotation: [[1, 0, 0], [0, 1, 0], [0, 0, -1]]};
  assert.throws(() => camera.useView(mirrored), /rotation/);
  assert.equal(camera.undistort(frame).length, 48 * 36);  // as before
  assert.throws(() => makeView({width: 64, height: 48, hfov: Math.PI}), RangeError);
  assert.throws(() => new Camera(blobOf('kLensBlob')).useView(makeView({width: 9, height: 9, hfov: 1})),
    {status: -60});
});

test('hostile blobs give errors only', () => {
  state = 7;
  let opened = 0;
  const isRefusal = (error) => error instanceof RaygridError || error instanceof RangeError;
  const attempt = (call) => {
    try {
      return call();
    } catch (error) {
      if (!isRefusal(error)) throw error;
      return null;
    }
  };
  const blobs = ['kWideBlob', 'kBentBlob', 'kViewsBlob', 'kModesBlob', 'kSeenLinesBlob',
    'kLensBlob'].map(blobOf);
  const view = makeView({width: 40, height: 30, hfov: 1});
  for (let k = 0; k < 800; ++k) {
    const camera = attempt(() => new Camera(damaged(blobs[k % blobs.length])));
    if (!camera) continue;
    ++opened;
    camera.unproject([[20, 20], [100, 90]]);
    attempt(() => camera.project([[0, 0.1, 1], [1, 0, 0.1]]));
    attempt(() => camera.undistortPoints([[20, 20]]));
    attempt(() => camera.uncertainty([[20, 20]]));
    camera.isValid([[20, 20]]);
    for (let index = 0; index < camera.numTables; ++index) attempt(() => {
      camera.selectTable(index);
      const [width, height] = camera.frameSize;
      if (width * height < 1e6) camera.undistort(new Uint8Array(width * height));
    });
    if (k % 10 === 0) attempt(() => camera.useView(view));
  }
  console.log(`${opened} of 800 damaged blobs are opened`);
  assert.ok(opened > 100);
});
test('10,000 frames leave no memory behind', () => {
  const camera = new Camera(blobOf('kWideBlob'));
  const frame = testFrame('GREY8', [320, 240]), out = new Uint8Array(48 * 36);
  const use = () => {
    const before = process.memoryUsage();
    return before.arrayBuffers + before.external;
  };
  camera.undistort(frame, out);
  const before = use();
  for (let k = 0; k < 10000; ++k) camera.undistort(frame, out);
  assert.ok(use() - before < 1e6);
  const blob = camera.blob;
  for (let k = 0; k < 1000; ++k) new Camera(blob);  // each goes by itself
});
