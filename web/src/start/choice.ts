import type { Side } from '../protocol/types.ts';
import { signal } from '../ui/signal.ts';

/** The two files that a person has chosen so far, and the side that the next file fills. It outlives a file that cannot be read. */
export class FileChoice {
  readonly source = signal<string | null>(null);
  readonly target = signal<string | null>(null);
  readonly next = signal<Side>('source');

  /** The file goes to the selected side; then the other one is selected if it is empty. */
  choose(path: string): void {
    const side = this.next.peek();
    this[side].value = path;
    const other = side === 'source' ? 'target' : 'source';
    if (this[other].peek() === null) this.next.value = other;
  }

  clear(side: Side): void {
    this[side].value = null;
    this.next.value = side;
  }

  swap(): void {
    const [source, target] = [this.source.peek(), this.target.peek()];
    this.source.value = target;
    this.target.value = source;
    if (target === null) this.next.value = 'source';
    else if (source === null) this.next.value = 'target';
  }

  reset(): void {
    this.source.value = null;
    this.target.value = null;
    this.next.value = 'source';
  }

  /** Lets go of the files that `words` name; the others are good, as far as is known. */
  dropNamedIn(words: string): void {
    for (const side of ['target', 'source'] as const) {
      const path = this[side].peek();
      if (path !== null && words.includes(fileName(path))) this.clear(side);
    }
  }
}

export function fileName(path: string): string {
  return path.split(/[\\/]/).pop() ?? path;
}
