import type { Markers } from '../protocol/types.ts';

/** The document before the server has sent one. */
export const EMPTY: Markers = {
  revision: 0,
  file: null,
  pairs: [],
  can_undo: false,
  can_redo: false,
  undo: null,
  redo: null,
  problems: [],
  disk: 'saved',
  disk_error: null,
};
