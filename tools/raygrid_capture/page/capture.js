// The page of a live capture: shows each state that the program sends, and sends buttons.
const byId = (id) => document.getElementById(id);
const root = document.documentElement;
const make = (name, properties = {}) => Object.assign(document.createElement(name), properties);
const setText = (node, text) => { if (node.textContent !== text) node.textContent = text; };

// ---- Words on frames: a sign, words and a kind; colours follow from the kind ----
const WORDS = {
  kept: ['\u2713', 'Kept', 'good'],
  absent: ['\u25cb', 'No board', 'idle'],
  few: ['+', 'Too few features', 'bad'],
  moving: ['\u2194', 'Moving', 'bad'],
  blurred: ['\u2248', 'Blurred', 'bad'],
  dark: ['\u25bc', 'Too dark', 'bad'],
  bright: ['\u25b2', 'Too bright', 'bad'],
  known: ['=', 'Similar view already kept', 'idle'],
  busy: ['\u2026', 'Working', 'busy'],
  paused: ['\u2016', 'Paused', 'busy'],
  locking: ['\u2026', 'Locking focus and exposure', 'busy'],
  refocused: ['!', 'Focus has changed', 'bad'],
  cropped: ['!', 'Sensor crop has changed', 'bad'],
};
const KEPT_MS = 1500, WORD_MS = 350, SPEECH_MS = 3000, SILENCE_MS = 7000;

let state = null;
let wordShown = '', wordUntil = 0, wordTimer = 0;

function showWord() {
  const now = performance.now();
  clearTimeout(wordTimer);
  if (now < wordUntil) {
    wordTimer = setTimeout(showWord, wordUntil - now + 1);
    return;
  }
  const word = state.paused ? 'paused' : state.status;
  if (word !== wordShown) putWord(word, WORD_MS);
}

function putWord(word, ms) {
  const [sign, text, kind] = WORDS[word] || ['\u2022', word, 'idle'];
  wordShown = word;
  wordUntil = performance.now() + ms;
  setText(byId('sign'), sign);
  setText(byId('word-text'), text);
  byId('word').dataset.kind = kind;
}

// Screen readers announce the newest state at most once per SPEECH_MS. That a frame was kept is
// announced even if newer states arrive before its turn.
let spoken = '', spokenAt = -SPEECH_MS, speechTimer = 0, keptToSpeak = '';

function speak(text) {
  clearTimeout(speechTimer);
  if (text === spoken && !keptToSpeak) return;
  const wait = spokenAt + SPEECH_MS - performance.now();
  if (wait > 0) {
    speechTimer = setTimeout(speak, wait, text);
    return;
  }
  byId('spoken').textContent = keptToSpeak + text;
  spoken = text;
  spokenAt = performance.now();
  keptToSpeak = '';
}

let toldTimer = 0;

function tell(text) {
  const told = byId('told');
  told.textContent = text;
  told.hidden = false;
  clearTimeout(toldTimer);
  toldTimer = setTimeout(() => { told.hidden = true; }, 5000);
}

// ---- Sound: browsers allow it after a click ----
let audio = null, wantsSound = true;
try { wantsSound = localStorage.getItem('raygrid-sound') !== 'off'; } catch { /* as if on */ }

function showSound() {
  const waits = wantsSound && (!audio || audio.state !== 'running');
  byId('sound').textContent = !wantsSound ? 'Sound off' : waits ? 'Tap to enable sound' : 'Sound on';
  byId('sound').setAttribute('aria-pressed', String(wantsSound && !waits));
}

async function startSound() {
  if (!wantsSound || !window.AudioContext) return;
  audio = audio || new AudioContext();
  await audio.resume();
  showSound();
}

function play(...tones) {
  if (!wantsSound || !audio || audio.state !== 'running') return;
  tones.forEach((hertz, i) => {
    const start = audio.currentTime + 0.14 * i, tone = audio.createOscillator(), volume = audio.createGain();
    tone.frequency.value = hertz;
    volume.gain.setValueAtTime(0, start);
    volume.gain.linearRampToValueAtTime(0.3, start + 0.01);
    volume.gain.linearRampToValueAtTime(0, start + 0.13);
    tone.connect(volume).connect(audio.destination);
    tone.start(start);
    tone.stop(start + 0.14);
  });
}

