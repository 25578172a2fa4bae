// Draws what the page's data hold: charts by Chart.js, the rest on canvases.
'use strict';
(() => {
  const data = JSON.parse(document.getElementById('data').textContent);
  const byId = (id) => document.getElementById(id);
  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const textColor = () => getComputedStyle(document.body).color;
  const redraws = [];  // after a change of size or colours

  const tip = document.createElement('div');
  tip.id = 'tip';
  document.body.append(tip);
  const showTip = (event, text) => {
    tip.textContent = text;
    tip.style.display = text ? 'block' : 'none';
    const room = innerWidth - tip.offsetWidth - 8;
    tip.style.left = `${Math.max(4, Math.min(event.clientX + 14, room))}px`;
    tip.style.top = `${event.clientY + 14}px`;
  };
  const hideTip = () => { tip.style.display = 'none'; };

  // A canvas as sharp as the screen; draw(context, width, height) in CSS pixels.
  const makeCanvas = (canvas, aspect, draw) => {
    const redraw = () => {
      const width = canvas.clientWidth, height = width * aspect;
      const ratio = devicePixelRatio || 1;
      canvas.style.height = `${height}px`;
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
      const context = canvas.getContext('2d');
      context.scale(ratio, ratio);
      draw(context, width, height);
    };
    redraws.push(redraw);
    redraw();
    return redraw;
  };

  // ---- Residuals ------------------------------------------------------------

  const decode = (base64) => {
    const text = atob(base64), bytes = new Uint8Array(text.length);
    for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
    const view = new DataView(bytes.buffer);
    return (index) => view.getInt16(2 * index, true);
  };
  const number = data.residuals === undefined ? null : decode(data.residuals);
  const residual = (k) => ({
    x: number(4 * k) * data.position_px, y: number(4 * k + 1) * data.position_px,
    dx: number(4 * k + 2) * data.error_px, dy: number(4 * k + 3) * data.error_px,
  });
  const SETS = ['training', 'held_out', 'rejected'];
  const NAMES = {training: 'training', held_out: 'held out', rejected: 'outlier'};
  const colorOf = (set) =>
    css(set === 'training' ? '--training' : set === 'held_out' ? '--held' : '--rejected');

  const nearestTraining = (x, y) => {
    let best = null, smallest = Infinity;
    for (const image of data.images) {
      const part = image.training;
      if (!part) continue;
      for (let k = part.first; k < part.first + part.count; ++k) {
        const dx = number(4 * k) * data.position_px - x, dy = number(4 * k + 1) * data.position_px - y;
        if (dx * dx + dy * dy < smallest) {
          smallest = dx * dx + dy * dy;
          best = {k, image};
        }
      }
    }
    return best;
  };

  const describeImage = (x, y) => {
    const near = nearestTraining(x, y);
    const place = `(${x.toFixed(0)}, ${y.toFixed(0)})`;
    if (!near) return place;
    const r = residual(near.k);
    return `${place} nearest: ${near.image.name}, residual (${r.dx.toFixed(3)}, ${r.dy.toFixed(3)}) px`;
  };

  // ---- Pictures: zoom and hover ----------------------------------------------

  const makeZoom = (view) => {
    const picture = view.querySelector('img');
    const kind = view.dataset.view;
    let scale = 1, left = 0, top = 0, last = null;
    const apply = () => {
      const width = view.clientWidth, height = view.clientHeight;
      left = Math.min(0, Math.max(left, width * (1 - scale)));
      top = Math.min(0, Math.max(top, height * (1 - scale)));
      picture.style.transform = `translate(${left}px, ${top}px) scale(${scale})`;
      view.style.touchAction = scale > 1 ? 'none' : 'auto';
    };
    const zoomAt = (x, y, factor) => {
      const wanted = Math.min(16, Math.max(1, scale * factor));
      left = x - (x - left) * wanted / scale;
      top = y - (y - top) * wanted / scale;
      scale = wanted;
      apply();
    };
    const buttons = document.createElement('div');
    buttons.className = 'zoom';
    for (const [label, factor, name] of [['+', 2, 'zoom in'], ['\u2212', 0.5, 'zoom out']]) {
      const button = document.createElement('button');
      button.textContent = label;
      button.setAttribute('aria-label', name);
      button.onclick = () => zoomAt(view.clientWidth / 2, view.clientHeight / 2, factor);
      buttons.append(button);
    }
    view.append(buttons);
    view.addEventListener('wheel', (event) => {
      if (!event.ctrlKey && scale === 1 && event.deltaY > 0) return;  // the page scrolls
      event.preventDefault();
      const box = view.getBoundingClientRect();
      zoomAt(event.clientX - box.left, event.clientY - box.top, event.deltaY < 0 ? 1.25 : 0.8);
    }, {passive: false});
    view.addEventListener('pointerdown', (event) => {
      if (event.target.tagName !== 'BUTTON') last = event;
    });
    addEventListener('pointerup', () => { last = null; });
    picture.draggable = false;
    view.addEventListener('pointerleave', hideTip);
    view.addEventListener('pointermove', (event) => {
      if (last && scale > 1) {
        left += event.clientX - last.clientX;
        top += event.clientY - last.clientY;
        last = event;
        apply();
      }
      if (!number || (kind !== 'image' && kind !== 'area')) return;
      const box = picture.getBoundingClientRect();
      const u = (event.clientX - box.left) / box.width, v = (event.clientY - box.top) / box.height;
      const [x0, y0, x1, y1] =
        kind === 'area' ? data.area : [-0.5, -0.5, data.size[0] - 0.5, data.size[1] - 0.5];
      showTip(event, describeImage(x0 + u * (x1 - x0), y0 + v * (y1 - y0)));
    });
  };

  // ---- Charts ---------------------------------------------------------------

  const charts = [];
  const axis = (title, more = {}) => ({
    title: {display: true, text: title, color: textColor()},
    ticks: {color: textColor(), ...(more.ticks || {})},
    grid: {color: '#8884'}, ...more.axis,
  });
  const makeChart = (id, configuration) => {
    const canvas = byId(id);
    if (!canvas) return null;
    const chart = new Chart(canvas, {
      ...configuration,
      options: {
        animation: false, maintainAspectRatio: false, responsive: true,
        ...configuration.options,
      },
    });
    charts.push(chart);
    return chart;
  };
  const legend = () => ({labels: {color: textColor()}});

  const drawDistribution = () => {
    const datasets = SETS.filter((set) => data.quantiles[set] && data.quantiles[set].length)
      .map((set) => ({
        label: NAMES[set], borderColor: colorOf(set), backgroundColor: colorOf(set),
        borderDash: set === 'training' ? [] : [6, 4], pointRadius: 0, pointHitRadius: 8,
        data: data.quantiles[set].map((x, k) => ({x, y: k / 2})),
      }));
    makeChart('distribution', {
      type: 'line', data: {datasets},
      options: {
        scales: {
          x: axis('error, px', {axis: {type: 'linear', min: 0}}),
          y: axis('features, %', {axis: {min: 0, max: 100}}),
        },
        plugins: {legend: legend()},
      },
    });
  };

  const drawLines = () => {
    makeChart('lines', {
      type: 'scatter',
      data: {datasets: [{
        label: 'lines', pointRadius: 2, backgroundColor: colorOf('training'),
        data: data.lines.map(([x, y]) => ({x, y})),
      }]},
      options: {
        scales: {x: axis('angle, degrees'), y: axis('distance, mm', {axis: {min: 0}})},
        plugins: {legend: {display: false}},
      },
    });
  };

  const median = (image, set) => (image[set] ? image[set].median : null);
  const drawBars = () => {
    const names = data.images.map((image) => image.name);
    const datasets = ['training', 'held_out']
      .filter((set) => data.images.some((image) => image[set]))
      .map((set) => ({
        label: NAMES[set], backgroundColor: colorOf(set),
        data: data.images.map((image) => median(image, set)),
      }));
    makeChart('bars', {
      type: 'bar', data: {labels: names, datasets},
      options: {
        interaction: {mode: 'index', intersect: false},
        onClick: (event, elements) => { if (elements.length) select(elements[0].index); },
        scales: {x: axis('image', {ticks: {maxRotation: 60}}), y: axis('median error, px')},
        plugins: {legend: legend()},
      },
    });
  };

  // ---- Residuals of an image ------------------------------------------------

  let selected = 0, photograph = null, redrawArrows = () => {};
  const loadPhotograph = (name) => {
    photograph = null;
    const jpeg = data.thumbnails && data.thumbnails[name];
    if (!jpeg) return;
    const picture = new Image();
    picture.onload = () => {
      if (data.images[selected].name !== name) return;
      photograph = picture;
      redrawArrows();
    };
    picture.src = `data:image/jpeg;base64,${jpeg}`;
  };
  const niceScale = (value) => {
    const power = 10 ** Math.floor(Math.log10(value));
    return [1, 2, 5].map((k) => k * power).filter((k) => k <= value).pop() || power;
  };
  const drawArrows = (context, width, height) => {
    const image = data.images[selected];
    const scale = width / data.size[0];
    const typical = median(image, 'training') || median(image, 'held_out') || 1;
    const enlarged = niceScale(data.size[0] / 40 / Math.max(typical, 1e-9));
    byId('enlarged').textContent = enlarged;
    if (photograph) {
      context.globalAlpha = 0.5;  // the residuals stand out
      context.drawImage(photograph, 0, 0, width, height);
      context.globalAlpha = 1;
    }
    context.strokeStyle = '#8888';
    const [x0, y0, x1, y1] = data.area;
    context.strokeRect((x0 + 0.5) * scale, (y0 + 0.5) * scale, (x1 - x0) * scale, (y1 - y0) * scale);
    for (const set of SETS) {
      const part = image[set];
      if (!part) continue;
      context.strokeStyle = context.fillStyle = colorOf(set);
      context.lineWidth = 1.5;
      for (let k = part.first; k < part.first + part.count; ++k) {
        const r = residual(k), x = (r.x + 0.5) * scale, y = (r.y + 0.5) * scale;
        context.beginPath();
        if (set === 'rejected') {
          context.moveTo(x - 5, y - 5);
          context.lineTo(x + 5, y + 5);
          context.moveTo(x - 5, y + 5);
          context.lineTo(x + 5, y - 5);
        } else {
          context.arc(x, y, 1.8, 0, 7);
          context.fill();
          context.beginPath();
          context.moveTo(x, y);
          context.lineTo(x + r.dx * enlarged * scale, y + r.dy * enlarged * scale);
        }
        context.stroke();
      }
    }
  };
  const figures = (image) => SETS.filter((set) => image[set]).map((set) =>
    set === 'rejected' ? `${image[set].count} outliers`
      : `${NAMES[set]}: median ${image[set].median.toPrecision(3)} px, largest ${image[set].max.toPrecision(3)} px`)
    .join('; ');
  const select = (index) => {
    selected = (index + data.images.length) % data.images.length;
    byId('image').selectedIndex = selected;
    loadPhotograph(data.images[selected].name);
    byId('image-figures').textContent = figures(data.images[selected]);
    redrawArrows();
  };
  const setUpImages = () => {
    const list = byId('image');
    for (const image of data.images) list.append(new Option(image.name));
    list.onchange = () => select(list.selectedIndex);
    byId('previous').onclick = () => select(selected - 1);
    byId('next').onclick = () => select(selected + 1);
    redrawArrows = makeCanvas(byId('arrows'), data.size[1] / data.size[0], drawArrows);
    select(0);
  };

  // ---- Grid -----------------------------------------------------------------

  const setUpGrid = () => {
    const canvas = byId('grid'), grid = data.grid;
    if (!canvas || !grid) return;
    const [x0, y0, x1, y1] = data.area, [cellX, cellY] = grid.cell;
    const left = x0 - cellX, top = y0 - cellY;
    const extentX = x1 - x0 + 2 * cellX, extentY = y1 - y0 + 2 * cellY;
    const place = (index, width, height) => [
      (index % grid.columns * cellX + cellX / 4) / (extentX + cellX / 2) * width,
      (Math.floor(index / grid.columns) * cellY + cellY / 4) / (extentY + cellY / 2) * height];
    makeCanvas(canvas, extentY / extentX, (context, width, height) => {
      const [ax, ay] = place(grid.columns + 1, width, height);
      const [bx, by] = place((grid.rows - 1) * grid.columns - 2, width, height);
      context.strokeStyle = '#8886';
      for (let i = 1; i < grid.columns - 1; ++i) {
        const x = ax + (bx - ax) * (i - 1) / (grid.columns - 3);
        context.strokeRect(x, ay, 0.01, by - ay);
      }
      for (let j = 1; j < grid.rows - 1; ++j) {
        const y = ay + (by - ay) * (j - 1) / (grid.rows - 3);
        context.strokeRect(ax, y, bx - ax, 0.01);
      }
      const radius = Math.max(1.2, Math.min(4, width / grid.columns / 5));
      for (let k = 0; k < grid.columns * grid.rows; ++k) {
        const [x, y] = place(k, width, height), seen = grid.support[k];
        context.beginPath();
        context.arc(x, y, radius, 0, 7);
        context.fillStyle = seen >= 3 ? css('--training') : css('--few');
        context.strokeStyle = css('--fail');
        if (seen > 0) context.fill(); else context.stroke();
      }
    });
    canvas.addEventListener('pointerleave', hideTip);
    canvas.addEventListener('pointermove', (event) => {
      const box = canvas.getBoundingClientRect();
      const column = Math.round((event.clientX - box.left) / box.width * (extentX + cellX / 2) / cellX - 0.25);
      const row = Math.round((event.clientY - box.top) / box.height * (extentY + cellY / 2) / cellY - 0.25);
      if (column < 0 || row < 0 || column >= grid.columns || row >= grid.rows) return hideTip();
      const k = row * grid.columns + column;
      showTip(event, `control point (${column}, ${row}) at x ${(left + column * cellX).toFixed(0)}, ` +
        `y ${(top + row * cellY).toFixed(0)} px: ${grid.angle_deg[k].toFixed(2)}\u00b0 from the z axis, ` +
        `${grid.support[k]} features`);
    });
  };

  // ---- Space ----------------------------------------------------------------

  const setUpSpace = () => {
    const canvas = byId('space'), space = data.space;
    if (!canvas || !space) return;
    const corners = space.boards.flatMap((board) => board.corners);
    const centers = space.cameras.map((camera) => camera.center);
    const all = corners.concat(centers);
    const middle = [0, 1, 2].map((k) => {
      const values = all.map((p) => p[k]).sort((a, b) => a - b);
      return (values[0] + values[values.length - 1]) / 2;
    });
    const radius = Math.max(1e-6, ...all.map((p) => Math.hypot(...p.map((v, k) => v - middle[k]))));
    let yaw = 0.7, pitch = 0.35, zoom = 1, last = null;
    const frustum = radius * 0.18;
    byId('space-scale').textContent = space.boards.length < space.all
      ? `${space.boards.length} of ${space.all} boards are shown` : `${space.all} boards`;
    const redraw = makeCanvas(canvas, 0.62, (context, width, height) => {
      const unit = zoom * 0.45 * Math.min(width, height) / radius;
      const project = (p) => {
        const [x, y, z] = p.map((v, k) => v - middle[k]);
        const u = Math.cos(yaw) * x - Math.sin(yaw) * z, w = Math.sin(yaw) * x + Math.cos(yaw) * z;
        return [width / 2 + unit * u, height / 2 + unit * (Math.cos(pitch) * y - Math.sin(pitch) * w)];
      };
      const path = (points, closed) => {
        context.beginPath();
        points.forEach((p, k) => context[k ? 'lineTo' : 'moveTo'](...project(p)));
        if (closed) context.closePath();
      };
      context.lineWidth = 1;
      for (const board of space.boards) {
        path(board.corners, true);
        context.fillStyle = css('--training') + '22';
        context.strokeStyle = css('--training') + 'aa';
        context.fill();
        context.stroke();
      }
      context.lineWidth = 1.5;
      context.font = '13px system-ui, sans-serif';
      for (const camera of space.cameras) {
        const ends = camera.rays.map((ray) => ray.map((v, k) => camera.center[k] + frustum * v));
        context.strokeStyle = css('--held');
        path(ends, true);
        context.stroke();
        for (const end of ends) {
          path([camera.center, end], false);
          context.stroke();
        }
        const [x, y] = project(camera.center);
        context.fillStyle = textColor();
        context.fillText(camera.name, x + 6, y - 6);
      }
      ['x', 'y', 'z'].forEach((name, k) => {
        const end = [0, 1, 2].map((i) => (i === k ? frustum * 1.4 : 0));
        context.strokeStyle = context.fillStyle = textColor();
        path([[0, 0, 0], end], false);
        context.stroke();
        context.fillText(name, ...project(end));
      });
      const bar = niceScale(width / 4 / unit);
      context.fillRect(16, height - 18, bar * unit, 3);
      context.fillText(`${bar} m`, 16, height - 24);
    });
    const pointers = new Map();
    canvas.addEventListener('pointerdown', (event) => {
      pointers.set(event.pointerId, event);
      last = event;
      canvas.setPointerCapture(event.pointerId);
    });
    const release = (event) => { pointers.delete(event.pointerId); last = null; };
    canvas.addEventListener('pointerup', release);
    canvas.addEventListener('pointercancel', release);
    canvas.addEventListener('pointermove', (event) => {
      if (!pointers.has(event.pointerId)) return;
      const before = pointers.get(event.pointerId);
      if (pointers.size === 2) {
        const other = [...pointers.values()].find((p) => p.pointerId !== event.pointerId);
        const distance = (p) => Math.hypot(p.clientX - other.clientX, p.clientY - other.clientY);
        zoom *= distance(event) / Math.max(1, distance(before));
      } else if (last) {
        yaw += (event.clientX - before.clientX) / 150;
        pitch = Math.max(-1.57, Math.min(1.57, pitch + (event.clientY - before.clientY) / 150));
      }
      pointers.set(event.pointerId, event);
      redraw();
    });
    canvas.addEventListener('wheel', (event) => {
      event.preventDefault();
      zoom *= event.deltaY < 0 ? 1.15 : 0.87;
      redraw();
    }, {passive: false});
  };

  // ---- All ------------------------------------------------------------------

  const recolor = () => {
    for (const chart of charts) {
      for (const scale of Object.values(chart.options.scales))
        scale.title.color = scale.ticks.color = textColor();
      if (chart.options.plugins.legend.labels) chart.options.plugins.legend.labels.color = textColor();
      chart.update();
    }
    for (const redraw of redraws) redraw();
  };

  window.raygridReport = {showTip, hideTip};  // for trial.js
  document.documentElement.classList.add('ready');
  document.querySelectorAll('.view').forEach(makeZoom);
  if (data.quantiles) drawDistribution();
  if (data.images && data.images.length) {
    drawBars();
    setUpImages();
  }
  if (data.lines) drawLines();
  setUpGrid();
  setUpSpace();
  let waiting = 0;
  addEventListener('resize', () => {
    clearTimeout(waiting);
    waiting = setTimeout(() => redraws.forEach((redraw) => redraw()), 150);
  });
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', recolor);
  addEventListener('beforeprint', () => {
    charts.forEach((chart) => chart.resize());
    recolor();
  });
  document.documentElement.dataset.readyMs = Math.round(performance.now());
})();
