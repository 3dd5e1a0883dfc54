import type { DraggedPoint } from '../app/studio.ts';
import { pairColour } from '../markers/colours.ts';
import type { Pair, Point, Side } from '../protocol/types.ts';
import type { Label } from '../viewer/label.ts';
import type { Pane } from './pane.ts';

export interface LabelState {
  pairs: readonly Pair[];
  selected: number | null;
  hovered: number | null;
  dragged: DraggedPoint | null;
  place: Place | null;
}

/** A place that the page points at for a while. */
export interface Place {
  side: Side;
  point: Point;
  /** From 1 to 0 while it fades. */
  strength: number;
}

/** Of the label of a place; pairs have no such id. */
const PLACE_ID = Number.MIN_SAFE_INTEGER;

/** The labels of the points of a pane's mesh, where they are now. */
export function labelsOf(pane: Pane, state: LabelState): Label[] {
  const labels: Label[] = [];
  for (const pair of state.pairs) {
    const dragged = state.dragged?.pair === pair.id && state.dragged.side === pane.side;
    const point = dragged ? (state.dragged?.point ?? null) : pair[pane.side];
    const place = point && pane.locate(point);
    if (!place) continue;
    labels.push({
      id: pair.id,
      text: String(pair.number),
      colour: pairColour(pair.colour),
      ...place,
      hollow: pair.status === 'proposed' && !dragged,
      faint: pair.status === 'skipped',
      selected: pair.id === state.selected,
      hovered: pair.id === state.hovered || dragged,
    });
  }
  const at = state.place?.side === pane.side ? pane.locate(state.place.point) : null;
  if (state.place && at) {
    labels.push({
      id: PLACE_ID,
      text: 'here',
      colour: '#c81e4a',
      ...at,
      hollow: false,
      faint: false,
      selected: true,
      hovered: false,
      passive: true,
      strength: state.place.strength,
    });
  }
  return labels;
}

/** Whether two lists of labels look alike, so that no picture is needed. */
export function sameLabels(a: readonly Label[], b: readonly Label[]): boolean {
  return a.length === b.length && a.every((label, i) => same(label, b[i]));
}

function same(a: Label, b: Label): boolean {
  return (
    a.id === b.id &&
    a.text === b.text &&
    a.colour === b.colour &&
    a.hollow === b.hollow &&
    a.faint === b.faint &&
    a.selected === b.selected &&
    a.hovered === b.hovered &&
    a.strength === b.strength &&
    a.position.equals(b.position)
  );
}
