import { mirrorImage, restPosition } from '../picking/image.ts';
import type { MeshFacts, Op, Pair, Side } from '../protocol/types.ts';
import type { MeshData } from '../viewer/surface.ts';
import { pairTitle } from './order.ts';

/** Relative to the diagonal, as the server has them: how near two points are one, and how far an image may lie off the surface. */
const SAME = 0.01;
const FARTHEST = 0.05;

export interface MirrorSide {
  mesh: MeshData;
  facts: MeshFacts;
  /** Where the plane crosses the axis, in the file's unit; the middle if left out. */
  offset: number | undefined;
}

/** What adds the partner of one pair beyond a plane, or why it gets none. */
export function mirrorOne(
  pair: Pair,
  pairs: readonly Pair[],
  axis: 'x' | 'y' | 'z',
  sides: Record<Side, MirrorSide>,
): { op: Extract<Op, { op: 'add' }> } | { problem: string } {
  const number = 'xyz'.indexOf(axis);
  const images = (['source', 'target'] as const).map((side) => {
    const { mesh, facts, offset } = sides[side];
    const point = pair[side];
    if (!point) return { problem: `It has no point on the ${side} yet.` };
    const plane = offset === undefined ? 0 : offset - facts.origin[number];
    const image = mirrorImage(mesh, point, number, plane);
    if (image.distance > FARTHEST * facts.diagonal) return { problem: `Beyond the plane there is no ${side}.` };
    const near = (other: Pair) => {
      const there = other[side];
      return there !== null && restPosition(mesh, there).distanceTo(image.position) <= SAME * facts.diagonal;
    };
    return { image, there: pairs.filter(near) };
  });
  const problem = images.find((image) => 'problem' in image);
  if (problem) return { problem: problem.problem ?? '' };
  const [source, target] = images;
  if (source.there?.includes(pair) && target.there?.includes(pair)) return { problem: 'It lies on the plane.' };
  const partner = source.there?.find((other) => target.there?.includes(other));
  if (partner) return { problem: `Its partner is there already: ${pairTitle(partner)}.` };
  const name = mirroredName(pair.name, new Set(pairs.map((other) => other.name)));
  return { op: { op: 'add', name, source: source.image?.point, target: target.image?.point } };
}

/** A name that no pair has: with left and right exchanged, or `mirrored`. */
export function mirroredName(name: string | null, taken: ReadonlySet<string | null>): string | undefined {
  if (name === null) return undefined;
  const wanted = exchangeSides(name) ?? `${name} mirrored`;
  for (let number = 1; ; number++) {
    const free = number === 1 ? wanted : `${wanted} ${number}`;
    if (!taken.has(free)) return free;
  }
}

const SIDES: Record<string, string> = {
  left: 'right',
  Left: 'Right',
  LEFT: 'RIGHT',
  l: 'r',
  L: 'R',
};
for (const [left, right] of Object.entries(SIDES)) SIDES[right] = left;

/** The name of the other side, e.g. `earLeft`, `left ear` or `ear.L`; null if it names no side. */
function exchangeSides(name: string): string | null {
  const words = /(?<![A-Za-z])(?:left|right)(?![a-z])|(?<![A-Z])(?:Left|Right)(?![a-z])|\b(?:LEFT|RIGHT)\b/g;
  const letter = /(?<=[._ -])[lrLR]$|^[lrLR](?=[._ -])/;
  for (const pattern of [words, letter]) {
    const other = name.replace(pattern, (side) => SIDES[side]);
    if (other !== name) return other;
  }
  return null;
}
