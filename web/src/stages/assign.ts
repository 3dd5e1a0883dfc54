import type { Step } from '../protocol/types.ts';
import { isObject, type Json, valueAt } from './schema.ts';

export interface Assignment {
  path: Step[];
  value: Json;
}

/**
 * What to set so that `path` gets a value, where mappings above it may be missing yet. `typeAt` names the type of a stage that is left
 * out, since a stage without its type cannot be written.
 */
export function assignment(
  root: Json | undefined,
  path: Step[],
  value: Json,
  typeAt: (path: Step[]) => string | null,
): Assignment {
  for (let depth = path.length - 1; depth > 0; depth--) {
    const above = path.slice(0, depth);
    if (isObject(valueAt(root, above)) || Array.isArray(valueAt(root, above))) {
      return { path: path.slice(0, depth + 1), value: wrap(path, depth + 1, value, typeAt) };
    }
  }
  return { path: path.slice(0, 1), value: wrap(path, 1, value, typeAt) };
}

function wrap(path: Step[], depth: number, value: Json, typeAt: (path: Step[]) => string | null): Json {
  if (depth === path.length) return value;
  const type = typeAt(path.slice(0, depth));
  const inner = wrap(path, depth + 1, value, typeAt);
  return type === null ? { [path[depth]]: inner } : { type, [path[depth]]: inner };
}
