/** What a report holds of its worst poses, as `crates/pipeline/src/page/scene.rs` writes it. */
export interface ReportData {
  /** Degrees to the right of the front, and above the ground. */
  angles: [number, number];
  /** Source and target. */
  meshes: [MeshEntry, MeshEntry];
  /** Worst first. */
  poses: PoseEntry[];
}

export interface Coordinates {
  low: [number, number, number];
  size: [number, number, number];
  steps: string;
}

export interface MeshEntry {
  rest: Coordinates;
  /** Whether numbers of vertices have 32 bits in place of 16. */
  wide: boolean;
  triangles: string;
  /** A byte a triangle: whether it is of one polygon with the one before; null where all polygons are triangles. */
  continues: string | null;
}

export interface FieldEntry {
  /** Name and unit, e.g. `error, %`. */
  unit: string;
  high: number;
  /** Whether there are values above `high`. */
  over: boolean;
  steps: string;
}

export interface PoseEntry {
  name: string;
  level: string;
  verdict: string;
  reasons: string[];
  source: Coordinates | null;
  result: Coordinates;
  field: FieldEntry | null;
}

const STEPS = 65535;
const UNKNOWN = 65535;

/** Numbers are read from their bytes, low byte first, whatever the machine has. */
export function numbers16(text: string): Uint16Array {
  const bytes = decode(text);
  const result = new Uint16Array(bytes.length / 2);
  for (let i = 0; i < result.length; i++) result[i] = bytes[2 * i] | (bytes[2 * i + 1] << 8);
  return result;
}

export function positionsOf(coordinates: Coordinates): Float32Array {
  const steps = numbers16(coordinates.steps);
  const result = new Float32Array(steps.length);
  for (let i = 0; i < steps.length; i++) {
    const axis = i % 3;
    result[i] = coordinates.low[axis] + (steps[i] / STEPS) * coordinates.size[axis];
  }
  return result;
}

/** NaN stands for unknown values. */
export function valuesOf(field: FieldEntry): Float32Array {
  const steps = numbers16(field.steps);
  return Float32Array.from(steps, (step) => (step === UNKNOWN ? Number.NaN : (step / (STEPS - 1)) * field.high));
}

export function trianglesOf(mesh: MeshEntry): Uint32Array {
  const halves = numbers16(mesh.triangles);
  if (!mesh.wide) return Uint32Array.from(halves);
  const result = new Uint32Array(halves.length / 2);
  for (let i = 0; i < result.length; i++) result[i] = halves[2 * i] + halves[2 * i + 1] * 65536;
  return result;
}

export function continuesOf(mesh: MeshEntry): Uint8Array | null {
  return mesh.continues === null ? null : decode(mesh.continues);
}

function decode(text: string): Uint8Array {
  const binary = atob(text);
  const result = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; i++) result[i] = binary.charCodeAt(i);
  return result;
}