byId('sound').onclick = async () => {
  const isOn = wantsSound && audio && audio.state === 'running';
  wantsSound = !isOn;
  try { localStorage.setItem('raygrid-sound', wantsSound ? 'on' : 'off'); } catch { /* for this page only */ }
  await startSound();
  showSound();
  play(660, 880);
};
document.addEventListener('pointerup', (event) => {
  if (!byId('sound').contains(event.target)) startSound();
});

// ---- The picture and what lies over it ----
const pathOf = (numbers) => {
  let path = '';
  for (let i = 0; i + 1 < numbers.length; i += 2) path += `${i ? 'L' : 'M'}${numbers[i]} ${numbers[i + 1]}`;
  return path;
};
const setPath = (id, path) => {
  byId(id).setAttribute('d', path);
  byId(`${id}-back`).setAttribute('d', path);
};

function arrowPath([x0, y0, x1, y1], size) {
  const dx = x1 - x0, dy = y1 - y0, length = Math.hypot(dx, dy);
  if (!(length > 0.03 * size)) return '';
  const head = Math.min(0.05 * size, 0.5 * length) / length;
  const barb = (side) => `${x1 - head * (dx - side * 0.7 * dy)} ${y1 - head * (dy + side * 0.7 * dx)}`;
  return `M${x0} ${y0}L${x1} ${y1}M${barb(1)}L${x1} ${y1}L${barb(-1)}`;
}

function showOverlay() {
  const {width, height, features, next_views: next, arrow} = state;
  if (!(width > 0 && height > 0)) return;
  root.style.setProperty('--shape', width / height);
  // Pixels' middles are whole numbers.
  byId('overlay').setAttribute('viewBox', `-0.5 -0.5 ${width} ${height}`);
  let dots = '';
  for (let i = 0; i + 1 < features.length; i += 2) dots += `M${features[i]} ${features[i + 1]}h0`;
  setPath('dots', dots);
  const outlines = next.map((view) => pathOf(view.outline) + 'Z').join('');
  byId('next-fill').setAttribute('d', outlines);
  setPath('next', outlines);
  setPath('top', next.map((view) => pathOf(view.top)).join(''));
  const size = Math.max(width, height), way = arrow.length === 4 ? arrowPath(arrow, size) : '';
  setPath('arrow', way);
  showTop(next[0], width, height);
  byId('key-dots').hidden = !dots;
  byId('key-next').hidden = !outlines;
  byId('key-top').hidden = !next.some((view) => view.top.length >= 4);
  byId('key-arrow').hidden = !way;
}

// The word lies on the inner side, and in the picture.
function showTop(view, width, height) {
  const text = byId('top-text'), shown = Boolean(view) && view.top.length >= 4 && view.outline.length >= 6;
  text.toggleAttribute('hidden', !shown);
  if (!shown) return;
  const mean = (numbers, from) => {
    const chosen = numbers.filter((_, i) => i % 2 === from);
    return chosen.reduce((sum, number) => sum + number, 0) / chosen.length;
  };
  const size = Math.max(width, height) / 28;
  const top = [mean(view.top, 0), mean(view.top, 1)];
  const toMiddle = [mean(view.outline, 0) - top[0], mean(view.outline, 1) - top[1]];
  const step = size / Math.max(Math.hypot(...toMiddle), 1e-6);
  const inside = (value, end) => Math.min(Math.max(value, size), end - size);
  text.setAttribute('x', inside(top[0] + step * toMiddle[0], width));
  text.setAttribute('y', inside(top[1] + step * toMiddle[1], height));
  text.setAttribute('font-size', size);
  text.setAttribute('stroke-width', size / 6);
}

// ---- The cameras of a rig, the one in the picture marked, and how they stand to each other ----
let rigKey = '';

