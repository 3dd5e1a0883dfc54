import type { Pipeline, Step } from '../protocol/types.ts';
import type { Json } from './schema.ts';

/** What a form needs of the pipeline that it edits. */
export interface FormHost {
  pipeline: Pipeline;
  /** The paths of the settings that are unfolded. */
  open: Set<string>;
  set: (path: Step[], value: Json) => void;
  unset: (path: Step[]) => void;
  /** The value of a text in YAML, or what is wrong with it. */
  parse: (text: string) => Promise<{ value: Json } | { problem: string }>;
  /** Draws the form anew, e.g. when something is unfolded. */
  redraw: () => void;
}
