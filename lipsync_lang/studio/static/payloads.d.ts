/**
 * Types of what the studio's server and the line page send, with arrays in their places.
 *
 * Python writes them: `take_data.py`, `face_data.py`, `workshop.py` and the modules of `routes`.
 */

/** A pose or a channel over the frames, in steps of 1/65535 from `low` to `high`. */
export interface Curve {
  low: number;
  high: number;
  moves: boolean;
  bone: boolean;
  values: Uint16Array;
}

export interface Curves {
  poses: string[];
  curves: Curve[];
}

/** A word: its text, its first phoneme, and the one after its last. */
export type Word = [text: string, first: number, stop: number];

export interface Spoken {
  title: string;
  estimated: boolean;
  times: number[];
  labels: string[];
  words: Word[];
  emphasis: number[];
  /** Words of the text that the aligner left out, in order. */
  left_out: string[];
  /** Confidence of the words that the aligner doubts, by their number. */
  doubts: Record<number, number>;
}

export interface Figure {
  name: string;
  verdict: string;
  told: string;
  findings: [seconds: number, what: string][];
}

export interface Bigram {
  pair: string;
  layer: string;
  status: string;
  from: string[];
  word?: string;
  trigram?: string;
  drawn_as?: string;
}

/** A bigram at a frame: side 0 ends there, side 1 begins. */
export type PlacedBigram = Bigram & { side: number; position: number };

export interface Stage {
  name: string;
  label: string;
  colour: string;
  /** Number of the pattern on its colour. */
  hatch: number;
  why: string;
  /** By moving pose; null if the stage leaves the pose unchanged. */
  curves: (Uint16Array | null)[];
  reasons: [first: number, stop: number, text: string][][];
}

/** The stages of a take; absent for an animation of another program. */
export interface Making {
  poses: string[];
  moving: number[];
  common: string[];
  source: number[];
  bounds: number[];
  stages: Stage[];
  phoneme: Uint16Array;
  places: [Uint16Array, Uint16Array];
  /** The bigrams of the line, each once. */
  bigrams: Bigram[];
  /** Number of each spoken bigram among `bigrams`. */
  said: number[];
  given: [Uint16Array[], Uint16Array[]];
  dials: { name: string; poses: number[]; level: Float32Array }[];
}

/** A gesture that is on: seconds before its fact, its length, and the room that it keeps. */
export interface GestureKind {
  name: string;
  lead: number;
  seconds: number;
  room: number;
}

/** A gesture of a take: the time of its fact, and its number among those placed by hand, or -1. */
export interface GestureRow {
  name: string;
  at: number;
  begin: number;
  scale: number;
  why: string;
  hand: number;
}

export interface Gestures {
  poses: string[];
  kinds: GestureKind[];
  rows: GestureRow[];
  /** Number in the line of the first word shown. */
  first: number;
}

/** A gesture as a character's file places it: at a time, or beside a word. */
export interface GestureByHand {
  gesture: string;
  at?: number;
  word?: number;
  after?: number;
  scale?: number;
}

export interface TakeData extends Curves {
  name: string;
  face: number;
  fps: number;
  start: number;
  count: number;
  measures: Record<string, Record<string, number>>;
  spoken: Spoken;
  figures: Figure[];
  language?: string;
  character?: string;
  /** Mirrored poses, left and right, by a name for both. */
  mirrored?: Record<string, [left: string, right: string]>;
  making?: Making;
  /** Channels of a rig, whose poses are the take's. */
  channels: Curves | null;
  /** Gestures of a line in the studio; null without columns of gestures. */
  gestures?: Gestures | null;
}

export interface Skin {
  bones: number[];
  inverse: Float32Array;
  sets: number;
  joints: Uint16Array;
  shares: Uint16Array;
}

export interface Shape {
  channels: number[];
  rest: number;
  scale: number;
  points: Uint16Array | Uint32Array;
  deltas: Int16Array;
}

/** A mesh: its points at rest in steps of `scale` about `middle`. */
export interface FacePart {
  node: number;
  first: number;
  count: number;
  middle: number[];
  scale: number;
  points: Int16Array;
  shapes: Shape[];
  skin: Skin | null;
}

/** A node: with `moves` it has a place, a turn and a size, and else a matrix. */
export interface FaceNode {
  parent: number;
  matrix: number[];
  moves?: { channel: number; turn: number[] | null; shift: number[] | null }[];
  translation: number[];
  rotation: number[];
  scale: number[];
}

export interface FaceMaterial {
  first: number;
  count: number;
  cutoff: number;
  double: boolean;
  gloss: number;
  lit: boolean;
  image: Uint8Array<ArrayBuffer> | null;
}

