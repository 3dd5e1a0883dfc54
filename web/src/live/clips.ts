import type { Studio } from '../app/studio.ts';
import type { Clip, Step } from '../protocol/types.ts';
import { select } from '../ui/controls.ts';
import { h } from '../ui/dom.ts';
import { notify } from '../ui/notices.ts';
import { effect, signal } from '../ui/signal.ts';
import { readStored, writeStored } from '../ui/storage.ts';
import { counted, listed } from '../ui/words.ts';
import { ALL, chosenClip, clipSetting, SEVERAL } from './clip.ts';

const SHAPES = '';

/** Sources that have shapes, over a reload too. */
const withShapes = signal<ReadonlySet<string>>(new Set(readStored<string[]>('with-shapes', [])));
effect(() => writeStored('with-shapes', [...withShapes.value].slice(-50)));

/** The clips of the source's file, where it holds several; another one becomes `source.poses` of the pipeline. */
export function clipChoice(studio: Studio): HTMLElement {
  const clips = () => studio.session.value?.poses?.clips ?? [];
  const areShapes = () => studio.session.value?.poses?.are === 'shapes';
  effect(() => {
    if (areShapes() && !withShapes.value.has(fileOf(studio)))
      withShapes.value = new Set([...withShapes.value, fileOf(studio)]);
  });
  const options = () => [
    ...(hasShapes(studio) ? [{ value: SHAPES, label: 'Shapes' }] : []),
    ...(present() === SEVERAL ? [{ value: SEVERAL, label: 'Several clips' }] : []),
    ...clips().map((clip) => ({ value: clip.name, label: describe(clip) })),
    ...(clips().length > 1 ? [{ value: ALL, label: `All ${counted(clips().length, 'clip')}` }] : []),
  ];
  const present = () => chosenClip(studio.session.value?.poses ?? null);
  const choice = select<string>({
    label: 'Clip',
    options,
    value: () => present() ?? SHAPES,
    change: (name) => {
      if (name === present()) return;
      tellOfReplacing(studio);
      if (name === SHAPES) return chooseShapes(studio);
      const { path, value } = clipSetting(studio.pipeline.pipeline.peek()?.value, name);
      void studio.pipeline.set(path as Step[], value);
    },
  });
  const element = h('span', { class: 'clip-choice', title: 'The clip whose motion is carried over' }, choice);
  effect(() => {
    // With nothing to choose the box would be empty or a riddle.
    element.hidden = options().length < 2;
    element.title = `The clip whose motion is carried over: ${options().find(({ value }) => value === (present() ?? SHAPES))?.label ?? 'none'}`;
  });
  return element;
}

/** Whether the source has shapes. Once a clip is chosen, the session no longer says it. */
export function hasShapes(studio: Studio): boolean {
  return studio.session.value?.poses?.are === 'shapes' || withShapes.value.has(fileOf(studio));
}

/** Shapes become the poses again in place of a clip. */
export function chooseShapes(studio: Studio): void {
  void studio.pipeline.unset(['source', 'poses']);
}

/** What a run has written is of the clip from before, and the next run writes to the same files. */
function tellOfReplacing(studio: Studio): void {
  const last = studio.runs.last();
  const names = (last?.result?.written ?? []).map((file) => file.name);
  if (last?.state !== 'done' || names.length === 0) return;
  notify(
    `The next run replaces ${listed(names)}.`,
    'To keep both, give `output` another name under Stages first, or choose all clips.',
    'info',
    'clip',
  );
}

/** The source, by which it is known again when a clip of it is chosen. */
function fileOf(studio: Studio): string {
  const source = studio.session.value?.source;
  return `${source?.file} ${source?.vertices}`;
}

function describe({ name, seconds, frames }: Clip): string {
  return `${name} · ${seconds.toFixed(2)} s, ${frames} frames`;
}