function showRig() {
  const {cameras, links, camera} = state, list = byId('rig'), key = JSON.stringify([cameras, links, camera]);
  if (key === rigKey) return;
  rigKey = key;
  list.hidden = cameras.length === 0;
  const known = (px) => px > 0 ? ` ${pixels(px)} px` : '';
  const shown = cameras.map(({name, status: word, uncertainty_px: px}) => {
    const [sign, text, kind] = WORDS[word] || ['\u2022', word, 'idle'], item = make('li');
    const mark = make('i', {textContent: sign});
    mark.dataset.kind = kind;
    item.append(`${name} `, mark, known(px));
    item.title = `${text}${px > 0 ? `; uncertainty ${pixels(px)} px in 95 % of the image` : ''}`;
    item.classList.toggle('shown', name === camera);
    if (name === camera) item.setAttribute('aria-current', 'true');
    return item;
  });
  const pairs = links.map(({cameras: [first, second], uncertainty_px: px}) =>
    make('li', {textContent: `${first}\u2013${second}${known(px)}`, title: 'Uncertainty of predicting a board in one camera from the other'}));
  list.replaceChildren(...shown, ...pairs);
}

let liveNumber = 0, liveTimer = 0;
const live = byId('live');

function showLive() {
  clearTimeout(liveTimer);
  if (document.hidden) live.removeAttribute('src');
  else live.src = `live?${++liveNumber}`;
}
live.onerror = () => {
  clearTimeout(liveTimer);
  if (live.hasAttribute('src') && !isLost) liveTimer = setTimeout(showLive, 2000);
};
// A page that nobody sees leaves its place to others.
document.addEventListener('visibilitychange', showLive);

// ---- What is known: colours of inferno, bright where little is ----
const STOPS = [[0, 0, 4], [27, 12, 65], [74, 12, 107], [120, 28, 109], [165, 44, 96], [207, 68, 70], [237, 105, 37],
  [251, 155, 6], [247, 209, 61], [252, 255, 164]];

function colorAt(part) {
  const at = Math.min(Math.max(part, 0), 1) * (STOPS.length - 1), k = Math.min(Math.floor(at), STOPS.length - 2);
  return STOPS[k].map((from, c) => Math.round(from + (at - k) * (STOPS[k + 1][c] - from)));
}

// 0.034 px and 1.2 px: two digits.
const pixels = (value) => value >= 10 ? value.toFixed(0) : value > 0 ? String(Number(value.toPrecision(2))) : '0';
// 1, 2 and 5 times powers of ten.
function roundNumbers(low, high) {
  const numbers = [];
  for (let power = Math.floor(Math.log10(low)) - 1; power <= Math.log10(high) + 1; ++power)
    for (const digit of [1, 2, 5]) numbers.push(Number(`${digit}e${power}`));
  const first = numbers.filter((number) => number <= low * 1.0001).length - 1;
  const last = numbers.findIndex((number) => number >= high * 0.9999);
  return numbers.slice(first, Math.max(last, first + 2) + 1);
}

function readPlaces(numbers) {
  const places = [];
  for (let i = 0; i + 2 < numbers.length; i += 3)
    places.push({x: numbers[i], y: numbers[i + 1], px: numbers[i + 2] > 0 ? numbers[i + 2] : null});
  return places;
}

// Deviations between places: of the nearest most; null where the nearest has none.
function deviationAt(places, x, y) {
  let sum = 0, weights = 0, nearest = places[0], least = Infinity;
  for (const place of places) {
    const square = (place.x - x) ** 2 + (place.y - y) ** 2 + 1e-3;
    if (square < least) {
      least = square;
      nearest = place;
    }
    if (place.px === null) continue;
    const weight = 1 / (square * square);
    sum += weight * Math.log(place.px);
    weights += weight;
  }
  return nearest.px === null ? null : Math.exp(sum / weights);
}

let mapKey = '';

