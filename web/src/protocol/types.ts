/** The messages of docs/studio-protocol.md. */

export type Side = 'source' | 'target';
export type Channel = 'source' | 'preview' | 'result' | 'truth';
export type Step = string | number;
export type Level = 'good' | 'doubtful' | 'bad' | 'broken_gate';

export interface ApiError {
  code: string;
  message: string;
  hint: string | null;
  diagnostics: Diagnostic[];
}

export interface Diagnostic {
  level: 'error' | 'warning';
  message: string;
  hint: string | null;
  file: string | null;
  line: number | null;
  column: number | null;
  length: number | null;
  path: Step[] | null;
}

export interface Session {
  project: number | null;
  /** The number of the project when its pipeline was opened. */
  opened: number | null;
  version: string;
  allow_commands: boolean;
  name: string | null;
  source: MeshFacts | null;
  target: MeshFacts | null;
  poses: Poses | null;
  scalars: Scalar[];
  has_truth: boolean;
  live: { preview: boolean; reason: string | null };
}

export interface MeshFacts {
  file: string | null;
  vertices: number;
  polygons: number;
  triangles: number;
  components: Component[];
  bounds: [[number, number, number], [number, number, number]];
  origin: [number, number, number];
  diagonal: number;
  up: 'x' | 'y' | 'z';
  unit: string | null;
  warnings: string[];
}

export interface Component {
  name: string;
  vertices: number;
  triangles: number;
}

export interface Poses {
  are: 'frames' | 'shapes';
  fps: number | null;
  /** The clips of the source's file. */
  clips: Clip[];
  list: { name: string; clip: string | null; seconds: number | null }[];
}

export interface Clip {
  name: string;
  seconds: number;
  frames: number;
}

export interface Scalar {
  name: string;
  title: string;
  unit: string;
  needs_truth: boolean;
}

export interface Folder {
  path: string;
  parent: string | null;
  roots: { name: string; path: string }[];
  entries: FolderEntry[];
}

export interface FolderEntry {
  name: string;
  path: string;
  kind: 'folder' | 'mesh' | 'pipeline' | 'markers' | 'other';
  bytes: number;
  modified: number;
}

export type OpenRequest = { pipeline: string } | { source: string; target: string };

export type Point = { triangle: number; barycentric: [number, number, number] } | { vertex: number };
export type Status = 'confirmed' | 'proposed' | 'skipped';

export interface Pair {
  id: number;
  number: number;
  colour: number;
  name: string | null;
  note: string | null;
  source: Point | null;
  target: Point | null;
  status: Status;
  confidence: number | null;
  origin: 'user' | 'proposed' | 'mirrored' | 'file';
  revision: number;
}

export interface Markers {
  revision: number;
  file: string | null;
  /** Whether there is such a file yet. */
  exists: boolean;
  pairs: Pair[];
  can_undo: boolean;
  can_redo: boolean;
  undo: string | null;
  /** Where the step stands among those of the markers and of the pipeline. */
  undo_order: number | null;
  redo: string | null;
  redo_order: number | null;
  problems: { pair: number; side: Side | null; message: string; hint: string | null }[];
  disk: DiskState;
  disk_error: string | null;
}

export type DiskState = 'saved' | 'changed_elsewhere' | 'failed';

export type Op =
  | { op: 'add'; name?: string; note?: string; source?: Point; target?: Point }
  | { op: 'move'; pair: number; side: Side; point: Point | null }
  | { op: 'rename'; pair: number; name: string | null }
  | { op: 'note'; pair: number; note: string | null }
  | { op: 'status'; pair: number; status: Status }
  | { op: 'delete'; pair: number }
  | { op: 'reorder'; pair: number; before: number | null }
  | { op: 'mirror'; axis: 'x' | 'y' | 'z'; pair?: number; source_offset?: number; target_offset?: number };

export interface Edit {
  project: number;
  base: number;
  id: string;
  /** Of the page: its own changes do not conflict with each other. */
  client: string;
  ops: Op[];
}

export interface Conflict {
  op: number;
  pair: number | null;
  reason: string;
  current: Pair | null;
}

