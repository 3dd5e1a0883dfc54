import { readableIn } from '../ui/words.ts';

/** What a step did, in the past: `move nose` was `moved nose`. */
export function past(step: string): string {
  const [verb, ...rest] = step.split(' ');
  return readableIn([PAST[verb] ?? verb, ...rest].join(' '));
}

const PAST: Record<string, string> = {
  add: 'added',
  move: 'moved',
  take: 'took',
  rename: 'renamed',
  confirm: 'confirmed',
  doubt: 'doubted',
  skip: 'skipped',
  delete: 'deleted',
  reorder: 'moved',
  mirror: 'mirrored pairs',
  propose: 'proposed pairs',
  set: 'set',
  leave: 'left',
  edit: 'edited',
};