function showMap() {
  const {width, height, uncertainty_map: places, requested_uncertainty_px: target, next_views: next} = state;
  const key = JSON.stringify([width, height, places, target, next, byId('map').clientWidth]);
  if (key === mapKey || !(width > 0 && height > 0)) return;
  mapKey = key;
  const all = readPlaces(places), known = all.filter((place) => place.px !== null);
  byId('legend').hidden = byId('map-empty').hidden = known.length > 0;
  byId('legend').hidden = known.length === 0;
  const canvas = byId('map'), scale = Math.min(window.devicePixelRatio || 1, 2);
  canvas.width = Math.max(1, Math.round(canvas.clientWidth * scale));
  canvas.height = Math.max(1, Math.round(canvas.clientHeight * scale));
  const picture = canvas.getContext('2d');
  picture.clearRect(0, 0, canvas.width, canvas.height);
  if (known.length === 0) {
    canvas.setAttribute('aria-label', 'No estimate yet');
    return;
  }
  const values = known.map((place) => place.px);
  const ticks = roundNumbers(Math.min(...values), Math.max(...values));
  const low = Math.log(ticks[0]), high = Math.log(ticks[ticks.length - 1]);
  const partOf = (px) => (Math.log(px) - low) / (high - low);

  const columns = 72, rows = Math.max(1, Math.round(columns * height / width));
  const small = make('canvas', {width: columns, height: rows}), cells = small.getContext('2d');
  const data = cells.createImageData(columns, rows);
  for (let row = 0, at = 0; row < rows; ++row)
    for (let column = 0; column < columns; ++column, at += 4) {
      const px = deviationAt(all, (column + 0.5) / columns * width - 0.5, (row + 0.5) / rows * height - 0.5);
      const color = px === null ? [128, 136, 144] : colorAt(partOf(px));
      data.data.set([...color, 255], at);
    }
  cells.putImageData(data, 0, 0);
  picture.drawImage(small, 0, 0, canvas.width, canvas.height);
  const toX = (x) => (x + 0.5) / width * canvas.width, toY = (y) => (y + 0.5) / height * canvas.height;
  drawAboveTarget(picture, known, target, toX, toY, scale);
  drawNext(picture, next, toX, toY, scale);
  const worst = known.reduce((a, b) => a.px >= b.px ? a : b), best = known.reduce((a, b) => a.px <= b.px ? a : b);
  for (const place of known.length > 1 ? [best, worst] : [worst]) drawNumber(picture, place, toX, toY, scale);
  showLegend(ticks, partOf, target);
  const where = (place) => `${place.y < height / 3 ? 'top' : place.y > 2 * height / 3 ? 'bottom' : 'middle'} ` +
    `${place.x < width / 3 ? 'left' : place.x > 2 * width / 3 ? 'right' : 'centre'}`;
  canvas.setAttribute('aria-label', `Predicted uncertainty: from ${pixels(best.px)} px at the ${where(best)} ` +
    `to ${pixels(worst.px)} px at the ${where(worst)}`);
}

function drawAboveTarget(picture, known, target, toX, toY, scale) {
  byId('above').style.visibility = target > 0 ? 'visible' : 'hidden';
  if (!(target > 0)) return;
  for (const place of known) {
    if (place.px <= target) continue;
    picture.beginPath();
    // Whole at the image's sides, too.
    const inside = (value, end) => Math.min(Math.max(value, 4 * scale), end - 4 * scale);
    picture.arc(inside(toX(place.x), picture.canvas.width), inside(toY(place.y), picture.canvas.height), 2.5 * scale, 0, 7);
    picture.fillStyle = '#fff';
    picture.fill();
    picture.lineWidth = 1.2 * scale;
    picture.strokeStyle = '#000';
    picture.stroke();
  }
}

function drawNext(picture, next, toX, toY, scale) {
  for (const {outline} of next) {
    picture.beginPath();
    for (let i = 0; i + 1 < outline.length; i += 2) picture.lineTo(toX(outline[i]), toY(outline[i + 1]));
    picture.closePath();
    for (const [color, line] of [['#000', 4], ['#fff', 2]]) {
      picture.strokeStyle = color;
      picture.lineWidth = line * scale;
      picture.stroke();
    }
  }
}

function drawNumber(picture, place, toX, toY, scale) {
  const text = `${pixels(place.px)} px`, size = 14 * scale;
  picture.font = `700 ${size}px system-ui, sans-serif`;
  picture.textAlign = 'center';
  picture.textBaseline = 'middle';
  const half = picture.measureText(text).width / 2 + 4 * scale;
  const x = Math.min(Math.max(toX(place.x), half), picture.canvas.width - half);
  const y = Math.min(Math.max(toY(place.y), size), picture.canvas.height - size);
  picture.lineWidth = 4 * scale;
  picture.lineJoin = 'round';
  picture.strokeStyle = '#000';
  picture.strokeText(text, x, y);
  picture.fillStyle = '#fff';
  picture.fillText(text, x, y);
}