export interface EditResult {
  markers: Markers;
  added: (number | null)[];
  conflicts: Conflict[];
  mirrored: { added: number; left: { pair: number; reason: string }[] } | null;
}

export interface Next {
  kind: 'partner' | 'doubtful' | 'new' | 'none';
  pair: number | null;
  source: Point | null;
  target: Point | null;
  reason: string;
}

export type PoseRef = null | { index: number } | { blend: [number, number][] };

export type ToServer =
  | { type: 'look'; look: number; pose: PoseRef; channels: Channel[]; scalar: string | null; ahead: boolean }
  | { type: 'drag'; drag: number; pair: number; side: Side; point: Point | null };

export interface FrameHeader {
  project: number;
  channel: Channel;
  look: number;
  drag: number | null;
  pose: PoseRef;
  revision: number;
  pipeline: number;
  scalar: FrameScalar | null;
  milliseconds: number;
}

export interface FrameScalar {
  name: string;
  title: string;
  unit: string;
  low: number;
  high: number;
  limit: number | null;
}

export interface LiveState {
  channel: 'preview' | 'result' | 'truth';
  state: 'computing' | 'ready' | 'unavailable' | 'failed';
  revision: number;
  stage: string | null;
  share: number | null;
  error: ApiError | null;
}

/** How many frames of the clip have a result that can be played. */
export interface Ahead {
  revision: number;
  pipeline: number;
  done: number;
  count: number;
  /** How far they lie apart. */
  step: number;
  scalar: string | null;
  error: ApiError | null;
}

export interface Worst {
  pose: number | null;
  pose_name: string | null;
  metric: string;
  title: string;
  value: number | null;
  unit: string;
  limit: number | null;
  level: Level;
  about: string | null;
  vertex: number | null;
  /** The whole reason in words. */
  words: string;
  /** What is wrong, and what helps. */
  fault: string;
  /** What the statistic is, exactly. */
  meaning: string;
}

export type FromServer =
  | { type: 'hello'; project: number | null; markers: number; pipeline: number }
  | { type: 'session'; session: Session }
  | { type: 'markers'; markers: Markers; cause: string }
  | { type: 'pipeline'; pipeline: Pipeline; cause: string }
  | { type: 'job'; job: Job }
  | ({ type: 'live' } & LiveState)
  | { type: 'worst'; channel: 'result'; revision: number; list: Worst[] }
  | ({ type: 'ahead' } & Ahead)
  | { type: 'error'; error: ApiError };

export interface Pipeline {
  revision: number;
  file: string | null;
  exists: boolean;
  text: string;
  value: unknown;
  diagnostics: Diagnostic[];
  /** What is known of the text is still that of the text before. */
  checking: boolean;
  choices: { slot: string; value: unknown; reason: string }[];
  outputs: string[];
  disk: DiskState;
  disk_error: string | null;
  undo: string | null;
  undo_order: number | null;
  redo: string | null;
  redo_order: number | null;
}

export interface Job {
  id: number;
  kind: 'propose' | 'run';
  /** The project that it is about, by its number when it was opened. */
  project: number;
  state: 'running' | 'done' | 'failed' | 'cancelled';
  stage: string | null;
  share: number | null;
  poses: { done: number; count: number } | null;
  seconds: number;
  seconds_left: number | null;
  error: ApiError | null;
  warnings: string[];
  result: RunResult | null;
}

export interface RunResult {
  status: 'done' | 'gate' | 'partly';
  verdict: Level | null;
  written: { name: string; path: string; bytes: number; url: string }[];
  report: unknown;
  summary: Summary;
  /** What the run was of. */
  of: { project: number; markers: number; pipeline: number };
  worst: Worst[];
}

/** What came of a run, in the sentences of its report. */
export interface Summary {
  total: string;
  things: number;
  faults: { metric: string; sentence: string }[];
  next_steps: string[];
}

export interface Mask {
  name: string;
  side: Side;
  file: string;
  kind: 'weights' | 'components';
}

export interface About {
  version: string;
  licences: { name: string; version: string; licence: string; text: string }[];
}
