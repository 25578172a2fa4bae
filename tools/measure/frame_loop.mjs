// Undistorts one frame again and again in Node: frame_loop.mjs RAYGRID_JS FOLDER FORMAT FRAMES OUT
import {readFileSync, writeFileSync} from 'node:fs';
import {pathToFileURL} from 'node:url';

const [library, folder, name, frames, destination] = process.argv.slice(2);
const {Camera, load} = await import(pathToFileURL(library));
await load();
const camera = new Camera(readFileSync(`${folder}/view.raygrid`));
const frame = readFileSync(`${folder}/${name}.raw`);
const out = new Uint8Array(frame.length);
const format = {GREY: 'GREY8', RGB: 'RGB24'}[name] ?? name;
for (let i = 0; i < Number(frames); ++i) camera.undistort(frame, out, {format});
writeFileSync(destination, out);
