import type { Markers } from '../protocol/types.ts';

/** The document before the server has sent one. */
export const EMPTY: Markers = {
  revision: 0,
  file: null,
  exists: false,
  pairs: [],
  can_undo: false,
  can_redo: false,
  undo: null,
  undo_order: null,
  redo: null,
  redo_order: null,
  problems: [],
  disk: 'saved',
  disk_error: null,
};
