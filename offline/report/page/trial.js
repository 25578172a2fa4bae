// Undistorts a photograph by the runtime, in views that the reader chooses.
(async () => {
  const byId = (id) => document.getElementById(id);
  const MAX_WIDTH_PX = 1280;  // of the view
  const DEGREE = Math.PI / 180;
  const MAX_DEGREES = {pinhole: 160, cylindrical: 350, equirectangular: 350, stereographic: 320,
    equidistant: 350};
  const {showTip, hideTip} = window.raygridReport;
  const section = byId('trial'), taken = byId('trial-taken'), made = byId('trial-made');
  const kind = byId('trial-kind'), angle = byId('trial-angle');
  const say = (text) => { byId('trial-message').textContent = text; };

  await load();
  const camera = new Camera(
    Uint8Array.from(atob(section.dataset.blob), (c) => c.charCodeAt(0)));
  const numPacked = camera.numTables;
  const size = [camera.width, camera.height];
  let frame = null;  // the photograph's bytes, RGB32

  // ---- Views ----------------------------------------------------------------

  // The angle between what the left and the right edge see, in degrees.
  const widthOfLens = () => {
    const y = (size[1] - 1) / 2;
    const rays = camera.unproject([0, 0.25, 0.5, 0.75, 1].map((part) => [part * (size[0] - 1), y]));
    let sum = 0;
    for (let k = 1; k < rays.length; ++k) {
      const [a, b] = [rays[k - 1], rays[k]];
      if (!a || !b) continue;
      sum += Math.acos(Math.min(1, a[0] * b[0] + a[1] * b[1] + a[2] * b[2])) / DEGREE;
    }
    return Math.round(Math.max(5, sum));
  };

  const showAngle = () => {
    byId('trial-angle-row').hidden = !(kind.value in MAX_DEGREES);
    angle.max = MAX_DEGREES[kind.value] || 350;
    byId('trial-degrees').textContent = `${angle.value}\u00b0`;
  };

  const chooseView = () => {
    showAngle();
    if (kind.value === 'packed') return camera.selectTable(0);
    const width = Math.min(size[0], MAX_WIDTH_PX);
    camera.useView(makeView({projection: kind.value, width, hfov: angle.value * DEGREE,
      height: Math.max(1, Math.round(width * size[1] / size[0]))}));
  };

  const setUpViews = () => {
    const lens = widthOfLens();
    if (camera.canProject)
      for (const name of PROJECTIONS) kind.append(new Option(name, name));
    if (numPacked > 0) kind.append(new Option('remap table of camera.raygrid', 'packed'));
    kind.value = !camera.canProject ? 'packed' : lens < 110 ? 'pinhole' : 'stereographic';
    angle.max = 350;
    angle.value = lens;
    showAngle();
  };

  // ---- Pictures -------------------------------------------------------------

  const undistort = () => {
    if (!frame || !kind.value) return;
    const started = performance.now();
    try {
      chooseView();
      const picture = new ImageData(...camera.size);
      camera.undistort(frame, picture.data, {format: 'RGB32', borderValues: [0, 0, 0, 255]});
      [made.width, made.height] = camera.size;
      made.getContext('2d').putImageData(picture, 0, 0);
      const {width, height, fx} = camera.view;
      byId('trial-figures').textContent = `${width} \u00d7 ${height} px, fx ${fx.toFixed(1)} px, ` +
        `${Math.round(performance.now() - started)} ms`;
    } catch (error) {
      say(`Cannot create this view: ${error.message}`);
    }
  };

  const show = (picture, name) => {
    [taken.width, taken.height] = size;
    const context = taken.getContext('2d', {willReadFrequently: true});
    context.drawImage(picture, 0, 0, ...size);
    frame = context.getImageData(0, 0, ...size).data;
    section.classList.add('shown');
    say(name);
    undistort();
  };

  const open = async (file) => {
    try {
      // As calibrate reads it, whatever way up the file says that it is.
      const picture = await createImageBitmap(file,
        {imageOrientation: 'none', colorSpaceConversion: 'none'});
      if (picture.width !== size[0] || picture.height !== size[1])
        say(`${file.name} has ${picture.width} \u00d7 ${picture.height} px; use an image of ` +
          `this camera at the calibrated size, ${size.join(' \u00d7 ')} px.`);
      else
        show(picture, file.name);
    } catch {
      say(`${file.name} is not an image that this browser can read; use a PNG or JPEG file.`);
    }
  };

  // ---- Rays -----------------------------------------------------------------

  const mark = (canvas, pixel) => {
    const cross = canvas.nextElementSibling;
    cross.hidden = !pixel || pixel[0] < -0.5 || pixel[1] < -0.5 || pixel[0] > canvas.width - 0.5 ||
      pixel[1] > canvas.height - 0.5;
    if (cross.hidden) return;
    cross.style.left = `${(pixel[0] + 0.5) / canvas.width * 100}%`;
    cross.style.top = `${(pixel[1] + 0.5) / canvas.height * 100}%`;
  };

  const describe = (pixel) => {
    const place = `(${pixel.map((v) => v.toFixed(1)).join(', ')})`;
    const [ray] = camera.unproject([pixel]);
    if (!ray) return `${place}: not calibrated`;
    const tilt = Math.acos(Math.max(-1, Math.min(1, ray[2]))) / DEGREE;
    const [deviation] = camera.uncertainty([pixel]), [valid] = camera.isValid([pixel]);
    return `${place}: ray direction (${ray.map((v) => v.toFixed(4)).join(', ')}), ` +
      `${tilt.toFixed(2)}\u00b0 from the z axis` +
      (deviation === null ? '' : `; \u00b1 ${deviation.toFixed(4)} px`) +
      (valid ? '' : '; outside the valid region');
  };

  const pixelAt = (canvas, event) => {
    const box = canvas.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width * canvas.width - 0.5,
      (event.clientY - box.top) / box.height * canvas.height - 0.5];
  };

  const hoverTaken = (event) => {
    const pixel = pixelAt(taken, event);
    mark(taken, null);
    mark(made, camera.table < 0 ? null : camera.undistortPoints([pixel])[0]);
    showTip(event, describe(pixel));
  };

  // Lines are followed to 1 km; the packed table of another camera may not be projected.
  const hoverMade = (event) => {
    const pixel = pixelAt(made, event);
    const ray = camera.canProject ? viewDirection(camera.view, pixel) : null;
    const [source] = ray ? camera.project([ray.map((v) => 1000 * v)]) : [null];
    mark(made, null);
    mark(taken, source);
    showTip(event, source ? describe(source) : 'not visible to the camera');
  };

  const leave = () => {
    hideTip();
    mark(taken, null);
    mark(made, null);
  };

  // ---- All ------------------------------------------------------------------

  setUpViews();
  kind.onchange = angle.oninput = undistort;
  byId('trial-file').onchange = (event) => {
    if (event.target.files.length) open(event.target.files[0]);
  };
  section.addEventListener('dragover', (event) => event.preventDefault());
  section.addEventListener('drop', (event) => {
    event.preventDefault();
    if (event.dataTransfer.files.length) open(event.dataTransfer.files[0]);
  });
  taken.addEventListener('pointermove', hoverTaken);
  made.addEventListener('pointermove', hoverMade);
  for (const canvas of [taken, made]) canvas.addEventListener('pointerleave', leave);
  section.hidden = false;
  // Large photographs take memory, so the example waits until a reader comes by.
  const example = document.querySelector('img[alt="Original"]');
  const showExample = async () => {
    await example.decode();
    if (!frame) show(example, example.naturalWidth === size[0] ? 'The example above.'
      : `The example above, ${example.naturalWidth} px wide, enlarged.`);
  };
  if (example) new IntersectionObserver((entries, observer) => {
    if (!entries.some((entry) => entry.isIntersecting)) return;
    observer.disconnect();
    showExample();
  }).observe(section);
})().catch((error) => {
  document.getElementById('trial').hidden = true;
  console.error(`cannot run the runtime in this browser: ${error.message}`);
});