function showLegend(ticks, partOf, target) {
  const stops = Array.from({length: 17}, (_, k) => `rgb(${colorAt(k / 16).join(' ')})`);
  byId('scale').style.background = `linear-gradient(to right, ${stops.join(', ')})`;
  const step = Math.ceil(ticks.length / 5), last = ticks.length - 1;
  const nodes = ticks.filter((_, k) => k === last || (k % step === 0 && last - k >= step)).map((tick) => {
    const node = make('span', {textContent: `${pixels(tick)} px`});
    node.style.left = `${100 * partOf(tick)}%`;
    return node;
  });
  byId('ticks').replaceChildren(...nodes);
  if (target > 0) setText(byId('above'), `\u2022 above ${pixels(target)} px`);
}

// ---- Numbers ----
function setBar(id, percent, value, text) {
  const bar = byId(id);
  bar.firstElementChild.style.width = `${Math.min(Math.max(percent, 0), 100)}%`;
  if (value === null) bar.removeAttribute('aria-valuenow');
  else bar.setAttribute('aria-valuenow', value);
  bar.setAttribute('aria-valuetext', text);
}

function showProgress() {
  const {kept_frames: kept, frames_remaining: expected, uncertainty_px: now, requested_uncertainty_px: target, done: isDone,
    uncertainty_is_lower_bound: isFloor} = state;
  setText(byId('num-kept'), String(kept.length));
  setText(byId('expected'), isDone || !(expected >= 0) ? '' : expected === 0 ? ', no more needed' : `, about ${expected} more`);
  byId('progress').hidden = !(target > 0);
  const part = now > 0 && target > 0 ? Math.min(1, target / now) : 0;
  const isNear = now > target && pixels(now) === pixels(target);
  const nowText = isNear ? String(Number(now.toPrecision(3))) : pixels(now);
  const known = `Uncertainty ${nowText} px${isFloor ? ' (lower bound)' : ''}`;
  const text = !(now > 0) ? 'No estimate yet.' :
    target > 0 ? `${known}, target ${pixels(target)} px` : known;
  setBar('progress', 100 * part, Math.round(100 * part), text);
  byId('progress').classList.toggle('full', part === 1);
  setText(byId('known'), text);
}

const MAX_EDGE_PX = 5;
let sharpest = [];  // [when, px] of the last minute

function showGauges() {
  const {edge_width_px: edges, white_level: white, status: word} = state, now = performance.now();
  sharpest = sharpest.filter(([when]) => now - when < 60000);
  if (edges > 0 && (sharpest.length === 0 || now - sharpest[sharpest.length - 1][0] > 100)) sharpest.push([now, edges]);
  const best = Math.min(...sharpest.map(([, px]) => px)), mark = byId('sharpness').lastElementChild;
  mark.hidden = sharpest.length === 0;
  mark.style.left = `${Math.min(best / MAX_EDGE_PX, 0.99) * 100}%`;
  const edgeText = edges > 0 ? `${edges.toFixed(1)} px` + (best.toFixed(1) < edges.toFixed(1) ? `, best ${best.toFixed(1)}` : '') : 'unknown';
  setBar('sharpness', edges > 0 ? edges / MAX_EDGE_PX * 100 : 0, edges > 0 ? Math.min(edges, MAX_EDGE_PX) : null, edgeText);
  setText(byId('sharpness-text'), edgeText);
  byId('sharpness').classList.toggle('warn', word === 'blurred');
  const whiteText = white > 0 ? `white ${Math.round(100 * white)} %` +
    (word === 'dark' ? ', too dark' : word === 'bright' ? ', too bright' : '') : 'unknown';
  setBar('brightness', 100 * white, white > 0 ? Math.round(100 * white) : null, whiteText);
  setText(byId('brightness-text'), whiteText);
  byId('brightness').classList.toggle('warn', word === 'dark' || word === 'bright');
}

