/**
 * Values that report their changes. An effect runs again when a signal that it read has changed. Effects that it made in a run end before
 * the next one, so what an effect draws anew leaves nothing behind.
 */

type Run = () => void;

interface Observer {
  run: Run;
  sources: Set<Set<Observer>>;
  inner: Observer[];
}

const MOST_ROUNDS = 100;

/** Hears of effects that threw; the page shows it to the person. */
let report: (error: unknown) => void = (error) => console.error(error);

let current: Observer | null = null;
let queue: Set<Observer> | null = null;

export class Signal<T> {
  private readonly observers = new Set<Observer>();
  private held: T;

  constructor(value: T) {
    this.held = value;
  }

  get value(): T {
    if (current) {
      this.observers.add(current);
      current.sources.add(this.observers);
    }
    return this.held;
  }

  set value(next: T) {
    if (Object.is(next, this.held)) return;
    this.held = next;
    this.changed();
  }

  /** The value, without being run again when it changes. */
  peek(): T {
    return this.held;
  }

  /** Changes the value in place, which a comparison could not see. */
  mutate(change: (value: T) => void): void {
    change(this.held);
    this.changed();
  }

  private changed(): void {
    for (const observer of this.observers) schedule(observer);
  }
}

export function signal<T>(value: T): Signal<T> {
  return new Signal(value);
}

/** Runs `run` now and after every change of a signal that it read; returns what stops it. */
export function effect(run: Run): () => void {
  const observer: Observer = { run, sources: new Set(), inner: [] };
  current?.inner.push(observer);
  execute(observer);
  return () => forget(observer);
}

/** A value that follows from signals. */
export function computed<T>(compute: () => T): { readonly value: T } {
  const result = new Signal<T>(undefined as T);
  effect(() => {
    result.value = compute();
  });
  return result;
}

/** Makes something whose effects outlive the run of the effect that is under way. */
export function detached<T>(make: () => T): T {
  const outer = current;
  current = null;
  try {
    return make();
  } finally {
    current = outer;
  }
}

/** Runs all effects that are due now; they run in a microtask otherwise. */
export function flush(): void {
  // An effect may set signals, so others become due; a bound keeps a circle from hanging the page.
  for (let round = 0; queue; round++) {
    const due = queue;
    queue = null;
    if (round === MOST_ROUNDS) throw new Error('effects set each other off without an end');
    for (const observer of due) attempt(observer);
  }
}

/** Says who hears of effects that threw. */
export function onEffectError(listener: (error: unknown) => void): void {
  report = listener;
}

/** One effect that throws does not keep the others from running. It runs again when something that it had read changes. */
function attempt(observer: Observer): void {
  try {
    execute(observer);
  } catch (error) {
    report(error);
  }
}

function schedule(observer: Observer): void {
  if (!queue) {
    queue = new Set();
    queueMicrotask(flush);
  }
  queue.add(observer);
}

function execute(observer: Observer): void {
  forget(observer);
  const outer = current;
  current = observer;
  try {
    observer.run();
  } finally {
    current = outer;
  }
}

function forget(observer: Observer): void {
  for (const source of observer.sources) source.delete(observer);
  observer.sources.clear();
  for (const inner of observer.inner.splice(0)) {
    forget(inner);
    // It may be due in this very round.
    inner.run = () => {};
  }
}
