import type { Poses } from '../protocol/types.ts';

/** All clips of the source's file, as the pipeline says it. */
export const ALL = '*';
/** Some of the clips and not all; no clip is called by a blank. */
export const SEVERAL = ' ';

/** The clip that the poses are of, `ALL`, `SEVERAL`, or null for none. */
export function chosenClip(poses: Pick<Poses, 'list' | 'clips'> | null): string | null {
  const names = new Set((poses?.list ?? []).map((pose) => pose.clip).filter((name) => name !== null));
  if (names.size > 1) return names.size >= (poses?.clips ?? []).length ? ALL : SEVERAL;
  const [name] = names;
  return name ?? null;
}

/** What to set in the pipeline so that its poses are those of a clip; other settings of the clip stay. */
export function clipSetting(pipeline: unknown, clip: string): { path: string[]; value: unknown } {
  const source = member(pipeline, 'source');
  const poses = member(source, 'poses');
  if (isMapping(poses) && !('files' in poses) && !('file' in poses)) {
    return { path: ['source', 'poses', 'clip'], value: clip };
  }
  return { path: ['source', 'poses'], value: { clip } };
}

function member(value: unknown, key: string): unknown {
  return isMapping(value) ? value[key] : undefined;
}

function isMapping(value: unknown): value is Record<string, unknown> {
  return value !== null && typeof value === 'object' && !Array.isArray(value);
}
