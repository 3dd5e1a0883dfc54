import type { Pipeline, Step } from '../protocol/types.ts';
import type { Json } from './schema.ts';

/** What a form needs of the pipeline that it edits. */
export interface FormHost {
  pipeline: Pipeline;
  /** The paths of the settings that are unfolded. */
  open: Set<string>;
  set: (path: Step[], value: Json) => void;
  unset: (path: Step[]) => void;
  /** Draws the form anew, e.g. when something is unfolded. */
  redraw: () => void;
}
