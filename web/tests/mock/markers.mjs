// The document of markers as the protocol has it: merged by pair, with a history.
import { nextOrder } from './order.mjs';

export class MarkerDocument {
  constructor(pairs) {
    this.revision = 1;
    this.nextId = 1;
    this.past = [];
    this.future = [];
    this.done = new Map();
    this.pairs = [];
    for (const pair of pairs) this.pairs.push(this.make(pair));
  }

  make(pair) {
    const id = this.nextId++;
    return {
      id,
      number: Math.max(0, ...this.pairs.map((other) => other.number)) + 1,
      colour: (id - 1) % 12,
      name: null,
      note: null,
      source: null,
      target: null,
      status: 'confirmed',
      confidence: null,
      origin: 'user',
      revision: this.revision,
      respects: {},
      ...pair,
    };
  }

  view() {
    const pairs = this.pairs.map(({ respects, ...pair }) => pair);
    return {
      revision: this.revision,
      file: 'camel-from-horse.markers.yaml',
      exists: true,
      pairs,
      can_undo: this.past.length > 0,
      can_redo: this.future.length > 0,
      undo: this.past.at(-1)?.title ?? null,
      undo_order: this.past.at(-1)?.order ?? null,
      redo: this.future.at(-1)?.title ?? null,
      redo_order: this.future.at(-1)?.order ?? null,
      problems: [],
      disk: 'saved',
      disk_error: null,
    };
  }

  edit({ base, id, client, ops }) {
    if (this.done.has(id)) return this.done.get(id);
    const before = structuredClone(this.pairs);
    const conflicts = [];
    const added = [];
    this.revision += 1;
    ops.forEach((op, index) => {
      const pair = this.pairs.find((other) => other.id === op.pair) ?? null;
      const respect = op.op === 'move' ? op.side : op.op;
      const fail = (reason) => {
        conflicts.push({ op: index, pair: op.pair ?? null, reason, current: pair && { ...pair, respects: undefined } });
        if (op.op === 'add') added.push(null);
      };
      if (op.op === 'add') {
        const made = this.make({ name: op.name ?? null, source: op.source ?? null, target: op.target ?? null });
        this.pairs.push(made);
        added.push(made.id);
      } else if (op.op === 'mirror') {
        // The mock mirrors nothing.
      } else if (!pair) {
        if (op.op !== 'delete') fail('the pair was deleted');
      } else if (op.op === 'delete') {
        this.pairs = this.pairs.filter((other) => other !== pair);
      } else if (pair.respects[respect]?.revision > base && pair.respects[respect].client !== client) {
        fail('it was changed in another place');
      } else if (
        op.op === 'rename' &&
        op.name &&
        this.pairs.some((other) => other !== pair && other.name === op.name)
      ) {
        fail(`another pair is called ${op.name}`);
      } else {
        if (op.op === 'move') {
          pair[op.side] = op.point;
          if (pair.status === 'proposed') pair.status = 'confirmed';
        } else if (op.op === 'rename') pair.name = op.name;
        else if (op.op === 'note') pair.note = op.note;
        else if (op.op === 'status') pair.status = op.status;
        pair.respects[respect] = { revision: this.revision, client };
        pair.revision = this.revision;
      }
    });
    const named = before.find((other) => other.id === ops[0]?.pair);
    const title = `${ops[0]?.op} ${named ? (named.name ?? `point ${named.number}`) : 'a pair'}`;
    this.past.push({ pairs: before, title, order: nextOrder() });
    this.future = [];
    const result = {
      markers: this.view(),
      added,
      conflicts,
      mirrored: ops.some((op) => op.op === 'mirror')
        ? { added: 0, left: ops.filter((op) => op.pair).map(({ pair }) => ({ pair, reason: 'it lies on the plane' })) }
        : null,
    };
    this.done.set(id, result);
    return result;
  }

  step(from, to, base) {
    if (base !== this.revision || from.length === 0) {
      return {
        markers: this.view(),
        added: [],
        conflicts: [{ op: 0, pair: null, reason: 'the document has changed', current: null }],
        mirrored: null,
      };
    }
    const step = from.pop();
    to.push({ pairs: structuredClone(this.pairs), title: step.title, order: step.order });
    this.pairs = step.pairs;
    this.revision += 1;
    return { markers: this.view(), added: [], conflicts: [], mirrored: null };
  }
}
