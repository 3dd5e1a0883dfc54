import type { Op, Pair } from '../protocol/types.ts';

/**
 * What operations do to pairs, as far as the page can tell before the server answers. A new pair has an id below zero until then.
 * Operations on pairs that are gone do nothing; the server reports them as conflicts.
 */
export function applyOps(pairs: readonly Pair[], ops: readonly Op[], firstNewId: number): Pair[] {
  let result = [...pairs];
  let newId = firstNewId;
  for (const op of ops) {
    if (op.op === 'add') {
      result = [...result, newPair(op, result, newId)];
      newId -= 1;
    } else if (op.op === 'delete') {
      result = result.filter((pair) => pair.id !== op.pair);
    } else if (op.op === 'reorder') {
      result = reorder(result, op.pair, op.before);
    } else if (op.op !== 'mirror') {
      result = result.map((pair) => (pair.id === op.pair ? change(pair, op) : pair));
    }
  }
  return result;
}

type Change = Extract<Op, { op: 'move' | 'rename' | 'note' | 'status' }>;

function change(pair: Pair, op: Change): Pair {
  switch (op.op) {
    case 'move': {
      // A point that a person placed is one that the person stands for.
      const status = pair.status === 'proposed' ? 'confirmed' : pair.status;
      return { ...pair, [op.side]: op.point, status };
    }
    case 'rename':
      return { ...pair, name: op.name };
    case 'note':
      return { ...pair, note: op.note };
    case 'status':
      return { ...pair, status: op.status };
  }
}

function newPair(op: Extract<Op, { op: 'add' }>, pairs: readonly Pair[], id: number): Pair {
  return {
    id,
    number: Math.max(0, ...pairs.map((pair) => pair.number)) + 1,
    colour: nextColour(pairs),
    name: op.name ?? null,
    note: op.note ?? null,
    source: op.source ?? null,
    target: op.target ?? null,
    status: 'confirmed',
    confidence: null,
    origin: 'user',
    revision: 0,
  };
}

const COLOURS = 12;

/** The colour that the fewest pairs have. */
function nextColour(pairs: readonly Pair[]): number {
  const uses = new Array<number>(COLOURS).fill(0);
  for (const pair of pairs) uses[pair.colour % COLOURS] += 1;
  return uses.indexOf(Math.min(...uses));
}

function reorder(pairs: Pair[], id: number, before: number | null): Pair[] {
  const moved = pairs.find((pair) => pair.id === id);
  if (!moved) return pairs;
  const rest = pairs.filter((pair) => pair.id !== id);
  const place = before === null ? rest.length : rest.findIndex((pair) => pair.id === before);
  rest.splice(place < 0 ? rest.length : place, 0, moved);
  return rest;
}

/** The operation with temporary ids replaced by those that the server gave. */
export function renumberOp(op: Op, ids: ReadonlyMap<number, number>): Op {
  if (!('pair' in op)) return op;
  const { pair } = op;
  if (pair === undefined) return op;
  const renumbered = { ...op, pair: ids.get(pair) ?? pair };
  if (renumbered.op === 'reorder' && renumbered.before !== null) {
    renumbered.before = ids.get(renumbered.before) ?? renumbered.before;
  }
  return renumbered;
}
