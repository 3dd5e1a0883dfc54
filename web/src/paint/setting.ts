/** What puts a mask into a pipeline. Pure. */

export interface Setting {
  path: string[];
  value: unknown;
  /** What it does, for people. */
  says: string;
}

/** Shapes that fit `pattern` move only what the mask in `file` lets them. */
export function maskSetting(pipeline: unknown, pattern: string, file: string): Setting {
  const name = file.split(/[\\/]/).pop() ?? file;
  const says = `Shapes that fit ${pattern} are masked by ${name}.`;
  const shapes = member(pipeline, 'shapes');
  const masks = member(shapes, 'masks');
  if (isMapping(masks)) return { path: ['shapes', 'masks', pattern], value: { file: name }, says };
  if (isMapping(shapes)) return { path: ['shapes', 'masks'], value: { [pattern]: { file: name } }, says };
  return { path: ['shapes'], value: { masks: { [pattern]: { file: name } } }, says };
}

/** The transfer keeps `components` rigid; one that does not know rigid parts gives way to `multi_component`. */
export function rigidSetting(pipeline: unknown, components: string[]): Setting {
  const transfer = member(pipeline, 'transfer');
  const names = components.join(', ');
  if (member(transfer, 'type') === 'multi_component') {
    return { path: ['transfer', 'rigid'], value: components, says: `The transfer keeps ${names} rigid.` };
  }
  const says = `The transfer is multi_component now, and keeps ${names} rigid.`;
  return { path: ['transfer'], value: { type: 'multi_component', rigid: components }, says };
}

function member(value: unknown, key: string): unknown {
  return isMapping(value) ? value[key] : undefined;
}

function isMapping(value: unknown): value is Record<string, unknown> {
  return value !== null && typeof value === 'object' && !Array.isArray(value);
}
