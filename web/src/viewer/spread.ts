/** Where the numbers of points go, so that none covers another. Pure. */

export interface Spot {
  id: number;
  /** The dot, in pixels. */
  x: number;
  y: number;
  /** Half the width of the number's tag. */
  half: number;
}

/** From the dot to the middle of the tag. */
export interface TagPlace {
  dx: number;
  dy: number;
  /** Whether the tag lies so far away that a line must lead to it. */
  led: boolean;
}

const NEAR = 13;
const HALF_HEIGHT = 8;
const DOT = 5;
const GAP = 1;
/** More numbers than that are not read one by one. */
const MOST = 250;

const PLACES: readonly TagPlace[] = [
  ...[
    [1, -1],
    [-1, -1],
    [1, 1],
    [-1, 1],
  ].map(([x, y]) => ({ dx: x * NEAR, dy: y * NEAR, led: false })),
  ...[30, 44, 58].flatMap((distance) =>
    Array.from({ length: 12 }, (_, i) => {
      const angle = ((i % 2 === 0 ? 1 : -1) * Math.ceil(i / 2) * Math.PI) / 6 - Math.PI / 4;
      return { dx: Math.cos(angle) * distance, dy: Math.sin(angle) * distance, led: true };
    }),
  ),
];

/** The usual place: up and to the right. */
export const USUAL_PLACE = PLACES[0];

interface Box {
  x: number;
  y: number;
  width: number;
  height: number;
}

/**
 * A place for the tag of each spot; earlier spots choose first. A tag stays where it was in `before` while it is free there, so that it
 * does not hop about as the view turns.
 */
export function spread(spots: readonly Spot[], before: ReadonlyMap<number, TagPlace>): Map<number, TagPlace> {
  if (spots.length > MOST) return new Map(spots.map(({ id }) => [id, USUAL_PLACE]));
  const dots = spots.map(({ x, y }) => ({ x, y, width: DOT, height: DOT }));
  const tags: Box[] = [];
  const chosen = new Map<number, TagPlace>();
  for (const [i, spot] of spots.entries()) {
    const boxAt = ({ dx, dy }: TagPlace) => ({
      x: spot.x + dx,
      y: spot.y + dy,
      width: spot.half,
      height: HALF_HEIGHT,
    });
    const covered = (place: TagPlace) => {
      const box = boxAt(place);
      const ofTags = tags.reduce((sum, other) => sum + overlap(box, other), 0);
      return dots.reduce((sum, other, k) => (k === i ? sum : sum + overlap(box, other)), ofTags);
    };
    const last = before.get(spot.id);
    const place = last && !last.led && covered(last) === 0 ? last : leastCovered(last, covered);
    chosen.set(spot.id, place);
    tags.push(boxAt(place));
  }
  return chosen;
}

/** The first place that is free, the near ones before the one of last time and the far ones; else the least covered. */
function leastCovered(last: TagPlace | undefined, covered: (place: TagPlace) => number): TagPlace {
  let best = USUAL_PLACE;
  let least = Infinity;
  const near = PLACES.filter((place) => !place.led);
  for (const place of [...near, ...(last ? [last] : []), ...PLACES.slice(near.length)]) {
    const area = covered(place);
    if (area < least) [best, least] = [place, area];
    if (area === 0) break;
  }
  return best;
}

/** The common area of two boxes that are given by their middles and half sizes. */
function overlap(a: Box, b: Box): number {
  const width = a.width + b.width + GAP - Math.abs(a.x - b.x);
  const height = a.height + b.height + GAP - Math.abs(a.y - b.y);
  return width > 0 && height > 0 ? width * height : 0;
}