function showRemarks() {
  const list = byId('remarks'), key = JSON.stringify(state.warnings);
  byId('remarks-box').hidden = state.warnings.length === 0;
  if (list.dataset.key === key) return;
  list.dataset.key = key;
  list.replaceChildren(...state.warnings.map((text) => make('li', {textContent: text})));
}

// ---- Kept frames ----
const items = new Map();  // by name
let itemNumber = 0;

function makeItem(name) {
  const item = make('li'), open = make('button', {type: 'button', className: 'open'});
  const source = `kept/${encodeURIComponent(name)}.jpg?${++itemNumber}`;
  open.append(make('img', {src: source, alt: `View ${name}`, loading: 'lazy'}));
  open.onclick = () => look(name);
  const remove = make('button', {type: 'button', className: 'delete', textContent: 'Delete'});
  remove.setAttribute('aria-label', `Delete ${name}`);
  remove.onclick = () => askToDelete(name);
  item.append(open, make('span', {textContent: name, title: name}), remove);
  item.source = source;
  return item;
}

function showKept() {
  const list = byId('kept'), names = new Set(state.kept_frames);
  byId('kept-box').hidden = names.size === 0;
  for (const [name, item] of items)
    if (!names.has(name)) {
      item.remove();
      items.delete(name);
    }
  let isNew = false;
  for (const name of state.kept_frames) {
    if (items.has(name)) continue;
    isNew = true;
    items.set(name, makeItem(name));
    list.prepend(items.get(name));
  }
  if (lookedAt !== null && !names.has(lookedAt)) byId('look').close();
  return isNew;
}

let lookedAt = null;

function look(name) {
  lookedAt = name;
  const picture = byId('look-picture'), text = byId('look-text'), at = state.kept_frames.indexOf(name);
  byId('look-name').textContent = name;
  byId('look-older').disabled = at <= 0;
  byId('look-newer').disabled = at < 0 || at + 1 >= state.kept_frames.length;
  text.textContent = 'Loading\u2026';
  picture.style.visibility = 'hidden';
  picture.alt = name;
  picture.onload = () => {
    picture.style.visibility = 'visible';
    text.textContent = '';
  };
  picture.onerror = () => { text.textContent = 'Cannot read this frame.'; };
  picture.src = `picture/${encodeURIComponent(name)}.jpg?${++itemNumber}`;
  if (!byId('look').open) byId('look').showModal();
}
const lookBeside = (step) => {
  const name = state.kept_frames[state.kept_frames.indexOf(lookedAt) + step];
  if (name !== undefined) look(name);
};
byId('look-older').onclick = () => lookBeside(-1);
byId('look-newer').onclick = () => lookBeside(1);
byId('look-close').onclick = () => byId('look').close();
byId('look-delete').onclick = () => askToDelete(lookedAt);
byId('look').onclose = () => {
  lookedAt = null;
  byId('look-picture').onerror = null;
  byId('look-picture').removeAttribute('src');
};
byId('look').onkeydown = (event) => {
  if (event.key === 'ArrowLeft') lookBeside(-1);
  if (event.key === 'ArrowRight') lookBeside(1);
};

// ---- Commands ----
async function send(path) {
  try {
    const answer = await fetch(path, {method: 'POST'});
    if (answer.ok) return true;
    tell(`Failed: ${(await answer.text()).trim()}`);
  } catch {
    tell('Failed: the program does not respond.');
  }
  return false;
}

function confirmThen(text, yes, no, picture, act) {
  byId('ask-text').textContent = text;
  byId('ask-yes').textContent = yes;
  byId('ask-no').textContent = no;
  byId('ask-picture').hidden = !picture;
  if (picture) byId('ask-picture').src = picture;
  byId('ask-yes').onclick = () => {
    byId('ask').close();
    act();
  };
  byId('ask').showModal();
}
byId('ask-no').onclick = () => byId('ask').close();

function askToDelete(name) {
  confirmThen(`Delete the frame ${name}?`, 'Delete', 'Keep', items.get(name)?.source,
    () => send(`delete?name=${encodeURIComponent(name)}`));
}

