/** raygrid's runtime: a blob, pixels to rays and back, undistorted frames.
 *
 * Pixel (0, 0) is the centre of the top-left pixel. Camera axes are x right, y down, z forward.
 * Every call that is refused throws: a RaygridError with the runtime's text and number, or a
 * TypeError or RangeError for arguments that the runtime never sees. */

/** An image position, x and y. */
export type Pixel = readonly [number, number];
/** A direction, or a point, in camera axes. */
export type Vector = readonly [number, number, number];
export type Matrix = readonly [Vector, Vector, Vector];
export type Bytes = ArrayBuffer | ArrayBufferView;

export type Projection =
  'pinhole' | 'cylindrical' | 'equirectangular' | 'stereographic' | 'equidistant';
export type Format =
  'GREY8' | 'GREY16' | 'GREY10P' | 'GREY12P' | 'RGB24' | 'RGB32' | 'YUYV' | 'UYVY' | 'NV12' |
  'YUV420' | 'BAYER8' | 'BAYER16' | 'BAYER10P' | 'BAYER12P' | 'RGB565';

/** A line in space: from the point, in metres, along the direction. */
export interface Line {
  point: Vector;
  direction: Vector;
}

/** The virtual camera of undistorted images; lengths in pixels. */
export interface View {
  projection: Projection;
  width: number;
  height: number;
  fx: number;
  fy: number;
  cx: number;
  cy: number;
  /** Turns directions in axes of the view to camera axes, row by row. */
  rotation: Matrix;
}

/** How frames lie in those that were calibrated: pixel i, counted from the other side where
 * flipped, covers calibrated pixels from offset + scale i on, scale of them; for x and for y. */
export interface Mode {
  width: number;
  height: number;
  offset: readonly [number, number];
  scale: readonly [number, number];
  flips: readonly [boolean, boolean];
}

/** A table of a blob; of a faulty one there is the error alone. */
export interface Table {
  frameSize?: readonly [number, number];
  /** A table that distorts makes frames of the camera out of the view. */
  view?: View & {distorts: boolean};
  mode?: Mode;
  error?: RaygridError;
}

export interface Match {
  result: 'exact' | 'mode' | 'derivable' | 'none';
  /** The first table that undistorts such frames, or null. */
  table: number | null;
}

export interface UndistortOptions {
  format?: Format;
  border?: 'value' | 'clamp' | 'keep';
  /** Up to 4, one of each channel. */
  borderValues?: readonly number[];
  sampling?: 'bilinear' | 'nearest';
}

export class RaygridError extends Error {
  /** A number of formats/rg_status.h. */
  readonly status: number;
}

export const FORMATS: Readonly<Record<Format, readonly unknown[]>>;
export const PROJECTIONS: readonly Projection[];

/** Compiles the runtime, once; cameras can be made afterwards. */
export function load(): Promise<void>;

/** A view with square pixels around the middle of the image; hfov is in radians. */
export function makeView(wanted: {
  projection?: Projection; width: number; height: number; hfov: number}): View;

/** The direction, in camera axes and of any length, that a pixel of a view looks along; null where
 * the view shows nothing. */
export function viewDirection(view: View, pixel: Pixel): Vector | null;

/** A blob, of which a copy is kept. Its first table is in use, if it has any. Memory goes with the
 * camera: there is nothing to free. */
export class Camera {
  constructor(blob: Bytes);
  /** The size of calibrated frames. */
  readonly width: number;
  readonly height: number;
  readonly isCentral: boolean;
  /** Whether project() and useView() have what they need: blobs of formats before 1.3 do not. */
  readonly canProject: boolean;
  /** The bytes of the blob, with the table of useView(). */
  readonly blob: Uint8Array;

  /** Directions of pixels; null outside the calibrated area. */
  unproject(points: readonly Pixel[]): (Vector | null)[];
  unprojectLines(points: readonly Pixel[]): (Line | null)[];
  /** Pixels of directions or points, of cameras of lines in metres; null where nothing is seen. */
  project(points: readonly Vector[]): (Pixel | null)[];
  /** Whether the camera may be trusted at pixels. */
  isValid(points: readonly Pixel[]): boolean[];
  /** Standard deviations of projection, in pixels; null where the blob does not say. */
  uncertainty(points: readonly Pixel[]): (number | null)[];
  /** Positions of pixels in the undistorted image; null for those that have none. */
  undistortPoints(points: readonly Pixel[]): (Pixel | null)[];

  readonly numTables: number;
  readonly tables: readonly Table[];
  /** The index of the table in use, or -1. */
  readonly table: number;
  selectTable(index: number): void;
  /** Makes the camera that of a lens position in dioptres, or of a temperature in degrees Celsius,
   * as the blob's stack has it; from then on, with all tables. False: the value lies outside the
   * stack's range, and the camera is that of the nearest end. */
  setCondition(value: number): boolean;
  /** Makes a table for a view, adds it to the camera's blob, and uses it. It replaces the one that
   * an earlier call made. Throws for a blob with a stack. */
  useView(view: View): void;
  /** Of the table in use: width and height of the frames that undistort() takes, and makes. */
  readonly frameSize: readonly [number, number];
  readonly size: readonly [number, number];
  readonly view: View & {distorts: boolean};
  readonly mode: Mode;
  /** Whether the blob is for the frames at hand, and which table is. */
  match(frames: {width: number; height: number; mode?: Mode | null; serial?: string | null}): Match;

  /** The undistorted frame: planes after each other, rows without gaps, as the frame has them. It is
   * written to out, if that is given, and returned. */
  undistort(frame: Bytes): Uint8Array;
  undistort(frame: Bytes, out: null | undefined, options?: UndistortOptions): Uint8Array;
  undistort<T extends Bytes>(frame: Bytes, out: T, options?: UndistortOptions): T;
}