export interface FaceCamera {
  middle: number[];
  turn: number[][];
  distance: number;
  half: number;
  field: number;
}

export interface FaceLight {
  lamps: number[][];
  sky: number[];
  ground: number[];
  sharpest: number;
  least: number;
  around: number;
  cells: number;
  bias: number;
  behind: number;
}

/** A model; one that cannot be drawn has `unshown` alone. */
export interface Face {
  unshown: string[];
  count: number;
  camera: FaceCamera;
  close: FaceCamera;
  light: FaceLight;
  nodes: FaceNode[];
  parts: FacePart[];
  triangles: Uint16Array | Uint32Array;
  groups: Uint16Array | Uint32Array;
  normals: Int8Array;
  colours: Uint16Array;
  places: Float32Array | null;
  moving: Uint8Array;
  materials: FaceMaterial[];
}

/** The document of a line page. */
export interface Page {
  title: string;
  settings: string[];
  sound: { rate: number; samples: Int16Array } | null;
  takes: TakeData[];
  faces: Face[];
}

export interface Pose {
  name: string;
  title: string;
  region: string;
}

/** Points of a level, or of a curve: time and value. */
export type Level = number | [number, number][];

/** Settings of a performance, as far as they are not the usual ones. */
export interface Settings {
  fps?: number;
  line?: string | null;
  styles?: Record<string, Level>;
  dials?: Record<string, Level>;
  /** Keys of poses: seconds and the amount that is added. */
  bends?: Record<string, [number, number][]>;
  intensity?: number | null;
  /** Gestures placed by hand. */
  placed?: GestureByHand[];
}

/** A line that was opened or performed; the fields from `sound` on are those of a line just opened. */
export interface Line {
  revision: number;
  takes: TakeData[];
  part: LinePart | null;
  sound: { rate: number; samples: Int16Array; start: number } | null;
  remarks: string[];
  unread: string;
  text: string;
  settings: Settings;
  /** Name under which the character keeps the line. */
  name: string;
  /** Number of lines opened so far. */
  opened: number;
  script: ScriptPlace | null;
  /** The state after a change that was kept. */
  state?: State;
}

/** A line of the script. */
export interface ScriptLine {
  number: number;
  name: string;
  language: string;
  character: string;
  speaker: string;
  text: string;
  recording: boolean;
  timings: boolean;
}

/** The place of a line in the script, with its neighbours. */
export interface ScriptPlace {
  name: string;
  number: number;
  count: number;
  beside: (ScriptLine | null)[];
}

/** State of the studio; the fields from `poseset` on are absent without an open pair. */
export interface State {
  revision: number;
  language: string;
  character: string;
  unsaved: { file: string; at: (string | number)[]; what: string }[];
  undo: string | null;
  redo: string | null;
  restored: number;
  notes: string[];
  poseset: string;
  poses: Pose[];
  phonemes: string[];
  shades: Record<string, string>;
  measures: Record<string, Record<string, number>>;
  regions: Record<string, string[]>;
  styles: string[];
  lines: string[];
  /** Texts of the lines that the character keeps, apart from those of the script. */
  kept: string[];
  warnings: string[];
  text: string;
  settings: Settings;
  line: boolean;
  name: string;
  opened: number;
}

/** A part of a long line. */
export interface LinePart {
  number: number;
  count: number;
  seconds: number;
}

export interface Project {
  folder: string;
  languages: string[];
  characters: string[];
  tours: string[];
  /** What is opened if nothing is chosen; null without a tour. */
  first: { language: string; character: string; line: string } | null;
  state: State;
}

export interface Fault {
  place: string;
  code: string;
  what: string;
  hint: string;
}

/** A rule that lowers a pose. */
export interface Act {
  pose: string;
  other: string;
  why: string;
}

/** A test of a language pack, as it was run. */
export interface PackTest {
  text: string;
  ipa: string;
  source: string;
  passed: boolean;
  right: boolean;
  expected: string[];
  said: string[];
  claimed: string[];
  labels: string[];
  unmapped: string[];
}

export interface TranscribedWord {
  text: string;
  labels: { label: string; common: string[] }[];
  pronounced: string[] | null;
}

export interface Transcript {
  text: string;
  phonemes: string[];
  words: TranscribedWord[];
  unread: string[];
  unmapped: string[];
  automatic: Record<string, { loses: string[] }>;
}

/** Words or labels that a count of a script could not use. */
export interface Tally {
  what: string;
  count: number;
  place: string;
}

/** A line of a script with bigrams that are still to draw. */
export interface NeededSentence {
  text: string;
  place: string;
  bigrams: string[];
}