async function finish() {
  if (await send('finish')) tell('Finishing\u2026');
}
byId('pause').onclick = () => send(state && state.paused ? 'go-on' : 'pause');
byId('undo').onclick = () => send('undo');
byId('finish').onclick = () => {
  if (state && state.done) finish();
  else confirmThen('Finish now? More frames would improve the calibration.', 'Finish', 'Continue', '', finish);
};

// ---- States ----
// Hints begin in small letters where they are parts of lines elsewhere.
const sentence = (text) => text.slice(0, 1).toUpperCase() + text.slice(1);

function show(newState) {
  const isFirst = state === null, wasDone = !isFirst && state.done;
  state = newState;
  const isNew = showKept() && !isFirst;
  showOverlay();
  showRig();
  showMap();
  showProgress();
  showGauges();
  showRemarks();
  setText(byId('hint'), sentence(state.hint));
  byId('hint').classList.toggle('long', state.hint.length > 50);
  setText(byId('facts'), [state.camera, state.frames_per_second > 0 ? `${state.frames_per_second.toFixed(1)} frames/s` : '']
    .filter(Boolean).join(', '));
  byId('done').hidden = !state.done;
  root.classList.toggle('is-done', state.done);
  root.classList.toggle('is-paused', state.paused);
  setText(byId('pause'), state.paused ? 'Continue' : 'Pause');
  byId('pause').classList.toggle('main', state.paused);
  byId('finish').classList.toggle('main', state.done);
  byId('undo').disabled = state.kept_frames.length === 0;
  document.title = `${state.done ? 'Done' : `${state.kept_frames.length} kept`} \u2013 raygrid capture`;
  if (isNew) {
    wordUntil = 0;
    putWord('kept', KEPT_MS);
    byId('stage').classList.remove('kept');
    void byId('stage').offsetWidth;  // the animation begins anew
    byId('stage').classList.add('kept');
    setTimeout(() => byId('stage').classList.remove('kept'), KEPT_MS);
    if (navigator.vibrate && navigator.userActivation?.hasBeenActive) navigator.vibrate(60);
  }
  if (isNew && !(state.done && !wasDone)) play(660, 880);
  if (state.done && !wasDone && !isFirst) play(660, 880, 1320);
  showWord();
  if (isNew) keptToSpeak = `Kept, ${state.kept_frames.length} frames. `;
  speak((state.done ? 'Done. ' : '') + `${byId('word-text').textContent}. ${state.hint}`);
  root.dataset.states = Number(root.dataset.states || 0) + 1;
}

// ---- The connection, which a capture that begins anew at this address takes up ----
let events = null, heardAt = performance.now(), isLost = false, hasEnded = false, connectTimer = 0;

function connect() {
  clearTimeout(connectTimer);
  if (events) events.close();
  heardAt = performance.now();
  events = new EventSource('state');
  events.onmessage = (event) => {
    heardAt = performance.now();
    hasEnded = false;
    setLost(false);
    show(JSON.parse(event.data));
  };
  events.addEventListener('end', () => {
    hasEnded = true;
    byId('told').hidden = true;
    setLost(true);
  });
  events.onerror = () => {
    setLost(true);
    // Else it tries again by itself.
    if (events.readyState === EventSource.CLOSED) connectTimer = setTimeout(connect, 2000);
  };
}

function setLost(lost) {
  if (lost === isLost) return;
  isLost = lost;
  const time = new Date().toLocaleTimeString([], {hour: '2-digit', minute: '2-digit'});
  byId('lost').textContent = hasEnded ?
    `\u2713 ${state?.done ? 'Done. ' : ''}The capture ended with ${state?.kept_frames.length ?? 0} frames.` :
    `! Connection lost at ${time}. Reconnecting\u2026`;
  byId('lost').classList.toggle('good', hasEnded);
  byId('lost').hidden = !lost;
  root.classList.toggle('is-lost', lost);
  for (const id of ['pause', 'undo', 'finish']) byId(id).disabled = lost;
  if (!lost) showLive();
}
setInterval(() => {
  if (performance.now() - heardAt < SILENCE_MS) return;
  setLost(true);
  connect();
}, 1000);

window.addEventListener('resize', () => { if (state) showMap(); });
showSound();
showLive();
connect();
